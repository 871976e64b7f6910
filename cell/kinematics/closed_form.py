"""Forward and inverse kinematics of one arm in closed form, in plain floats.

Theory. With R = Rz(q1) · Ry(q2 + q3) · Rz(q4) · Ry(q5) · Rz(q6) the wrist's
centre depends on q1, q2, q3 alone. Seen in the turning plane of J1, with r
outwards from the shoulder and h upwards, elbow offset and forearm are one rod of
length l that stands β = atan(a3 / d4) behind the forearm:

    r = a2 sin q2 + l sin(q2 + γ),   h = a2 cos q2 + l cos(q2 + γ),   γ = q3 - β

so cos γ = (r² + h² - a2² - l²) / (2 a2 l); its two signs are elbow above and
below, the two ways to face the wrist are right and left. What remains of R after
q1 and q2 + q3 is Rz(q4) · Ry(q5) · Rz(q6), whose two solutions are non-flip
(q5 > 0) and flip. Nothing here knows of limits.
"""

from __future__ import annotations

from math import atan2, cos, degrees, pi, radians, sin, sqrt
from typing import TypeAlias

from cell.errors import CellError
from cell.kinematics.flags import ABOVE, NON_FLIP, RIGHT
from cell.kinematics.geometry import SixAxisGeometry
from cell.kinematics.rotation import Matrix34

Joints: TypeAlias = tuple[float, float, float, float, float, float]
Point: TypeAlias = tuple[float, float, float]
LinkPoints: TypeAlias = tuple[Point, Point, Point, Point, Point, Point, Point]
"""Base, shoulder, elbow, forearm axis (elbow offset), wrist, flange, tool point, in mm."""
_Elbow: TypeAlias = tuple[float, float, float, float]

_AXIS_MM = 1e-6
"""Closer than this to the J1 axis the wrist says nothing about q1."""
_STRAIGHT = 1e-9
"""Sine of q5 below which q4 and q6 turn about the same axis."""
_OVERREACH = 1e-9
"""How far cos γ may pass ±1 by rounding."""


class OutOfReach(CellError):
    """The wrist's centre is too far from the shoulder or too near; carries no text."""


