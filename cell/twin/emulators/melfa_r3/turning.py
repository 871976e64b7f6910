"""Turning a tool evenly about one axis from one orientation to another."""

from __future__ import annotations

import math

from cell.geometry import Pose

Quaternion = tuple[float, float, float, float]
"""w, x, y, z of length 1."""


class EvenTurn:
    """The shortest turn between the orientations of two poses (spherical interpolation).

    Attributes:
        angle_deg: Angle between them, 0 to 180.
    """

    __slots__ = ("angle_deg", "_first", "_half_rad", "_second")

    def __init__(self, first: Pose, second: Pose) -> None:
        p, q = _quaternion(first), _quaternion(second)
        cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
        if cosine < 0:
            # A quaternion and its negative are the same turn; take the nearer one.
            q, cosine = (-q[0], -q[1], -q[2], -q[3]), -cosine
        self._first, self._second = p, q
        self._half_rad = math.acos(min(cosine, 1.0))
        self.angle_deg = math.degrees(2 * self._half_rad)

    def at(self, share: float) -> tuple[float, float, float]:
        """Return A, B and C in degrees at a share of the turn, 0 to 1."""
        sine = math.sin(self._half_rad)
        if sine < 1e-9:
            return _angles(self._first)
        u = math.sin((1 - share) * self._half_rad) / sine
        v = math.sin(share * self._half_rad) / sine
        p, q = self._first, self._second
        return _angles(
            (
                u * p[0] + v * q[0],
                u * p[1] + v * q[1],
                u * p[2] + v * q[2],
                u * p[3] + v * q[3],
            )
        )


def _quaternion(pose: Pose) -> Quaternion:
    """Return the quaternion of Rz(c) · Ry(b) · Rx(a)."""
    a, b, c = (math.radians(angle) / 2 for angle in (pose.a_deg, pose.b_deg, pose.c_deg))
    ca, sa, cb, sb, cc, sc = (
        math.cos(a), math.sin(a), math.cos(b), math.sin(b), math.cos(c), math.sin(c),
    )  # fmt: skip
    return (
        ca * cb * cc + sa * sb * sc,
        sa * cb * cc - ca * sb * sc,
        ca * sb * cc + sa * cb * sc,
        ca * cb * sc - sa * sb * cc,
    )


def _angles(quaternion: Quaternion) -> tuple[float, float, float]:
    """Return A, B, C of a quaternion; at B = ±90 deg, where A and C are one turn, A is 0."""
    w, x, y, z = quaternion
    r00, r10, r20 = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    level = math.hypot(r00, r10)
    b = math.degrees(math.atan2(-r20, level))
    if level > 1e-9:
        r21, r22 = 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        return math.degrees(math.atan2(r21, r22)), b, math.degrees(math.atan2(r10, r00))
    r01, r11 = 2 * (x * y - w * z), 1 - 2 * (x * x + z * z)
    return 0.0, b, math.degrees(math.atan2(-r01, r11))
