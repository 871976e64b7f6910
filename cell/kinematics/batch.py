"""Forward and inverse kinematics of many poses at once, on arrays.

The same closed form as `closed_form`, column by column in blocks that stay in the
processor's cache.
"""

from __future__ import annotations

from math import atan2, pi

import numpy as np
from numpy.typing import NDArray

from cell.kinematics.flags import ABOVE, NON_FLIP, RIGHT
from cell.kinematics.geometry import SixAxisGeometry

_Array = NDArray[np.float64]
_BLOCK = 1024
_AXIS_MM = 1e-6
_STRAIGHT = 1e-9
_OVERREACH = 1e-9
_LIMIT_SLACK_DEG = 1e-7
_DEG = 180.0 / pi


class BatchKinematics:
    """Vectorised kinematics of a geometry with a tool and joint limits.

    Args:
        geometry: The arm's lengths.
        tool_mm: The tool point in the flange frame.
        joint_min_deg: Lower limits, J1 first.
        joint_max_deg: Upper limits, J1 first.
    """

    def __init__(
        self,
        geometry: SixAxisGeometry,
        tool_mm: tuple[float, float, float],
        joint_min_deg: tuple[float, ...],
        joint_max_deg: tuple[float, ...],
    ) -> None:
        self._geometry = geometry
        self._offset = np.array([tool_mm[0], tool_mm[1], tool_mm[2] + geometry.d6_mm])
        self._low = np.array(joint_min_deg) - _LIMIT_SLACK_DEG
        self._high = np.array(joint_max_deg) + _LIMIT_SLACK_DEG

    def forward(self, joints_deg: _Array) -> _Array:
        """Return robot-from-tool matrices, shape (N, 4, 4), of joint angles (N, 6)."""
        q1, q2, q3, q4, q5, q6 = np.radians(np.asarray(joints_deg, dtype=np.float64)).T
        q23 = q2 + q3
        c1, s1, c23, s23 = np.cos(q1), np.sin(q1), np.cos(q23), np.sin(q23)
        c4, s4, c5, s5, c6, s6 = (
            np.cos(q4), np.sin(q4), np.cos(q5), np.sin(q5), np.cos(q6), np.sin(q6),
        )  # fmt: skip
        shape = self._geometry
        radius = shape.a1_mm + shape.a2_mm * np.sin(q2) - shape.a3_mm * c23 + shape.d4_mm * s23
        height = shape.d1_mm + shape.a2_mm * np.cos(q2) + shape.a3_mm * s23 + shape.d4_mm * c23
        columns = (
            (c4 * c5 * c6 - s4 * s6, s4 * c5 * c6 + c4 * s6, -s5 * c6),
            (-c4 * c5 * s6 - s4 * c6, c4 * c6 - s4 * c5 * s6, s5 * s6),
            (c4 * s5, s4 * s5, c5),
        )
        matrices = np.zeros((len(q1), 4, 4))
        for column, (x, y, z) in enumerate(columns):
            outward = c23 * x + s23 * z
            matrices[:, 0, column] = c1 * outward - s1 * y
            matrices[:, 1, column] = s1 * outward + c1 * y
            matrices[:, 2, column] = c23 * z - s23 * x
        matrices[:, :3, 3] = matrices[:, :3, :3] @ self._offset
        matrices[:, 0, 3] += c1 * radius
        matrices[:, 1, 3] += s1 * radius
        matrices[:, 2, 3] += height
        matrices[:, 3, 3] = 1.0
        return matrices

    def inverse(self, matrices: _Array) -> tuple[_Array, NDArray[np.bool_]]:
        """Return joint angles (N, 8, 6), second index FL1, and the mask of allowed ones."""
        count = len(matrices)
        joints = np.empty((count, 8, 6))
        allowed = np.empty((count, 8), dtype=np.bool_)
        with np.errstate(invalid="ignore"):
            for first in range(0, count, _BLOCK):
                block = np.asarray(matrices[first : first + _BLOCK], dtype=np.float64)
                solved = self._solve(block)
                self._turn_into_limits(solved)
                inside = (solved >= self._low[:, None]) & (solved <= self._high[:, None])
                allowed[first : first + _BLOCK] = inside.all(axis=1).T
                joints[first : first + _BLOCK] = solved.transpose(2, 0, 1)
        return joints, allowed

    def _solve(self, block: _Array) -> _Array:
        """Return joint angles, shape (8, 6, B), of one block of matrices (B, 4, 4)."""
        m = np.ascontiguousarray(block.transpose(1, 2, 0))
        shape = self._geometry
        wrist = m[:3, 3] - np.einsum("ijb,j->ib", m[:3, :3], self._offset)
        level = np.hypot(wrist[0], wrist[1])
        is_on_axis = level < _AXIS_MM
        safe = np.where(is_on_axis, 1.0, level)
        front_c = np.where(is_on_axis, 1.0, wrist[0] / safe)
        front_s = np.where(is_on_axis, 0.0, wrist[1] / safe)
        level = np.where(is_on_axis, 0.0, level)
        height = wrist[2] - shape.d1_mm
        joints = np.empty((8, 6, block.shape[0]))
        for side in (RIGHT, 0):
            sign = 1.0 if side else np.where(is_on_axis, 1.0, -1.0)
            c1, s1 = sign * front_c, sign * front_s
            outward = (level if side else -level) - shape.a1_mm
            self._solve_side(joints, side, m, c1, s1, outward, height)
        return joints

    def _solve_side(
        self, joints: _Array, side: int, m: _Array, c1: _Array, s1: _Array, r: _Array, h: _Array
    ) -> None:
        """Fill in the four postures of one side."""
        shape = self._geometry
        a2, rod, beta = shape.a2_mm, shape.forearm_mm, atan2(shape.a3_mm, shape.d4_mm)
        sin_beta, cos_beta = shape.a3_mm / rod, shape.d4_mm / rod
        square = r * r + h * h
        cosine = (square - a2**2 - rod**2) / (2.0 * a2 * rod)
        over = np.abs(cosine)
        cosine = np.where(over > 1.0 + _OVERREACH, np.nan, np.clip(cosine, -1.0, 1.0))
        sine = np.sqrt(1.0 - cosine * cosine)
        gamma = np.arctan2(sine, cosine)
        along = a2 + rod * cosine
        # Rows of Rz(-q1) · R: outwards, across.
        outward = c1 * m[0, :3] + s1 * m[1, :3]
        across = c1 * m[1, :3] - s1 * m[0, :3]
        joint1 = np.arctan2(s1, c1) * _DEG
        for elbow in (ABOVE, 0):
            sign = 1.0 if bool(elbow) == bool(side) else -1.0
            reach = sign * rod * sine
            s2 = (r * along - h * reach) / square
            c2 = (h * along + r * reach) / square
            rod_s, rod_c = (r - a2 * s2) / rod, (h - a2 * c2) / rod
            s23 = rod_s * cos_beta + rod_c * sin_beta
            c23 = rod_c * cos_beta - rod_s * sin_beta
            joint3 = (sign * gamma + beta) * _DEG
            if sign > 0:
                joint3[joint3 > 180.0] -= 360.0
            posture = side | elbow
            for bits in (posture, posture | NON_FLIP):
                joints[bits, 0] = joint1
                joints[bits, 2] = joint3
            joints[posture, 1] = joints[posture | NON_FLIP, 1] = np.arctan2(s2, c2) * _DEG
            self._solve_wrist(joints, posture, m, outward, across, s23, c23)

    def _solve_wrist(
        self, joints: _Array, posture: int, m: _Array, outward: _Array, across: _Array,
        s23: _Array, c23: _Array,
    ) -> None:  # fmt: skip
        """Fill in J4, J5, J6 of the flip and non-flip posture."""
        ax = c23 * outward[2] - s23 * m[2, 2]
        az = s23 * outward[2] + c23 * m[2, 2]
        bend = np.sqrt(ax * ax + across[2] * across[2])
        plain = joints[posture | NON_FLIP]
        plain[3] = np.arctan2(across[2], ax) * _DEG
        plain[4] = np.arctan2(bend, az) * _DEG
        plain[5] = (
            np.arctan2(s23 * outward[1] + c23 * m[2, 1], -s23 * outward[0] - c23 * m[2, 0]) * _DEG
        )
        flipped = joints[posture]
        flipped[3] = plain[3] - np.where(plain[3] > 0.0, 180.0, -180.0)
        flipped[4] = -plain[4]
        flipped[5] = plain[5] - np.where(plain[5] > 0.0, 180.0, -180.0)
        is_straight = bend <= _STRAIGHT
        if is_straight.any():
            total = np.arctan2(across[0], c23 * outward[0] - s23 * m[2, 0]) * _DEG
            folded = -np.arctan2(-across[0], s23 * m[2, 0] - c23 * outward[0]) * _DEG
            for solution in (plain, flipped):
                solution[3, is_straight] = 0.0
                solution[4, is_straight] = np.where(az > 0.0, 0.0, 180.0)[is_straight]
                solution[5, is_straight] = np.where(az > 0.0, total, folded)[is_straight]

    def _turn_into_limits(self, joints: _Array) -> None:
        """Move J6 by whole turns into its limits where it lies outside, in place."""
        low, high = self._low[5], self._high[5]
        if low <= -180.0 and high >= 180.0:
            return
        roll = joints[:, 5]
        turned = roll - 360.0 * np.floor((roll - low) / 360.0)
        joints[:, 5] = np.where(((roll < low) | (roll > high)) & (turned <= high), turned, roll)