class ClosedForm:
    """Closed-form kinematics of a geometry with a tool.

    Args:
        geometry: The arm's lengths.
        tool_mm: The tool point in the flange frame; the tool frame keeps the
            flange's orientation.
    """

    __slots__ = (
        "_a1", "_a2", "_a3", "_beta", "_cos_beta", "_d1", "_d4", "_d6", "_forearm",
        "_offset_x", "_offset_y", "_offset_z", "_product", "_sin_beta", "_squares",
    )  # fmt: skip

    def __init__(self, geometry: SixAxisGeometry, tool_mm: tuple[float, float, float]) -> None:
        self._d1, self._a1, self._a2 = geometry.d1_mm, geometry.a1_mm, geometry.a2_mm
        self._a3, self._d4, self._d6 = geometry.a3_mm, geometry.d4_mm, geometry.d6_mm
        self._forearm = geometry.forearm_mm
        self._beta = atan2(self._a3, self._d4)
        self._sin_beta, self._cos_beta = sin(self._beta), cos(self._beta)
        self._squares = self._a2**2 + self._forearm**2
        self._product = 2.0 * self._a2 * self._forearm
        self._offset_x, self._offset_y = tool_mm[0], tool_mm[1]
        self._offset_z = tool_mm[2] + self._d6

    def chain(self, joints_deg: tuple[float, ...]) -> tuple[LinkPoints, Matrix34]:
        """Return the points along the arm and robot-from-tool of joint angles."""
        j1, j2, j3, j4, j5, j6 = joints_deg
        q1, q2, q4, q5, q6 = radians(j1), radians(j2), radians(j4), radians(j5), radians(j6)
        q23 = radians(j2 + j3)
        c1, s1, c23, s23 = cos(q1), sin(q1), cos(q23), sin(q23)
        c4, s4, c5, s5, c6, s6 = cos(q4), sin(q4), cos(q5), sin(q5), cos(q6), sin(q6)
        elbow_r = self._a1 + self._a2 * sin(q2)
        elbow_z = self._d1 + self._a2 * cos(q2)
        axis_r = elbow_r - self._a3 * c23
        axis_z = elbow_z + self._a3 * s23
        wrist_r = axis_r + self._d4 * s23
        wx, wy, wz = c1 * wrist_r, s1 * wrist_r, axis_z + self._d4 * c23
        # Columns of Rz(q4) · Ry(q5) · Rz(q6), then turned by Ry(q23) and Rz(q1).
        c4c5, s4c5 = c4 * c5, s4 * c5
        nx, ny, nz = c4c5 * c6 - s4 * s6, s4c5 * c6 + c4 * s6, -s5 * c6
        ox, oy, oz = -c4c5 * s6 - s4 * c6, c4 * c6 - s4c5 * s6, s5 * s6
        ax, ay = c4 * s5, s4 * s5
        nr, og, ar = c23 * nx + s23 * nz, c23 * ox + s23 * oz, c23 * ax + s23 * c5
        r00, r10, r20 = c1 * nr - s1 * ny, s1 * nr + c1 * ny, c23 * nz - s23 * nx
        r01, r11, r21 = c1 * og - s1 * oy, s1 * og + c1 * oy, c23 * oz - s23 * ox
        r02, r12, r22 = c1 * ar - s1 * ay, s1 * ar + c1 * ay, c23 * c5 - s23 * ax
        tx, ty, tz, d6 = self._offset_x, self._offset_y, self._offset_z, self._d6
        x = wx + tx * r00 + ty * r01 + tz * r02
        y = wy + tx * r10 + ty * r11 + tz * r12
        z = wz + tx * r20 + ty * r21 + tz * r22
        points = (
            (0.0, 0.0, 0.0),
            (c1 * self._a1, s1 * self._a1, self._d1),
            (c1 * elbow_r, s1 * elbow_r, elbow_z),
            (c1 * axis_r, s1 * axis_r, axis_z),
            (wx, wy, wz),
            (wx + d6 * r02, wy + d6 * r12, wz + d6 * r22),
            (x, y, z),
        )
        return points, (r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z)

    def wrist(self, matrix: Matrix34) -> Point:
        """Return the wrist's centre for a tool matrix."""
        r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z = matrix
        tx, ty, tz = self._offset_x, self._offset_y, self._offset_z
        return (
            x - tx * r00 - ty * r01 - tz * r02,
            y - tx * r10 - ty * r11 - tz * r12,
            z - tx * r20 - ty * r21 - tz * r22,
        )

    def branch(
        self, matrix: Matrix34, posture: int, near_deg: tuple[float, ...] | None = None
    ) -> Joints:
        """Return the one solution with a posture, in degrees.

        Where an axis is free (see `branches`) it keeps its angle in `near_deg`. With
        `near_deg` J1, J4 and J6 are the equivalents nearest to it, so samples along a
        path come out continuous; without it they lie within a half turn.

        Raises:
            OutOfReach: The wrist's centre is out of reach.
        """
        c1, s1, r, h = self._shoulder(self.wrist(matrix), posture & RIGHT, near_deg)
        is_front = bool(posture & ABOVE) == bool(posture & RIGHT)
        q2, q3, s23, c23 = self._elbow(r, h, is_front=is_front)
        near4 = 0.0 if near_deg is None else radians(near_deg[3])
        q4, q5, q6 = _wrist_angles(matrix, _turned_back(matrix, c1, s1), s23, c23, near4)
        joints = _to_degrees(atan2(s1, c1), q2, q3, q4, q5, q6, near_deg)
        return joints if posture & NON_FLIP or q5 == 0.0 else _flipped(joints, near_deg)

    def branches(
        self, matrix: Matrix34, near_deg: tuple[float, ...] | None = None
    ) -> list[tuple[int, Joints]]:
        """Return every solution with its posture, in degrees; empty when out of reach.

        With J5 at 0 the axes J4 and J6 coincide: J4 keeps its angle in `near_deg` (or
        is 0), J6 takes the rest, and only the non-flip solution is given, since flip is
        the same. With the wrist on the J1 axis J1 likewise keeps its angle.
        """
        found: list[tuple[int, Joints]] = []
        near4 = 0.0 if near_deg is None else radians(near_deg[3])
        wrist = self.wrist(matrix)
        for side in (RIGHT, 0):
            c1, s1, r, h = self._shoulder(wrist, side, near_deg)
            q1 = atan2(s1, c1)
            turned = _turned_back(matrix, c1, s1)
            for height in (ABOVE, 0):
                try:
                    q2, q3, s23, c23 = self._elbow(r, h, is_front=bool(height) == bool(side))
                except OutOfReach:
                    break
                q4, q5, q6 = _wrist_angles(matrix, turned, s23, c23, near4)
                posture = side | height
                joints = _to_degrees(q1, q2, q3, q4, q5, q6, near_deg)
                found.append((posture | NON_FLIP, joints))
                if q5 != 0.0:
                    found.append((posture, _flipped(joints, near_deg)))
        return found

    def posture(self, joints_deg: tuple[float, ...]) -> int:
        """Return FL1 of joint angles."""
        q2, q23 = radians(joints_deg[1]), radians(joints_deg[1] + joints_deg[2])
        wrist_r = self._a1 + self._a2 * sin(q2) - self._a3 * cos(q23) + self._d4 * sin(q23)
        is_right = wrist_r >= 0.0
        is_front = sin(q23 - q2 - self._beta) > 0.0
        flag = RIGHT if is_right else 0
        if is_front == is_right:
            flag |= ABOVE
        return flag | NON_FLIP if joints_deg[4] >= 0.0 else flag

    def _shoulder(
        self, wrist: Point, side: int, near_deg: tuple[float, ...] | None
    ) -> tuple[float, float, float, float]:
        """Return cos q1, sin q1 and the wrist in the plane of J1, from the shoulder."""
        wx, wy, wz = wrist
        radius = sqrt(wx * wx + wy * wy)
        if radius < _AXIS_MM:
            q1 = 0.0 if near_deg is None else radians(near_deg[0])
            return cos(q1), sin(q1), -self._a1, wz - self._d1
        if side:
            return wx / radius, wy / radius, radius - self._a1, wz - self._d1
        return -wx / radius, -wy / radius, -radius - self._a1, wz - self._d1

    def _elbow(self, r: float, h: float, *, is_front: bool) -> _Elbow:
        """Return q2, q3 and sine and cosine of q2 + q3; `is_front` is γ > 0."""
        square = r * r + h * h
        cos_gamma = (square - self._squares) / self._product
        if cos_gamma > 1.0:
            if cos_gamma > 1.0 + _OVERREACH:
                raise OutOfReach
            cos_gamma = 1.0
        elif cos_gamma < -1.0:
            if cos_gamma < -1.0 - _OVERREACH:
                raise OutOfReach
            cos_gamma = -1.0
        sin_gamma = sqrt(1.0 - cos_gamma * cos_gamma)
        if not is_front:
            sin_gamma = -sin_gamma
        along = self._a2 + self._forearm * cos_gamma
        across = self._forearm * sin_gamma
        s2 = (r * along - h * across) / square
        c2 = (h * along + r * across) / square
        # The rod from elbow to wrist stands at q2 + q3 - β.
        rod_s = (r - self._a2 * s2) / self._forearm
        rod_c = (h - self._a2 * c2) / self._forearm
        s23 = rod_s * self._cos_beta + rod_c * self._sin_beta
        c23 = rod_c * self._cos_beta - rod_s * self._sin_beta
        return atan2(s2, c2), atan2(sin_gamma, cos_gamma) + self._beta, s23, c23


