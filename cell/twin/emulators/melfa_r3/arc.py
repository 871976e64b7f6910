"""The course of a circular move: through three points, or about a centre."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cell.drivers.melfa_r3 import tables
from cell.geometry import JointPositions, Pose
from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.paths import JointCourse
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.stand import ArmKinematics, Stand, six
from cell.twin.emulators.melfa_r3.turning import EvenTurn

_CHECK_SPACING_MM = 20.0
_LEAST_MM = 1e-3
_MOST_UNLIKE_MM = 0.5
"""How much the two distances from a given centre may differ."""

Vector = NDArray[np.float64]


class Circle:
    """A piece of a circle in space.

    Attributes:
        centre: Its centre, mm.
        angle: The angle that is gone through, rad.
        radius_mm: Its radius.
    """

    def __init__(self, start: Vector, centre: Vector, normal: Vector, angle: float) -> None:
        self.centre = centre
        self.angle = angle
        self._first = start - centre
        self.radius_mm = float(np.linalg.norm(self._first))
        self._second = np.cross(normal, self._first)

    def at(self, share: float) -> Vector:
        """Return the point at a share of the way."""
        turn = share * self.angle
        return self.centre + math.cos(turn) * self._first + math.sin(turn) * self._second

    @staticmethod
    def through(start: Vector, via: Vector, end: Vector, *, is_full: bool) -> Circle:
        """Return the arc from start through via to end, or the full circle.

        Raises:
            Refusal: The points lie on a line or on each other.
        """
        a, b = via - start, end - start
        across = np.cross(a, b)
        area = float(across @ across)
        if area < _LEAST_MM**4:
            raise Refusal(tables.ILLEGAL_POSITION, is_alarm=True)
        to_centre = np.cross(float(a @ a) * b - float(b @ b) * a, across) / (2.0 * area)
        normal = across / math.sqrt(area)
        centre = start + to_centre
        if is_full:
            return Circle(start, centre, normal, 2.0 * math.pi)
        # Via lies between start and end when going round the normal: that is how it was made.
        return Circle(start, centre, normal, _angle(start - centre, end - centre, normal))

    @staticmethod
    def about(start: Vector, end: Vector, centre: Vector) -> Circle:
        """Return the shorter arc from start to end about a centre.

        Raises:
            Refusal: The centre is not equally far from both, or the arc is half a circle.
        """
        first, last = start - centre, end - centre
        radius, other = float(np.linalg.norm(first)), float(np.linalg.norm(last))
        across = np.cross(first, last)
        size = float(np.linalg.norm(across))
        if abs(radius - other) > _MOST_UNLIKE_MM or size < _LEAST_MM * radius:
            raise Refusal(tables.ILLEGAL_POSITION, is_alarm=True)
        normal = across / size
        return Circle(start, centre, normal, _angle(first, last, normal))


class ArcCourse:
    """The tool point goes along a circle; its orientation turns evenly from start to end."""

    __slots__ = (
        "end_deg", "length_mm", "start_deg", "turn_deg",
        "_circle", "_end", "_kinematics", "_posture", "_start", "_turn",
    )  # fmt: skip

    def __init__(
        self,
        kinematics: ArmKinematics,
        start: Stand,
        target: Pose,
        end_deg: JointTuple,
        circle: Circle,
    ) -> None:
        first = start.pose
        self.start_deg = start.joints_deg
        self.end_deg = end_deg
        self.length_mm = circle.radius_mm * circle.angle
        self._turn = EvenTurn(first, target)
        self.turn_deg = self._turn.angle_deg
        self._kinematics = kinematics
        self._start, self._end = first, target
        self._posture = start.posture
        self._circle = circle

    def at(self, share: float) -> JointTuple:
        """Return the joint angles at a share of the way."""
        if share <= 0.0:
            return self.start_deg
        if share >= 1.0:
            return self.end_deg
        return six(self._solve(share, JointCourse(self.start_deg, self.end_deg).at(share)).values)

    def check(self) -> None:
        """Look at the way between start and end.

        Raises:
            UnreachablePose: A place on the way cannot be reached.
        """
        places = int(self.length_mm / _CHECK_SPACING_MM) + 8
        near = self.start_deg
        for place in range(1, places):
            near = six(self._solve(place / places, near).values)

    def _solve(self, share: float, near_deg: JointTuple) -> JointPositions:
        x, y, z = self._circle.at(share)
        if self.turn_deg < 1e-9:
            a, b, c = self._start.a_deg, self._start.b_deg, self._start.c_deg
        else:
            a, b, c = self._turn.at(share)
        return self._kinematics.solve(
            Pose(float(x), float(y), float(z), a, b, c), self._posture, JointPositions(near_deg)
        )


def point(pose: Pose) -> Vector:
    """Return a pose's position."""
    return np.array((pose.x_mm, pose.y_mm, pose.z_mm))


def _angle(first: Vector, last: Vector, normal: Vector) -> float:
    """Return the angle from one vector to another round a normal, 0 to 2 pi."""
    angle = math.atan2(float(np.cross(first, last) @ normal), float(first @ last))
    return angle if angle > 0 else angle + 2.0 * math.pi
