"""The procedure `gripper-camera`: lens and mount of the camera on the arm's flange."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.lens.judging import sharpness
from calibration.lens.procedure import ask_board
from calibration.mount.fit import ArmNoise
from calibration.mount.model import MountState, MountView
from calibration.mount.planning import Poses
from calibration.mount.result import judged
from calibration.mount.targets import Target, board_target, screen_target, sheet_target
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_done,
    ask_number,
    ask_numbers,
    capture,
    light,
    move_tool,
    read_tool,
    show,
    stand_aside,
    tell,
)
from calibration.requests import Picture, ToolReading
from calibration.screen.patterns import Panel
from calibration.verdict import Finding, Grade
from cell.geometry import Pose, Transform
from cell.profile import Profile
from cell.sheet import lay_out
from cell.store import with_calibration_object

_POSES: Final = 14
_TRIES: Final = 2
_SHARP: Final = 0.08


@dataclass(slots=True, kw_only=True)
class Looked:
    """What was gathered.

    Attributes:
        views: Views of the target.
        pictures: Digests of the pictures by view.
        findings: What was wrong with some.
    """

    views: list[MountView] = field(default_factory=list)
    pictures: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)


def calibrate_mount(site: Site) -> Procedure:
    """Calibrate the camera on the flange: lens and mount, by several poses over a target.

    Raises:
        CalibrationError: The cell has no such camera, or the answers cannot be.
    """
    profile = playground_of(site)
    camera = yield from ask_camera(profile)
    target = yield from ask_target(site, profile)
    guess = yield from ask_guess(profile, camera, target)
    noise = yield from ask_noise()
    count = yield from ask_number("poses", "From how many poses?", default=float(_POSES))
    if not 3.0 <= count <= 60.0 or count != int(count):
        raise CalibrationError(f"poses: 3 to 60 can be taken, not {count:g}")
    quality_mm = yield from ask_number(
        "quality", "How good shall it be on the table?", unit="mm", default=0.5
    )
    yield from prepare(profile, target)
    looked = yield from look(profile, camera, target, guess, noise, int(count))
    yield from stand_aside()
    return judged(
        camera, target.name, looked.views, noise,
        surface_mm=profile.heights.surface_mm, quality_mm=quality_mm,
        pictures=looked.pictures, findings=looked.findings,
    )  # fmt: skip


def playground_of(site: Site) -> Profile:
    """Return the profile of a cell whose arm carries a camera.

    Raises:
        CalibrationError: It is no such cell.
    """
    if not isinstance(site.profile, Profile):
        raise CalibrationError(
            f"the cell {site.profile.name} has no camera on a flange to calibrate this way"
        )
    return site.profile


def ask_camera(profile: Profile) -> Steps[str]:
    """Ask which camera hangs on the flange."""
    names = tuple(profile.cameras)
    if not names:
        raise CalibrationError(f"the cell {profile.name} has no cameras")
    hung = [name for name in names if profile.cameras[name].mount is not None]
    told = [name for name in names if profile.cameras[name].fixed_to == "arm"]
    default = (hung or told or list(names))[0]
    return (
        yield from ask_choice("camera", "Which camera hangs on the flange?", names, default=default)
    )


def ask_target(site: Site, profile: Profile) -> Steps[Target]:
    """Ask what is looked at."""
    surface_mm = profile.heights.surface_mm
    has_store = site.plan is not None and bool(site.plan.slots)
    name = yield from ask_choice(
        "target",
        "What does it look at: a board on the screen, the store's printed sheet, or a printed "
        "board on the table?",
        ("screen", *(("sheet",) if has_store else ()), "board"),
        default="screen",
    )
    if name == "screen":
        return screen_target(profile.display, surface_mm)
    if name == "sheet" and site.plan is not None:
        plan = with_calibration_object(site.plan, profile.store)
        return sheet_target(lay_out(plan.slots, profile.blocks), profile.store, surface_mm)
    board = yield from ask_board()
    x, y, angle = yield from ask_numbers(
        "board-place",
        "Roughly robot x, y (mm) of the board's upper left corner, and the direction of its upper "
        "edge (deg)?",
        count=3,
        default=(330.0, -160.0, 90.0),
    )
    return board_target(board, (x, y, angle), surface_mm)


def ask_guess(profile: Profile, camera: str, target: Target) -> Steps[MountState]:
    """Ask roughly where the camera hangs; it only decides where to look from."""
    known, drawn = profile.cameras[camera], profile.twin.cameras.get(camera)
    position, rotation, focal = (100.0, 0.0, 50.0), (-20.0, 0.0, 90.0), 1000.0
    if drawn is not None and known.fixed_to == "arm":
        position, rotation, focal = drawn.position_mm, drawn.rotation_deg, drawn.focal_px
    if known.mount is not None:
        position, rotation = known.mount.position_mm, known.mount.rotation_deg
    if known.lens is not None:
        focal = known.lens.focal_px[0]
    x, y, z = yield from ask_numbers(
        "mount-position",
        "Roughly where is the lens in the flange's frame? It only decides where to look from",
        count=3, unit="mm", default=position,
    )  # fmt: skip
    a, b, c = yield from ask_numbers(
        "mount-rotation", "Roughly how is it turned there (A, B, C)?",
        count=3, unit="deg", default=rotation,
    )  # fmt: skip
    focal = yield from ask_number("focal", "Roughly its focal length?", unit="px", default=focal)
    if focal <= 0:
        raise CalibrationError(f"focal: {focal:g} px is not above 0")
    return MountState(
        lens=np.array([focal, 639.5, 479.5, 0.0, 0.0]),
        flange_from_camera=Transform.from_pose(Pose(x, y, z, a, b, c)),
        targets=(target.guess,),
    )


def ask_noise() -> Steps[ArmNoise]:
    """Ask how exact the arm is."""
    usual = ArmNoise()
    position = yield from ask_number(
        "arm-position", "How exactly is the arm where it says (standard deviation)?",
        unit="mm", default=usual.position_mm,
    )  # fmt: skip
    angle = yield from ask_number(
        "arm-angle", "And how exactly is its hand turned as it says?",
        unit="deg", default=usual.angle_deg,
    )  # fmt: skip
    if position <= 0 or angle <= 0:
        raise CalibrationError("arm-position, arm-angle: no arm is exact; give figures above 0")
    return ArmNoise(position_mm=position, angle_deg=angle)


def prepare(profile: Profile, target: Target) -> Steps[None]:
    """Have the target shown or laid, and light for it."""
    if target.name == "the board on the screen":
        # Lamps shine from the glass; the screen gives its own light.
        yield from light(is_on=False)
        panel = Panel(width_px=profile.display.width_px, height_px=profile.display.height_px)
        yield from show("mount board", panel.board())
        return
    yield from light(is_on=True)
    yield from ask_done("target-laid", f"See that {target.name} lies flat and in view.")


def look(
    profile: Profile,
    camera: str,
    target: Target,
    guess: MountState,
    noise: ArmNoise,
    count: int,
    *,
    aside_deg: float = 0.0,
) -> Steps[Looked]:
    """Go from pose to pose and look, until there are `count` views.

    Up to twice as many poses are tried, because in some the target may be hidden.

    Args:
        profile: The cell's profile.
        camera: Name of the camera.
        target: What it looks at.
        guess: Roughly lens and mount.
        noise: How exact the arm is.
        count: How many views are wanted.
        aside_deg: How far the camera is turned about its view from the usual poses.
    """
    looked = Looked()
    poses = Poses(profile, target, guess, noise, aside_deg=aside_deg)
    reading = yield from read_tool()
    for number in range(1, _TRIES * count + 1):
        pose = poses.next(reading.joints)
        if pose is None:
            break
        yield from tell(f"pose {number}", len(looked.views), count)
        reading = yield from move_tool(pose, by_joints=True)
        picture = yield from capture(camera, f"{target.name}, pose {number}")
        _take(looked, f"pose {number}", reading, picture, target, poses)
        if len(looked.views) >= count:
            break
    return looked


def _take(
    looked: Looked, label: str, reading: ToolReading, picture: Picture, target: Target, poses: Poses
) -> None:
    points, pixels = target.find(picture.pixels)
    looked.pictures[label] = picture.digest
    sharp = sharpness(picture.pixels)
    if sharp < _SHARP:
        looked.findings.append(
            Finding(
                code="blurred",
                grade=Grade.DEGRADED,
                text=f"{label} is blurred: edges are about {1 / max(sharp, 1e-3):.0f} px wide; it "
                "is left out",
                hint="focus the lens, wait until the arm stands, or add light for a shorter "
                "shutter",
                samples=(label,),
            )
        )
        return
    if len(pixels) < target.least:
        looked.findings.append(
            Finding(
                code="target-not-seen",
                grade=Grade.DEGRADED,
                text=f"{label} shows {len(pixels)} points of {target.name}, {target.least} are "
                "needed; it is left out",
                hint="see that it is where the profile has it, lit and uncovered, and that camera "
                "and rough mount are those of this cell",
                samples=(label,),
            )
        )
        return
    looked.views.append(
        MountView(
            label=label, robot_from_flange=poses.flange(reading.pose), points_mm=points,
            pixels=pixels,
        )
    )  # fmt: skip
