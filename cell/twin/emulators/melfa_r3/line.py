"""The course of a straight move."""

from __future__ import annotations

import math

from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.paths import JointCourse
from cell.twin.emulators.melfa_r3.stand import ArmKinematics, Stand, six
from cell.twin.emulators.melfa_r3.turning import EvenTurn

_CHECK_SPACING_MM = 40.0
_CHECK_SPACING_DEG = 15.0


class LineCourse:
    """The tool point goes straight and turns evenly about one axis."""

    __slots__ = (
        "end_deg",
        "length_mm",
        "start_deg",
        "turn_deg",
        "_ends",
        "_kinematics",
        "_posture",
        "_turn",
    )

    def __init__(
        self, kinematics: ArmKinematics, start: Stand, target: Pose, end_deg: JointTuple
    ) -> None:
        first = start.pose
        self.start_deg = start.joints_deg
        self.end_deg = end_deg
        self.length_mm = math.sqrt(
            (target.x_mm - first.x_mm) ** 2
            + (target.y_mm - first.y_mm) ** 2
            + (target.z_mm - first.z_mm) ** 2
        )
        self._turn = None if _is_parallel(first, target) else EvenTurn(first, target)
        self.turn_deg = 0.0 if self._turn is None else self._turn.angle_deg
        self._kinematics = kinematics
        self._ends = (first, target)
        self._posture = start.posture

    def at(self, share: float) -> JointTuple:
        """Return the joint angles at a share of the way.

        Where the straight way leaves the reach for less than the spacing at which
        it was checked, the joints go evenly instead.
        """
        near = JointCourse(self.start_deg, self.end_deg).at(share)
        try:
            return six(self._solve(share, near).values)
        except UnreachablePose:
            return near

    def check(self) -> None:
        """Look at the way between start and end.

        Raises:
            UnreachablePose: A place on the way cannot be reached.
        """
        places = int(max(self.length_mm / _CHECK_SPACING_MM, self.turn_deg / _CHECK_SPACING_DEG))
        evenly = JointCourse(self.start_deg, self.end_deg)
        for place in range(1, places + 1):
            share = place / (places + 1)
            self._solve(share, evenly.at(share))

    def _solve(self, share: float, near_deg: JointTuple) -> JointPositions:
        first, target = self._ends
        x = first.x_mm + share * (target.x_mm - first.x_mm)
        y = first.y_mm + share * (target.y_mm - first.y_mm)
        z = first.z_mm + share * (target.z_mm - first.z_mm)
        if self._turn is None:
            a, b, c = first.a_deg, first.b_deg, first.c_deg
        else:
            a, b, c = self._turn.at(share)
        return self._kinematics.solve(
            Pose(x, y, z, a, b, c), self._posture, JointPositions(near_deg)
        )


def _is_parallel(first: Pose, second: Pose) -> bool:
    return (
        first.a_deg == second.a_deg and first.b_deg == second.b_deg and first.c_deg == second.c_deg
    )
