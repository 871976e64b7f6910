"""Where a marker on the Lynx's hand is, and how each joint moves it, for many poses at once.

The chain is that of `cell.kinematics.lynx`: J1 turns about the vertical, J2 to J4 lean about
the horizontal axis across the arm's plane, J5 turns about the hand.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cell.geometry import Pose, Transform
from cell.kinematics.lynx import LynxGeometry

Array = NDArray[np.float64]


class MarkerChain:
    """Places of markers on the hand.

    Args:
        geometry: The arm's lengths.
        tool_from_marker: The marker of each pose, shape of poses.
    """

    def __init__(self, geometry: LynxGeometry, tool_from_marker: Sequence[Transform]) -> None:
        self._geometry = geometry
        frames = np.array([_matrix(one) for one in tool_from_marker]).reshape(-1, 4, 4)
        self._rotation, self._offset = frames[:, :3, :3], frames[:, :3, 3]

    def places(self, joints_deg: Array) -> tuple[Array, Array, Array]:
        """Return positions (n, 3) mm, rotations (n, 3, 3) and slopes (n, 6, 5) of joints (n, 5).

        The slopes are of position (mm) and turn (rad, robot frame) by joint angles in degrees.
        """
        shape = self._geometry
        q = np.radians(joints_deg)
        c1, s1 = np.cos(q[:, 0]), np.sin(q[:, 0])
        zero, one = np.zeros_like(c1), np.ones_like(c1)
        q2, q23 = q[:, 1], q[:, 1] + q[:, 2]
        pitch = q23 + q[:, 3]
        sp, cp, s5, c5 = np.sin(pitch), np.cos(pitch), np.sin(q[:, 4]), np.cos(q[:, 4])
        ahead = np.stack([c1, s1, zero], axis=1)
        upright = np.stack([zero, zero, one], axis=1)
        across = np.stack([-s1, c1, zero], axis=1)
        shoulder = shape.shoulder_mm * upright
        elbow = shoulder + shape.upper_arm_mm * _lean(np.sin(q2), np.cos(q2), ahead, upright)
        wrist = elbow + shape.forearm_mm * _lean(np.cos(q23), -np.sin(q23), ahead, upright)
        hand = _lean(cp, -sp, ahead, upright)
        tool = wrist + shape.tool_mm * hand
        up = _lean(sp, cp, ahead, upright)
        tool_x = c5[:, None] * up - s5[:, None] * across
        tool_y = -s5[:, None] * up - c5[:, None] * across
        frame = np.stack([tool_x, tool_y, hand], axis=2)
        position = tool + np.einsum("nij,nj->ni", frame, self._offset)
        slopes = np.zeros((len(q), 6, 5))
        slopes[:, 0, 0], slopes[:, 1, 0], slopes[:, 5, 0] = -position[:, 1], position[:, 0], 1.0
        for index, pivot in ((1, shoulder), (2, elbow), (3, wrist)):
            x, y, z = (position - pivot).T
            slopes[:, 0, index], slopes[:, 1, index] = c1 * z, s1 * z
            slopes[:, 2, index] = -s1 * y - c1 * x
            slopes[:, 3:, index] = across
        slopes[:, :3, 4] = np.cross(hand, position - tool)
        slopes[:, 3:, 4] = hand
        return position, frame @ self._rotation, slopes * (np.pi / 180.0)


def turn_between(rotations: Array, others: Array) -> Array:
    """Return the turns (n, 3) in radians, robot frame, that take the others to rotations."""
    between = rotations @ others.transpose(0, 2, 1)
    axis = 0.5 * np.stack(
        [
            between[:, 2, 1] - between[:, 1, 2],
            between[:, 0, 2] - between[:, 2, 0],
            between[:, 1, 0] - between[:, 0, 1],
        ],
        axis=1,
    )
    sine = np.linalg.norm(axis, axis=1)
    cosine = 0.5 * (np.trace(between, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    factor = np.where(sine > 1e-9, angle / np.maximum(sine, 1e-12), 1.0)
    turns: Array = axis * factor[:, None]
    return turns


def rotations_of(poses: Sequence[Pose]) -> Array:
    """Return the rotations (n, 3, 3) of poses, R = Rz(c) · Ry(b) · Rx(a)."""
    angles = np.radians([(pose.a_deg, pose.b_deg, pose.c_deg) for pose in poses])
    (sa, sb, sc), (ca, cb, cc) = np.sin(angles).T, np.cos(angles).T
    rows = (
        (cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa),
        (sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa),
        (-sb, cb * sa, cb * ca),
    )
    return np.array(rows).transpose(2, 0, 1)


def _matrix(transform: Transform) -> Array:
    return np.array(transform.matrix, np.float64)


def _lean(out: Array, up: Array, ahead: Array, upright: Array) -> Array:
    leaned: Array = out[:, None] * ahead + up[:, None] * upright
    return leaned
