"""Poses along a straight line, for arms whose controller does not interpolate by itself."""

from __future__ import annotations

from math import ceil, dist

from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics


def pose_between(first: Pose, last: Pose, t: float) -> Pose:
    """Return the pose at a share t (0 to 1) of the way.

    The tool point moves evenly on a line while each of the three angles turns evenly, the
    shorter way round.
    """
    if t >= 1.0:
        return last
    return Pose(
        first.x_mm + t * (last.x_mm - first.x_mm),
        first.y_mm + t * (last.y_mm - first.y_mm),
        first.z_mm + t * (last.z_mm - first.z_mm),
        first.a_deg + t * shorter_turn_deg(first.a_deg, last.a_deg),
        first.b_deg + t * shorter_turn_deg(first.b_deg, last.b_deg),
        first.c_deg + t * shorter_turn_deg(first.c_deg, last.c_deg),
    )


def shorter_turn_deg(first_deg: float, last_deg: float) -> float:
    """Return the turn from one angle to another, in [-180, 180)."""
    return (last_deg - first_deg + 180.0) % 360.0 - 180.0


def joints_along_line(
    arm: ArmKinematics,
    start: JointPositions,
    target: Pose,
    posture: int,
    *,
    step_mm: float,
    step_deg: float,
) -> list[JointPositions]:
    """Return the joints at equal shares of a line, the start left out, the target last.

    Args:
        arm: The arm's kinematics.
        start: Where it stands.
        target: Where the tool point goes.
        posture: The posture of every point of the line.
        step_mm: Greatest distance between two points.
        step_deg: Greatest turn between two points.

    Raises:
        UnreachablePose: A point of the line cannot be reached in the posture.
    """
    first = arm.forward(start)
    way_mm = dist((first.x_mm, first.y_mm, first.z_mm), (target.x_mm, target.y_mm, target.z_mm))
    turn_deg = max(
        abs(shorter_turn_deg(a, b))
        for a, b in (
            (first.a_deg, target.a_deg),
            (first.b_deg, target.b_deg),
            (first.c_deg, target.c_deg),
        )
    )
    count = max(1, ceil(way_mm / step_mm), ceil(turn_deg / step_deg))
    found, near = [], start
    for index in range(1, count + 1):
        near = arm.solve(pose_between(first, target, index / count), posture, near)
        found.append(near)
    return found
