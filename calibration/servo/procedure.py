"""The procedure `servo-maps`: the arm is commanded, a camera sees the marker on its hand.

Sweeps of one joint at a time first, then poses at different reach, then where the gripper is
known worst. Commands and sights are typed or come from a file.
"""

from __future__ import annotations

from typing import Final

from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.procedure import Procedure, Steps, ask_choice, ask_number, ask_numbers, tell
from calibration.record import CalibrationRecord
from calibration.servo.checking import LIMIT_MM, checked, correction_of
from calibration.servo.fitting import fit_servos
from calibration.servo.judge import mount_for, next_pose, sweep_plan
from calibration.servo.measurement import measure_servos
from calibration.servo.samples import BACK, TOP, MarkerNoise, Mount, Sight
from cell.geometry import Pose, Transform
from cell.kinematics.lynx import LynxArm
from cell.kinematics.servo_map import ArmCorrection, Five
from cell.profile.lynx import LynxProfile

_MOST: Final = 500
_LEAST: Final = 30
_CHECKED: Final = 6
_LAST: Final = 6
"""How many of the last sights are asked for where the gripper is known worst."""


def servo_maps(site: Site) -> Procedure:
    """Measure where the arm's servos really go, and how it sags.

    Raises:
        CalibrationError: The cell's arm has no servos that need it.
        FitFailed: What was measured tells too little.
    """
    arm = _arm(site)
    mounts = yield from _mounts()
    noise = yield from _noise()
    plan = sweep_plan(arm)
    count = yield from _count("sights", "How many poses will be taken", len(plan) + _LAST, _LEAST)
    sights: list[Sight] = []
    for number in range(1, count + 1):
        yield from tell(f"pose {number} of {count}", number - 1, count)
        advised = _advised(number, count, plan, sights, arm, mounts, noise)
        sights.append((yield from _sight("sight", number, advised, sights)))
    fresh: list[Sight] = []
    extra = yield from _count("fresh", "How many more poses will be taken to check", 0, 0)
    for number in range(1, extra + 1):
        fresh.append((yield from _sight("fresh", number, None, [])))
    return measure_servos(sights, arm, fresh=fresh, mounts=mounts, noise=noise)


