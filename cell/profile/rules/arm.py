"""An arm's limits, where it rests, and how fast it may go."""

from __future__ import annotations

from collections.abc import Iterator

from cell.profile.cell import CellProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.rules.problem import Problem, Rule


def _joint_fields(profile: CellProfile) -> tuple[str, str, str, str]:
    """Return the names of an arm's least, greatest, and resting positions and its speeds."""
    if isinstance(profile.arm, Ibm7545Profile):
        return "joint_min", "joint_max", "rest", "joint_speed"
    return "joint_min_deg", "joint_max_deg", "rest_deg", "joint_speed_deg_s"


def _joint_limits(profile: CellProfile) -> Iterator[Problem]:
    """Every joint: least below greatest position, rest between them, speed above 0."""
    low_name, high_name, rest_name, speed_name = _joint_fields(profile)
    arm = profile.arm
    if isinstance(arm, Ibm7545Profile):
        low, high, rest, speed = arm.joint_min, arm.joint_max, arm.rest, arm.joint_speed
    else:
        low, high, rest = arm.joint_min_deg, arm.joint_max_deg, arm.rest_deg  # type: ignore[assignment]
        speed = arm.joint_speed_deg_s  # type: ignore[assignment]
    for i, (least, most, resting, fast) in enumerate(zip(low, high, rest, speed, strict=True)):
        if least >= most:
            yield Problem(
                ("arm", high_name, i),
                f"J{i + 1} may go from {least:g} to {most:g}: the greatest position must be above "
                "the least",
                other=("arm", low_name, i),
            )
        elif not least <= resting <= most:
            yield Problem(
                ("arm", rest_name, i),
                f"the arm rests with J{i + 1} at {resting:g}; {least:g} to {most:g} is allowed",
                "choose a resting position within the limits of every joint",
                other=("arm", high_name if resting > most else low_name, i),
            )
        if fast <= 0:
            yield Problem(
                ("arm", speed_name, i),
                f"the speed of J{i + 1} is {fast:g}; a number above 0 is allowed",
            )


def _linear_speed(profile: CellProfile) -> Iterator[Problem]:
    """`linear_speed_mm_s` is at most `max_linear_speed_mm_s`."""
    arm = profile.arm
    if arm.linear_speed_mm_s > arm.max_linear_speed_mm_s:
        yield Problem(
            ("arm", "linear_speed_mm_s"),
            f"the arm shall go {arm.linear_speed_mm_s:g} mm/s; "
            f"{arm.max_linear_speed_mm_s:g} mm/s at most is allowed",
            other=("arm", "max_linear_speed_mm_s"),
        )


ARM_RULES = (Rule(("arm",), _joint_limits), Rule(("arm",), _linear_speed))
