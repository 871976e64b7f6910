"""What lies where on the store's sheet: slots, markers, rulers and title.

Blocks stand in the slots while the sheet is read, so markers keep off the slots and their
labels. The layout follows from the plan alone; the same plan gives the same sheet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cell.profile import BlockProfile
from cell.sheet.errors import SheetError
from cell.sheet.fiducials import MODULES, MOST, Fiducial, identity_of, marker_id
from cell.sheet.fonts import text_width_mm
from cell.sheet.room import Area, Room
from cell.store import StoreSlot

EDGE_MM = 1.5
"""White between the outermost block and the sheet's edge: the sheet ends at the screen."""
LEAST_SIZE_MM = (300, 180)
"""Smallest sheet, so that title, rulers and markers have room on a small plan."""
LARGEST_MM = 2000
"""Longest side of a sheet; no arm of these cells reaches across a longer one."""
LABEL_MM = 3.6
RULER_MM = 100.0

_CLEAR_MM = 5.0
"""How far everything keeps off blocks, which hide what is close behind them."""
_TITLE_MM = (230, 21)
_SMALL_TITLE_MM = (120, 21)
_RULER_BOX_MM = (112, 13)
_MARKER_SIZES_MM = (42, 36, 30, 24)
_ENOUGH = 8
_LEAST = 4
_APART = 1.5
"""Least distance of two markers' middles, in sides."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedSlot:
    """A slot as it is printed.

    Attributes:
        slot: The slot.
        size: The block that stands there.
        label: What stands above it.
    """

    slot: StoreSlot
    size: BlockProfile
    label: str

    @property
    def outline(self) -> Area:
        """The block's bounding rectangle: its length along plan x, its width along plan y."""
        size, slot = self.size, self.slot
        across = size.length_mm if size.shape == "cylinder" else size.width_mm
        return Area(
            x_mm=slot.x_mm - size.length_mm / 2,
            y_mm=slot.y_mm - across / 2,
            width_mm=size.length_mm,
            height_mm=across,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SheetLayout:
    """Where everything of a sheet lies, in plan millimetres.

    Attributes:
        width_mm: Width of the sheet.
        height_mm: Height of the sheet.
        identity: Checksum of the plan.
        slots: The slots.
        fiducials: The markers, row by row.
        title: Room for the title; None where there is none.
        ruler_x: Room for the ruler along plan x.
        ruler_y: Room for the ruler along plan y.
        missing: What found no room or lies over the edge, as sentences.
    """

    width_mm: int
    height_mm: int
    identity: str
    slots: tuple[PrintedSlot, ...]
    fiducials: tuple[Fiducial, ...]
    title: Area | None
    ruler_x: Area | None
    ruler_y: Area | None
    missing: tuple[str, ...]


def lay_out(slots: Sequence[StoreSlot], blocks: Mapping[str, BlockProfile]) -> SheetLayout:
    """Return the layout of a plan's sheet.

    Args:
        slots: The places of the plan.
        blocks: Sizes of the kinds of blocks.

    Raises:
        SheetError: A slot's kind has no size.
    """
    printed = tuple(_printed(slot, blocks) for slot in slots)
    outlines = [one.outline for one in printed]
    right = max((o.x_mm + o.width_mm for o in outlines), default=0.0) + EDGE_MM
    low = max((o.y_mm + o.height_mm for o in outlines), default=0.0) + EDGE_MM
    wide = min(max(math.ceil(right - 1e-9), LEAST_SIZE_MM[0]), LARGEST_MM)
    tall = min(max(math.ceil(low - 1e-9), LEAST_SIZE_MM[1]), LARGEST_MM)
    room = Room(wide, tall)
    for one in printed:
        room.take(_grown(one.outline, _CLEAR_MM))
        room.take(label_area(one))
    _take_edge(room, wide, tall)
    missing = [
        f"slot {one.slot.number} at ({one.slot.x_mm:g}, {one.slot.y_mm:g}) lies over the sheet's "
        f"edge; a sheet goes from 0 to {LARGEST_MM} mm at most"
        for one in printed
        if not _is_on(one.outline, wide, tall)
    ]
    title = _placed(room, _TITLE_MM, (14, 2)) or _placed(room, _SMALL_TITLE_MM, (14, 2))
    ruler_x = _placed(room, _RULER_BOX_MM, (wide - _RULER_BOX_MM[0] - 2, 2))
    ruler_y = _placed(room, _RULER_BOX_MM[::-1], (2, (tall - _RULER_BOX_MM[0]) / 2))
    wanted = (("title", title), ("ruler along x", ruler_x), ("ruler along y", ruler_y))
    missing += [
        f"there is no room for the {what}; set the slots further apart"
        for what, place in wanted
        if place is None
    ]
    identity = identity_of(slots, blocks)
    fiducials = _fiducials(room, wide, tall, identity)
    if len(fiducials) < _LEAST:
        missing.append(
            f"there is room for {len(fiducials)} markers, and {_LEAST} are needed to find the "
            "sheet; set the slots further apart"
        )
    return SheetLayout(
        width_mm=wide,
        height_mm=tall,
        identity=identity,
        slots=printed,
        fiducials=fiducials,
        title=title,
        ruler_x=ruler_x,
        ruler_y=ruler_y,
        missing=tuple(missing),
    )


def label_area(printed: PrintedSlot) -> Area:
    """Return where the label of a slot is, above it."""
    outline = printed.outline
    wide = max(text_width_mm(printed.label, LABEL_MM), outline.width_mm)
    return Area(
        x_mm=outline.x_mm,
        y_mm=outline.y_mm - 1.2 - LABEL_MM,
        width_mm=wide,
        height_mm=LABEL_MM + 1.2,
    )


def _printed(slot: StoreSlot, blocks: Mapping[str, BlockProfile]) -> PrintedSlot:
    size = blocks.get(slot.kind)
    if size is None:
        raise SheetError(
            f"slot {slot.number} is for a {slot.kind}, and the profile has no size of it; add "
            f"blocks.{slot.kind} to the profile (it has {', '.join(sorted(blocks))})"
        )
    return PrintedSlot(slot=slot, size=size, label=f"{slot.number} {slot.kind} {slot.colour}")


def _is_on(area: Area, wide: int, tall: int) -> bool:
    right, low = area.x_mm + area.width_mm, area.y_mm + area.height_mm
    return area.x_mm >= 0 and area.y_mm >= 0 and right <= wide and low <= tall


def _grown(area: Area, by_mm: float) -> Area:
    return Area(
        x_mm=area.x_mm - by_mm,
        y_mm=area.y_mm - by_mm,
        width_mm=area.width_mm + 2 * by_mm,
        height_mm=area.height_mm + 2 * by_mm,
    )


def _take_edge(room: Room, wide: int, tall: int) -> None:
    """Keep the outermost millimetre for the sheet's outline."""
    for x, y, width, height in (
        (0, 0, wide, 1), (0, tall - 1, wide, 1), (0, 0, 1, tall), (wide - 1, 0, 1, tall),
    ):  # fmt: skip
        room.take(Area(x_mm=x, y_mm=y, width_mm=width, height_mm=height))


def _placed(room: Room, size_mm: tuple[int, int], near_mm: tuple[float, float]) -> Area | None:
    found = room.find(*size_mm, near_mm)
    if found is not None:
        room.take(found)
    return found


def _fiducials(room: Room, wide: int, tall: int, identity: str) -> tuple[Fiducial, ...]:
    """Return the markers in the largest size of which enough have room."""
    best: list[tuple[float, float]] = []
    size = _MARKER_SIZES_MM[0]
    for one in _MARKER_SIZES_MM:
        found = _spread(room, wide, tall, one)
        if len(found) > len(best):
            best, size = found, one
        if len(best) >= _ENOUGH:
            break
    best.sort(key=lambda place: (place[1], place[0]))
    return tuple(
        Fiducial(index=i, marker_id=marker_id(identity, i), x_mm=x, y_mm=y, size_mm=size)
        for i, (x, y) in enumerate(best)
    )


def _spread(room: Room, wide: int, tall: int, size_mm: int) -> list[tuple[float, float]]:
    """Return middles of markers: near the corners first, then farthest from all before."""
    quiet = math.ceil(size_mm / MODULES)
    box = size_mm + 2 * quiet
    y, x = room.corners(box, box)
    if x.size == 0:
        return []
    x, y = x + box / 2, y + box / 2
    chosen: list[tuple[float, float]] = []
    distance = np.full(x.shape, np.inf)
    corners = [(0, 0), (wide, tall), (wide, 0), (0, tall)]
    while len(chosen) < MOST:
        if corners:
            corner = corners.pop(0)
            pick = int(np.argmin((x - corner[0]) ** 2 + (y - corner[1]) ** 2))
        else:
            pick = int(np.argmax(distance))
            if distance[pick] < max(_APART * size_mm, box):
                break
        if distance[pick] < box:
            continue
        chosen.append((float(x[pick]), float(y[pick])))
        distance = np.minimum(distance, np.hypot(x - x[pick], y - y[pick]))
    return chosen
