"""What no arm of a cell can reach, told before any path to it is sampled.

A path is cut by its length, so a target that is absurdly far away would take for ever, and
one beyond the range of numbers would break the arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite

from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose

FAR_MM = 10_000.0
"""No arm of a cell reaches a tenth as far; up to here the way is worth looking at."""
FAR_JOINT = 10_000.0
"""Deg or mm; no joint goes a tenth as far."""
TURN_DEG = 360.0
"""How far a tool's angle may be given beyond zero, either way."""


def require_joints(
    target: JointPositions, low: Sequence[float], high: Sequence[float], units: Sequence[str]
) -> None:
    """Return if joint positions are numbers that a path may be cut for.

    Args:
        target: Where the joints shall go, deg or mm.
        low: Lower limits, J1 first.
        high: Upper limits, J1 first.
        units: Unit of each joint.

    Raises:
        MotionRefused: One is not finite, or absurdly far beyond its limits.
    """
    for axis, value in enumerate(target.values):
        if not abs(value) <= FAR_JOINT:
            limit = high[axis] if value > 0 else low[axis]
            raise MotionRefused(
                f"J{axis + 1}",
                value=value, limit=limit, nearest=limit, unit=units[axis],
                why="would pass its limit" if isfinite(value) else "is given no finite number",
            )  # fmt: skip


def require_pose(start: Pose, target: Pose, check: Callable[[Pose], object]) -> None:
    """Return if a pose is one that a path may be cut for.

    Args:
        start: Where the tool is.
        target: Where it shall go.
        check: Checks the way to a pose that is near enough; it says how far the tool
            may go on its way to one that is not.

    Raises:
        MotionRefused: The pose has a figure that is not finite or turns by more than
            `TURN_DEG`, or it lies absurdly far out of reach.
    """
    for name, angle in (("a", target.a_deg), ("b", target.b_deg), ("c", target.c_deg)):
        if not abs(angle) <= TURN_DEG:
            limit = -TURN_DEG if angle < 0 else TURN_DEG
            raise MotionRefused(
                f"tool {name}",
                value=angle, limit=limit, nearest=limit, unit="deg",
                why="is turned by more than a whole turn",
            )  # fmt: skip
    here = (start.x_mm, start.y_mm, start.z_mm)
    there = (target.x_mm, target.y_mm, target.z_mm)
    sizes = [abs(value) if isfinite(value) else float("inf") for value in there]
    if max(sizes) <= FAR_MM:
        return
    axis = sizes.index(max(sizes))
    nearest = here
    if isfinite(sizes[axis]):
        share = FAR_MM / sizes[axis]
        x_mm, y_mm, z_mm = (a + (b * share - a * share) for a, b in zip(here, there, strict=True))
        try:
            check(replace(target, x_mm=x_mm, y_mm=y_mm, z_mm=z_mm))
        except MotionRefused as refusal:
            if refusal.nearest_point_mm is None:
                raise
            nearest = refusal.nearest_point_mm
    raise MotionRefused(
        f"tool {'xyz'[axis]}",
        value=there[axis], limit=nearest[axis], nearest=nearest[axis], unit="mm",
        why="is out of reach",
        nearest_point_mm=nearest,
    )  # fmt: skip