def _turned_back(matrix: Matrix34, c1: float, s1: float) -> tuple[float, ...]:
    """Return outward and sideways parts of the tool's axes n, o, a: nr, ny, or, ar, ay."""
    r00, r01, r02, _, r10, r11, r12, _, _, _, _, _ = matrix
    return (
        c1 * r00 + s1 * r10, c1 * r10 - s1 * r00, c1 * r01 + s1 * r11,
        c1 * r02 + s1 * r12, c1 * r12 - s1 * r02,
    )  # fmt: skip


def _wrist_angles(
    matrix: Matrix34, turned: tuple[float, ...], s23: float, c23: float, near4: float
) -> tuple[float, float, float]:
    """Return q4, q5 >= 0 and q6 in radians; q5 is exactly 0 where q4 is free."""
    nr, ny, outward, ar, ay = turned
    r20, r21, r22 = matrix[8], matrix[9], matrix[10]
    ax = c23 * ar - s23 * r22
    az = s23 * ar + c23 * r22
    bend = sqrt(ax * ax + ay * ay)
    if bend > _STRAIGHT:
        return (
            atan2(ay, ax),
            atan2(bend, az),
            atan2(s23 * outward + c23 * r21, -s23 * nr - c23 * r20),
        )
    nx = c23 * nr - s23 * r20
    if az > 0.0:
        return near4, 0.0, atan2(ny, nx) - near4
    return near4, pi, near4 - atan2(-ny, -nx)


def _to_degrees(
    q1: float, q2: float, q3: float, q4: float, q5: float, q6: float,
    near_deg: tuple[float, ...] | None,
) -> Joints:  # fmt: skip
    """Return degrees, rolling joints near `near_deg` or within a half turn."""
    j1, j3, j4, j6 = degrees(q1), degrees(q3), degrees(q4), degrees(q6)
    if j3 > 180.0:
        j3 -= 360.0
    if near_deg is None:
        if not -180.0 < j4 <= 180.0:
            j4 -= 360.0 if j4 > 180.0 else -360.0
        if not -180.0 < j6 <= 180.0:
            j6 -= 360.0 if j6 > 180.0 else -360.0
    else:
        near1, near4, near6 = near_deg[0], near_deg[3], near_deg[5]
        if not -180.0 <= j1 - near1 <= 180.0:
            j1 += 360.0 * round((near1 - j1) / 360.0)
        if not -180.0 <= j4 - near4 <= 180.0:
            j4 += 360.0 * round((near4 - j4) / 360.0)
        if not -180.0 <= j6 - near6 <= 180.0:
            j6 += 360.0 * round((near6 - j6) / 360.0)
    return j1, degrees(q2), j3, j4, degrees(q5), j6


def _flipped(joints: Joints, near_deg: tuple[float, ...] | None) -> Joints:
    """Return the same stance with the wrist bent the other way."""
    j1, j2, j3, j4, j5, j6 = joints
    near4, near6 = (0.0, 0.0) if near_deg is None else (near_deg[3], near_deg[5])
    return (
        j1, j2, j3, j4 - 180.0 if j4 > near4 else j4 + 180.0,
        -j5, j6 - 180.0 if j6 > near6 else j6 + 180.0,
    )  # fmt: skip