def check_servo_maps(site: Site, record: CalibrationRecord) -> Procedure:
    """Check servo maps: the arm is commanded to fresh poses, a camera sees the marker.

    Raises:
        CalibrationError: The cell's arm has no servos, or the record holds no maps.
    """
    arm = _arm(site)
    correction = correction_of(record)
    limit_mm = yield from ask_number(
        "limit", "Up to which miss of the marker is it good?", unit="mm", default=LIMIT_MM
    )
    mounts = yield from _mounts()
    noise = yield from _noise()
    count = yield from _count("fresh", "How many poses will be taken to check", _CHECKED, 1)
    plan = _inside(sweep_plan(arm), correction)
    sights = []
    for number in range(1, count + 1):
        yield from tell(f"pose {number} of {count}", number - 1, count)
        advised = plan[(number - 1) * len(plan) // count] if plan else None
        sights.append((yield from _sight("fresh", number, advised, [])))
    return checked(record, arm.geometry, sights, mounts, noise, limit_mm)


def _arm(site: Site) -> LynxArm:
    profile = site.profile.arm
    if not isinstance(profile, LynxProfile):
        raise CalibrationError(
            f"the arm of {site.profile.name} is a {profile.model}; servo maps are measured on a "
            "lynx-al5d, whose hobby servos do not tell where they are (such as `--profile lynx`)"
        )
    return LynxArm.from_profile(profile)


def _inside(plan: tuple[Five, ...], correction: ArmCorrection) -> tuple[Five, ...]:
    """Return the poses of a plan at which every servo was measured."""
    ranges = [one.commanded_range_deg for one in correction.maps]
    return tuple(
        pose
        for pose in plan
        if all(low <= angle <= high for angle, (low, high) in zip(pose, ranges, strict=True))
    )


def _mounts() -> Steps[tuple[Mount, ...]]:
    mounts = []
    for usual, where in (
        (BACK, "behind the fingers, facing back along the hand"),
        (TOP, "on the upper side of the hand when it is level"),
    ):
        pose = usual.tool_from_marker.to_pose()
        x, y, z, a, b, c = yield from ask_numbers(
            f"mount-{usual.name}",
            f"Where in the tool's frame is the marker {where}: x, y, z (mm), a, b, c (deg)?",
            count=6,
            default=(pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg),
        )
        frame = Transform.from_pose(Pose(x, y, z, a, b, c))
        mounts.append(Mount(name=usual.name, tool_from_marker=frame))
    return tuple(mounts)


def _noise() -> Steps[MarkerNoise]:
    usual = MarkerNoise()
    values = yield from ask_numbers(
        "marker-noise",
        "How exactly is the marker seen: x and y (mm), height (mm), turn (deg), lean (deg)? "
        "Height or lean 0: not to be used",
        count=4,
        default=(usual.place_mm, usual.height_mm or 0.0, usual.yaw_deg, usual.tilt_deg or 0.0),
    )
    place, height, yaw, tilt = values
    if min(place, yaw) <= 0.0 or min(height, tilt) < 0.0:
        raise CalibrationError(
            "marker-noise: place and turn need a noise above 0, height and lean 0 or above"
        )
    return MarkerNoise(place_mm=place, height_mm=height or None, yaw_deg=yaw, tilt_deg=tilt or None)


def _sight(word: str, number: int, advised: Five | None, earlier: list[Sight]) -> Steps[Sight]:
    key = f"{word}-{number}"
    commanded = yield from ask_numbers(
        f"{key}-commanded",
        "Command the joints, wait until the arm stands still. J1 to J5?",
        count=5,
        unit="deg",
        default=advised,
    )
    a, b, c, d, e = commanded
    mount = yield from ask_choice(
        f"{key}-marker",
        "Which marker does the camera see?",
        (BACK.name, TOP.name),
        default=mount_for(commanded).name,
    )
    x, y, z, turn_a, turn_b, turn_c = yield from ask_numbers(
        f"{key}-seen",
        "Where is it in the robot frame: x, y, z (mm), a, b, c (deg)?",
        count=6,
    )
    return Sight(
        label=f"{word} {number}",
        commanded_deg=(a, b, c, d, e),
        seen=Pose(x, y, z, turn_a, turn_b, turn_c),
        mount=mount,
        came_from=_came_from(earlier[-1].commanded_deg, (a, b, c, d, e)) if earlier else 0,
    )


def _came_from(before: Five, now: Five) -> int:
    """Return the one joint that moved, with its way; 0 if there was not exactly one."""
    moved = [
        joint if there > here else -joint
        for joint, (here, there) in enumerate(zip(before, now, strict=True), 1)
        if here != there
    ]
    return moved[0] if len(moved) == 1 else 0


def _advised(
    number: int,
    count: int,
    plan: tuple[Five, ...],
    sights: list[Sight],
    arm: LynxArm,
    mounts: tuple[Mount, ...],
    noise: MarkerNoise,
) -> Five:
    """Return what to command next."""
    planned = max(count - _LAST, 1)
    if number <= min(planned, len(plan)):
        return plan[(number - 1) * len(plan) // planned if planned < len(plan) else number - 1]
    try:
        found = fit_servos(sights, arm.geometry, mounts=mounts, noise=noise)
    except FitFailed:
        return plan[(number - 1) % len(plan)]
    worst = next_pose(found, arm)
    return plan[(number - 1) % len(plan)] if worst is None else worst[0]


def _count(key: str, question: str, default: int, least: int) -> Steps[int]:
    answer = yield from ask_number(key, f"{question}?", default=default)
    if answer != int(answer) or not least <= answer <= _MOST:
        raise CalibrationError(f"{key}: {answer:g} is not a whole number from {least} to {_MOST}")
    return int(answer)
