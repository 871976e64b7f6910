"""Clean the table by what the camera sees, wherever a person left the blocks.

The screen shows white, then black; what stays dark on it are blocks. Each that is
recognised goes to a free slot of its kind and colour. The ledger cannot know what a
person moved, so a slot that it has filled is felt with the fingers first. Blocks that
touch, stand half outside or are no toy are left alone and reported.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cell.errors import CellError, StoreError, VisionError
from cell.geometry import PlaneMap
from cell.ledger import Ledger
from cell.manipulation import Manipulator, Progress
from cell.profile import Profile
from cell.store import StorePlan, TablePlace
from cell.vision import SeenBlock, locate


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureCleaning:
    """What a cleaning by picture came to.

    Attributes:
        home: Slot numbers of the blocks brought home.
        left: What was seen and left where it is, a sentence each.
    """

    home: tuple[int, ...]
    left: tuple[str, ...]


def seeing_camera(profile: Profile) -> tuple[str, PlaneMap]:
    """Return the camera whose pictures can be mapped to the table, and its map.

    Raises:
        VisionError: No camera of the profile has a plane map.
    """
    for name, camera in profile.cameras.items():
        if camera.plane_map is not None:
            return name, PlaneMap(camera.plane_map)
    raise VisionError("no camera of the profile has a plane_map; calibrate the top camera first")


def bring_home(
    seen: Sequence[SeenBlock],
    plane_map: PlaneMap,
    manipulator: Manipulator,
    ledger: Ledger,
    plan: StorePlan,
    progress: Progress,
) -> PictureCleaning:
    """Bring every recognised block to a slot of its kind and colour."""
    home: list[int] = []
    left: list[str] = []
    for done, block in enumerate(seen):
        progress("putting back", done, len(seen))
        place = locate(block, plane_map)
        where = f"({place.x_mm:.0f}, {place.y_mm:.0f}) mm"
        if block.kind is None or block.colour is None:
            left.append(f"something of no known kind or colour at {where}")
            continue
        try:
            slot = _slot_for(block.kind, block.colour, place, manipulator, ledger, plan, home)
            manipulator.transfer(slot, place, None)
            home.append(slot)
        except CellError as error:
            left.append(f"{block.colour} {block.kind} at {where}: {error}")
    progress("putting back", len(seen), len(seen))
    return PictureCleaning(home=tuple(home), left=tuple(left))


def _slot_for(
    kind: str,
    colour: str,
    place: TablePlace,
    manipulator: Manipulator,
    ledger: Ledger,
    plan: StorePlan,
    taken: Sequence[int],
) -> int:
    """Return the slot to bring a block to.

    First of those that the ledger has out, the nearest; then one whose block was lost; then
    the lowest in which the fingers feel nothing.

    Raises:
        StoreError: There is no such slot.
    """
    slots = [s.number for s in plan.slots_of(kind, colour) if s.number not in taken]
    out = ledger.blocks_out()
    known = [number for number in slots if number in out]
    if known:
        return min(
            known, key=lambda n: math.hypot(out[n].x_mm - place.x_mm, out[n].y_mm - place.y_mm)
        )
    strays = ledger.strays()
    lost = [number for number in slots if number in strays]
    if lost:
        return lost[0]
    for number in slots:
        if not manipulator.feels_block(number):
            return number
    raise StoreError(f"the store has no free slot for a {colour} {kind}")
