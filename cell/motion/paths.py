"""How the arm goes from one stance to another: along a line, or joint by joint."""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt
from typing import Protocol

from cell.kinematics import Joints, Matrix34, SixAxisArm
from cell.motion.hull import ArmHull, Stance

LINEAR_STEP_MM = 25.0
LINEAR_STEP_DEG = 10.0
JOINT_STEP_DEG = 60.0
"""First cut of a joint move, by the sum of all joints' ways; refined where it is tight."""

_Axis = tuple[float, float, float]
_UPRIGHT: _Axis = (0.0, 0.0, 1.0)
_SAME = 1e-9
_SQUARE_DEG_EIGHTH = radians(1.0) ** 2 / 8.0


class Path(Protocol):
    """A motion as a function of t from 0 to 1, and how far it strays from its chords."""

    @property
    def start(self) -> Stance:
        """Where it starts."""

    @property
    def length_mm(self) -> float:
        """Its size: length of the tool's way, plus a millimetre for each degree of turning."""

    @property
    def steps(self) -> int:
        """Into how many parts it is cut at first."""

    def stance(self, t: float, near: Joints) -> Stance:
        """Return the stance at t, joint angles continuous with `near`.

        Raises:
            UnreachablePose: The arm cannot stand there, limits aside.
        """

    def sagitta_mm(self, first: Stance, last: Stance) -> tuple[float, float]:
        """Return how far links and hand may stray from straight lines in between."""


class JointPath:
    """All joints move at once, each evenly from its start to its end."""

    def __init__(self, hull: ArmHull, start: Stance, end: Joints) -> None:
        self._hull = hull
        self.start = start
        self._end = end
        self._way = tuple(e - s for s, e in zip(start.joints, end, strict=True))
        self.length_mm = sum(abs(way) for way in self._way)
        self.steps = 1 + int(self.length_mm / JOINT_STEP_DEG)

    def stance(self, t: float, near: Joints) -> Stance:
        """Return the stance at t."""
        if t >= 1.0:
            return self._hull.stance(1.0, self._end)
        s, w = self.start.joints, self._way
        joints = (
            s[0] + t * w[0], s[1] + t * w[1], s[2] + t * w[2],
            s[3] + t * w[3], s[4] + t * w[4], s[5] + t * w[5],
        )  # fmt: skip
        return self._hull.stance(t, joints)

    def sagitta_mm(self, first: Stance, last: Stance) -> tuple[float, float]:
        """Return a bound of the deviation from the chord, for links and hand."""
        return turning_sagitta_mm(first.joints, last.joints, self._hull.radii_mm)


class LinearPath:
    """The tool point moves along a line while the tool turns about one axis."""

    def __init__(
        self, arm: SixAxisArm, hull: ArmHull, start: Stance, target: Matrix34, posture: int
    ) -> None:
        self._arm = arm
        self._hull = hull
        self._target = target
        self._posture = posture
        self.start = start
        m = start.matrix
        self._dx, self._dy, self._dz = target[3] - m[3], target[7] - m[7], target[11] - m[11]
        self.way_mm = sqrt(self._dx**2 + self._dy**2 + self._dz**2)
        self._axis, self._angle = _turn_between(m, target)
        self.turn_deg = degrees(self._angle)
        self.length_mm = self.way_mm + self.turn_deg
        self.steps = 1 + int(
            max(self.way_mm / LINEAR_STEP_MM, self.turn_deg / LINEAR_STEP_DEG) - 1e-9
        )

    def stance(self, t: float, near: Joints) -> Stance:
        """Return the stance at t, in the path's posture."""
        if t >= 1.0:
            matrix = self._target
        else:
            m = self.start.matrix
            r = _turned(m, self._axis, t * self._angle) if self._angle else m
            matrix = (
                r[0], r[1], r[2], m[3] + t * self._dx,
                r[4], r[5], r[6], m[7] + t * self._dy,
                r[8], r[9], r[10], m[11] + t * self._dz,
            )  # fmt: skip
        return self._hull.stance(t, self._arm.follow(matrix, self._posture, near))

    def sagitta_mm(self, first: Stance, last: Stance) -> tuple[float, float]:
        """Return a bound of the deviation from the chord, for links and hand.

        The hand moves straight but for its turning. The joints do not move evenly, so
        the links get twice what even joint motion would need.
        """
        links, _ = turning_sagitta_mm(first.joints, last.joints, self._hull.radii_mm)
        turn = self._angle * (last.t - first.t)
        return 2.0 * links, self._hull.radii_mm[3] * turn * turn / 8.0


