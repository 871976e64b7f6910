"""What ties the screen to the robot: blocks that the arm places, or points that it touches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.homography.finding import Expected, ObjectNotFound, Seen, find_object, on_screen
from calibration.homography.planning import corners
from calibration.procedure import (
    Steps,
    ask_done,
    ask_number,
    ask_numbers,
    ask_whole,
    capture,
    put_block,
    read_tool,
    return_block,
    show,
    stand_aside,
)
from calibration.reach import TableReach
from calibration.screen.joint_fit import PlacedBlock, ScreenPlace, Touch
from calibration.screen.patterns import Panel
from calibration.verdict import Finding, Grade
from cell.geometry import CameraView
from cell.profile import Profile
from cell.store import TablePlace

Points = NDArray[np.float64]

_BLOCKS: Final = 6
_FEWEST: Final = 2
_MOST_BLOCKS: Final = 9
_STEEPEST_DEG: Final = 20.0
"""A camera that looks at the table flatter than this sees the sides of blocks."""

_CREEP: Final = math.sqrt(1.5)
"""Scatter of a placed block over that of letting go once: across the fingers' gap the last
release counts, along the fingers the last two."""

_LEAST_FINDING_PX: Final = 0.1
CROSS_PX: Final = ((240, 160), (1680, 160), (1680, 920), (240, 920), (960, 540))
"""Column and row of each cross that is touched."""

_ARM_PX: Final = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class Ties:
    """What was measured.

    Attributes:
        touches: Touched or typed points.
        blocks: Placed blocks.
        findings: What went wrong.
        pictures: Digest of a picture of each block, by its label.
    """

    touches: tuple[Touch, ...] = ()
    blocks: tuple[PlacedBlock, ...] = ()
    findings: tuple[Finding, ...] = ()
    pictures: Mapping[str, str] = field(default_factory=dict)


def ways(site: Site) -> tuple[str, ...]:
    """Return how the screen of a cell can be tied to its robot, the best first."""
    profile = site.profile
    if not isinstance(profile, Profile):
        return ("none",)
    can_place = (
        profile.arm.enabled
        and profile.gripper.enabled
        and profile.manipulation.enabled
        and _object_slot(site, profile) is not None
    )
    touch = ("touch",) if profile.arm.enabled else ()
    return (*(("blocks",) if can_place else ()), *touch, "type", "none")


def no_ties() -> Ties:
    """Return nothing: the profile's place of the screen is taken."""
    return Ties()


def tied_by_touch(profile: Profile, panel: Panel, *, is_typed: bool) -> Steps[Ties]:
    """Have crosses touched by the tool point, or their robot coordinates typed."""
    deviation_mm = yield from ask_number(
        "touch deviation",
        "How exactly is a cross met, along each axis?",
        unit="mm",
        default=0.5,
    )
    touches = []
    for index, (column, row) in enumerate(CROSS_PX):
        label = f"cross {index + 1}"
        yield from show(label, _cross(panel, column, row))
        if is_typed:
            x, y = yield from ask_numbers(
                label, "Robot x and y of the cross on the screen?", count=2, unit="mm"
            )
        else:
            yield from ask_done(label, "Bring the tool's point onto the cross on the screen")
            pose = (yield from read_tool()).pose
            x, y = pose.x_mm, pose.y_mm
        touches.append(
            Touch(
                label=label,
                place_px=(float(column), float(row)),
                robot_mm=(x, y),
                deviation_mm=deviation_mm,
            )
        )
    if not is_typed:
        yield from stand_aside()
    return Ties(touches=tuple(touches))


def ask_block_count() -> Steps[int]:
    """Ask at how many places the block shall be put."""
    return (
        yield from ask_whole(
            "blocks",
            "At how many places shall the block be put?",
            low=_FEWEST,
            high=_MOST_BLOCKS,
            default=_BLOCKS,
        )
    )


