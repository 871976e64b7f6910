"""Poses as twelve plain floats, for code that runs too often for arrays.

A `Matrix34` is the upper three rows of the homogeneous matrix robot-from-frame,
row by row: (r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z), x y z in mm.
"""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, radians, sin
from typing import TypeAlias

from cell.geometry import Pose

Matrix34: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float
]

_GIMBAL = 1e-9
_HALF_TURN_DEG = 180.0 - 1e-9


def matrix_from_pose(pose: Pose) -> Matrix34:
    """Return robot-from-tool of a pose, R = Rz(c) · Ry(b) · Rx(a)."""
    a = radians(pose.a_deg)
    b = radians(pose.b_deg)
    c = radians(pose.c_deg)
    ca, sa, cb, sb, cc, sc = cos(a), sin(a), cos(b), sin(b), cos(c), sin(c)
    ccsb = cc * sb
    scsb = sc * sb
    return (
        cc * cb, ccsb * sa - sc * ca, ccsb * ca + sc * sa, pose.x_mm,
        sc * cb, scsb * sa + cc * ca, scsb * ca - cc * sa, pose.y_mm,
        -sb, cb * sa, cb * ca, pose.z_mm,
    )  # fmt: skip


def pose_from_matrix(matrix: Matrix34) -> Pose:
    """Return the pose of a frame, angles in (-180, 180].

    At b = ±90 deg, where a and c turn about the same axis, a is set to 0.
    """
    r00, r01, _, x, r10, r11, _, y, r20, r21, r22, z = matrix
    horizontal = hypot(r00, r10)
    if horizontal > _GIMBAL:
        a = degrees(atan2(r21, r22))
        c = degrees(atan2(r10, r00))
    else:
        a = 0.0
        c = degrees(atan2(-r01, r11))
    b = degrees(atan2(-r20, horizontal))
    # Rounding decides the sign of a half turn; the controller writes it as +180.
    return Pose(
        x, y, z, 180.0 if a < -_HALF_TURN_DEG else a, b, 180.0 if c < -_HALF_TURN_DEG else c
    )