def turning_sagitta_mm(
    first: Joints, last: Joints, radii_mm: tuple[float, float, float, float]
) -> tuple[float, float]:
    """Return how far points of links and hand leave their chord in an even joint motion.

    A path with second derivative p'' over t in 0..1 stays within max|p''| / 8 of its
    chord, and |p''| <= sum over i, j of |dq_i| |dq_j| R_max(i, j) with R_j the reach
    past joint j, since the derivative by two joints is at most the distance from the
    outer one.
    """
    d1, d2, d3 = abs(last[0] - first[0]), abs(last[1] - first[1]), abs(last[2] - first[2])
    d4 = abs(last[3] - first[3]) + abs(last[4] - first[4]) + abs(last[5] - first[5])
    r1, r2, r3, r4 = radii_mm
    one, two, three = d1 * d1, (d1 + d2) ** 2, (d1 + d2 + d3) ** 2
    four = (d1 + d2 + d3 + d4) ** 2
    bent = r1 * one + r2 * (two - one) + r3 * (three - two)
    return bent * _SQUARE_DEG_EIGHTH, (bent + r4 * four) * _SQUARE_DEG_EIGHTH


def _turn_between(first: Matrix34, last: Matrix34) -> tuple[_Axis, float]:
    """Return axis and angle (rad, 0 to pi) of the rotation that takes `first` to `last`."""
    for index in (0, 1, 2, 4, 5, 6, 8, 9, 10):
        if not -_SAME <= first[index] - last[index] <= _SAME:
            break
    else:
        return _UPRIGHT, 0.0
    r = [
        [sum(last[4 * i + k] * first[4 * j + k] for k in range(3)) for j in range(3)]
        for i in range(3)
    ]
    x, y, z = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]
    double_sine = hypot(x, y, z)
    double_cosine = r[0][0] + r[1][1] + r[2][2] - 1.0
    if double_sine > _SAME:
        axis = (x / double_sine, y / double_sine, z / double_sine)
        return axis, atan2(double_sine, double_cosine)
    if double_cosine > 0.0:
        return _UPRIGHT, 0.0
    # Half a turn: R + I is twice the axis times itself, so its columns lie along the axis.
    columns = [[r[i][j] + (i == j) for i in range(3)] for j in range(3)]
    x, y, z = max(columns, key=lambda column: hypot(*column))
    size = hypot(x, y, z)
    return (x / size, y / size, z / size), pi


def _turned(m: Matrix34, axis: _Axis, angle: float) -> Matrix34:
    """Return a matrix turned about an axis of the robot frame (Rodrigues); x y z stay."""
    x, y, z = axis
    c, s = cos(angle), sin(angle)
    v = 1.0 - c
    rows = (
        (c + x * x * v, x * y * v - z * s, x * z * v + y * s),
        (y * x * v + z * s, c + y * y * v, y * z * v - x * s),
        (z * x * v - y * s, z * y * v + x * s, c + z * z * v),
    )
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = (
        tuple(row[0] * m[j] + row[1] * m[4 + j] + row[2] * m[8 + j] for j in range(3))
        for row in rows
    )
    return (r00, r01, r02, m[3], r10, r11, r12, m[7], r20, r21, r22, m[11])