def tied_by_blocks(
    site: Site, profile: Profile, panel: Panel, lone: Mapping[str, CameraView], count: int
) -> Steps[Ties]:
    """Have the arm place the calibration object, and find it with the cameras above it.

    Args:
        site: The cell.
        profile: Its profile.
        panel: The grey values to light the screen with.
        lone: The cameras in the screen's frame.
        count: At how many places the block is put.

    Raises:
        CalibrationError: There is no calibration object, or no camera looks down.
    """
    slot = _object_slot(site, profile)
    if slot is None or profile.store.calibration is None:
        raise CalibrationError("the store has no calibration object (store.calibration)")
    above = tuple(name for name, view in lone.items() if _tilt_deg(view) < _STEEPEST_DEG)
    if not above:
        raise CalibrationError(
            "no camera looks down steeply enough to see the top of a block; tie the screen by "
            "touched points"
        )
    deviation_mm = yield from ask_number(
        "placing deviation",
        "How exactly does a block that is let go come to lie, along each axis?",
        unit="mm",
        default=0.3,
    )
    size = profile.blocks[profile.store.calibration.kind]
    blocks: list[PlacedBlock] = []
    findings: list[Finding] = []
    pictures: dict[str, str] = {}
    for index, (x_mm, y_mm) in enumerate(_places(profile, count)):
        label = f"block {index + 1}"
        # Fingers centre a block across their gap only: turned every other time, it does not
        # creep along them from place to place.
        turn_deg = 90.0 * (index % 2)
        yield from put_block(slot, TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=turn_deg))
        yield from stand_aside()
        seen: dict[str, Seen] = {}
        lit, dark = {}, {}
        yield from show("bright", panel.field(panel.bright))
        for camera in above:
            lit[camera] = yield from capture(camera, f"{label}, screen lit")
        yield from show("black", panel.field(0))
        for camera in above:
            dark[camera] = yield from capture(camera, f"{label}, screen black")
        for camera in above:
            expected = _expected(
                profile, lone[camera], (x_mm, y_mm), size.length_mm, size.height_mm
            )
            try:
                levels = on_screen(lit[camera].pixels, dark[camera].pixels)
                seen[camera] = find_object(levels, expected)
            except ObjectNotFound as lost:
                findings.append(_lost(label, camera, lost.finding))
            else:
                pictures[label] = lit[camera].digest
        if seen:
            blocks.append(
                PlacedBlock(
                    label=label,
                    robot_mm=(x_mm, y_mm),
                    height_mm=size.height_mm,
                    deviation_mm=_CREEP * deviation_mm,
                    seen_px={name: (one.u_px, one.v_px) for name, one in seen.items()},
                    finding_px=max(_LEAST_FINDING_PX, *(one.deviation_px for one in seen.values())),
                )
            )
    yield from return_block(slot)
    if len(blocks) < _FEWEST:
        findings.append(
            Finding(
                code="blocks-not-found",
                grade=Grade.BAD,
                text=f"{len(blocks)} of {count} placed blocks were found, {_FEWEST} are needed",
                hint="see whether the arm really brings the block, and the camera's picture",
            )
        )
    return Ties(blocks=tuple(blocks), findings=tuple(findings), pictures=pictures)


def _places(profile: Profile, count: int) -> tuple[tuple[float, float], ...]:
    """Return corners of the playground first, then the middles between them and the centre."""
    corner = corners(TableReach(profile).why_not_lay)
    ring = [*corner]
    for order in (1, 3, 0, 2):
        a, b = corner[order], corner[(order + 1) % 4]
        ring.append((0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])))
    middle = np.mean(np.array(corner), axis=0)
    ring.append((float(middle[0]), float(middle[1])))
    return tuple(ring[:count])


def _expected(
    profile: Profile,
    view: CameraView,
    at_mm: tuple[float, float],
    width_mm: float,
    height_mm: float,
) -> Expected:
    """Return where a camera, in the screen's frame, should see a block, by the profile."""
    display = profile.display
    screen = ScreenPlace(
        corner_mm=(display.corner_x_mm, display.corner_y_mm),
        angle_deg=display.angle_deg,
        height_mm=0.0,
        pixel_mm=display.pixel_mm,
    )
    inverse = screen.robot_from_screen().inverse()
    flat = inverse.rotation[:2, :2] @ np.array(at_mm) + inverse.translation_mm[:2]
    around = np.array([flat, flat + (0.5 * width_mm, 0.0)])
    centre, edge = view.to_picture(around, -height_mm)
    eye = view.robot_from_camera.translation_mm
    below = view.to_picture(eye[:2], -height_mm)
    return Expected(
        centre_px=(float(centre[0]), float(centre[1])),
        radius_px=float(np.hypot(*(edge - centre))),
        below_px=(float(below[0]), float(below[1])),
    )


def _lost(label: str, camera: str, finding: Finding) -> Finding:
    return finding.model_copy(
        update={
            "grade": Grade.DEGRADED,
            "text": f"{label}, camera {camera}: {finding.text}",
            "samples": (label,),
        }
    )


def _tilt_deg(view: CameraView) -> float:
    """Return how far a camera's view is from straight down, in the screen's frame."""
    down = float(view.robot_from_camera.rotation[2, 2])
    return math.degrees(math.acos(min(max(down, -1.0), 1.0)))


def _object_slot(site: Site, profile: Profile) -> int | None:
    known = profile.store.calibration
    return None if known is None or site.plan is None else known.number


def _cross(panel: Panel, column: int, row: int) -> NDArray[np.uint8]:
    pixels = panel.field(0)
    bright = panel.bright
    pixels[row - _ARM_PX : row + _ARM_PX + 1, column] = bright
    pixels[row, column - _ARM_PX : column + _ARM_PX + 1] = bright
    return pixels
