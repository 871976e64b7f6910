"""Poses along a straight line, for arms whose controller does not interpolate by itself."""

from __future__ import annotations

from cell.geometry import Pose


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
