"""Whether an arm stands where it can stand after it was stopped: on the path it was on."""

from __future__ import annotations

import math

from cell.geometry import JointPositions, Pose
from cell.motion.guard import GuardedMove

ON_PATH_MM = 5.0
"""How far from its straight line the tool point may stand (following errors, braking)."""
ON_PATH_DEG = 1.0
"""How far from its path, or from where it stood, a joint may stand."""


def away_from_line_mm(here: Pose, start: Pose, end: Pose) -> float:
    """Return the distance of a point from the straight stretch between two others."""
    along = (end.x_mm - start.x_mm, end.y_mm - start.y_mm, end.z_mm - start.z_mm)
    off = (here.x_mm - start.x_mm, here.y_mm - start.y_mm, here.z_mm - start.z_mm)
    length2 = sum(a * a for a in along)
    share = sum(a * o for a, o in zip(along, off, strict=True)) / length2 if length2 else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.dist(off, tuple(share * a for a in along))


def away_from_joint_path_deg(
    here: JointPositions, start: JointPositions, end: JointPositions
) -> float:
    """Return how far the joint is from its path that is farthest from it.

    All joints of a joint move are the same share of their way at any moment; the share is
    told by the joint with the longest way.
    """
    ways = [b - a for a, b in zip(start.values, end.values, strict=True)]
    longest = max(range(len(ways)), key=lambda joint: abs(ways[joint]))
    share = 0.0
    if ways[longest]:
        share = (here.values[longest] - start.values[longest]) / ways[longest]
    share = min(max(share, 0.0), 1.0)
    return max(
        abs(h - (a + share * way))
        for h, a, way in zip(here.values, start.values, ways, strict=True)
    )


def strays_from(move: GuardedMove, start_pose: Pose, joints: JointPositions, pose: Pose) -> str:
    """Return how an arm stands off a path, as words; empty if it stands on it.

    Args:
        move: The motion that was under way.
        start_pose: Where the tool point was when it began.
        joints: Where the joints stand.
        pose: Where the tool point stands.
    """
    if move.interpolation == "linear":
        off_mm = away_from_line_mm(pose, start_pose, move.end_pose)
        return f"{off_mm:.0f} mm off the line it was on" if off_mm > ON_PATH_MM else ""
    off_deg = away_from_joint_path_deg(joints, move.start, move.end)
    return f"{off_deg:.1f} deg off the path it was on" if off_deg > ON_PATH_DEG else ""


def strays_from_stand(joints: JointPositions, stand: JointPositions) -> str:
    """Return how an arm is away from where it stood, as words; empty if it is there."""
    off_deg = max(abs(a - b) for a, b in zip(joints.values, stand.values, strict=True))
    return f"{off_deg:.1f} deg from where it stood" if off_deg > ON_PATH_DEG else ""
