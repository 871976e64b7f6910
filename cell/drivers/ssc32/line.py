"""Straight moves of a controller that only knows servos: many short joint moves."""

from __future__ import annotations

from math import atan2, ceil, cos, degrees, dist, pi, sin

import numpy as np
from numpy.typing import NDArray

from cell.geometry import JointPositions, Pose, Transform
from cell.kinematics.lynx import LynxArm

_NO_TURN_RAD = 1e-9


def straight_line(
    arm: LynxArm,
    start: JointPositions,
    target: Pose,
    posture: int,
    *,
    step_mm: float,
    step_deg: float,
) -> list[JointPositions]:
    """Return the joint angles along a straight line, the start left out, the target last.

    The tool point goes straight and the tool turns about one axis; where five joints cannot
    follow the turn, it takes the nearest orientation that they can.

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
    end = arm.solve(target, posture, start)
    first = Transform.from_pose(arm.forward(start))
    last = Transform.from_pose(target)
    axis, turn_rad = _turn(first.rotation, last.rotation)
    way_mm = dist(first.translation_mm, last.translation_mm)
    count = max(1, ceil(way_mm / step_mm), ceil(degrees(turn_rad) / step_deg))
    stances, near = [], start
    for number in range(1, count):
        share = number / count
        matrix = np.eye(4)
        matrix[:3, :3] = _turned(axis, share * turn_rad) @ first.rotation
        matrix[:3, 3] = (1 - share) * first.translation_mm + share * last.translation_mm
        pose = arm.nearest_pose(Transform(matrix).to_pose())
        near = arm.solve(pose, posture, near)
        stances.append(near)
    stances.append(end)
    return stances


def _turn(
    first: NDArray[np.float64], last: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return axis and angle (0 to pi) of the rotation that takes `first` to `last`."""
    r = last @ first.T
    twice = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    sine = float(np.linalg.norm(twice))
    angle = atan2(sine, float(np.trace(r)) - 1.0)
    if sine > _NO_TURN_RAD:
        return twice / sine, angle
    if angle < pi / 2:
        return np.array([0.0, 0.0, 1.0]), 0.0
    # Half a turn: R + I is twice the axis times itself, so its columns lie along the axis.
    column = max((r + np.eye(3)).T, key=lambda c: float(np.linalg.norm(c)))
    return column / np.linalg.norm(column), angle


def _turned(axis: NDArray[np.float64], angle_rad: float) -> NDArray[np.float64]:
    """Return the rotation about an axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + sin(angle_rad) * cross + (1.0 - cos(angle_rad)) * (cross @ cross))
