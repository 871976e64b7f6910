"""Plans motions: where they end, whether they may be, how long they take."""

from __future__ import annotations

from cell.drivers.melfa_r3 import tables
from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.arc import ArcCourse, Circle
from cell.twin.emulators.melfa_r3.line import LineCourse
from cell.twin.emulators.melfa_r3.paths import (
    ChainedCourse,
    Course,
    JointCourse,
    PlannedPath,
    Trapezoid,
    TurningCourse,
)
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.settings import ControllerSettings
from cell.twin.emulators.melfa_r3.stand import ArmKinematics, Stand, flange_height_mm, six

_STILL = 1e-9
_STANDS_AT_MM = 0.01
_LIMIT_SLACK_DEG = 1e-6


class Planner:
    """Plans moves under the speeds in force.

    Attributes:
        speed_mm_s: Speed of straight moves (SPD).
        joint_percent: Share of full speed of joint moves (JOVRD).
        program_percent: Override set by a statement (OVRD as a statement).
        acceleration_percent: Share of full acceleration (ACCEL).
        braking_percent: Share of full braking (ACCEL).
    """

    def __init__(self, kinematics: ArmKinematics, settings: ControllerSettings) -> None:
        self._kinematics = kinematics
        self._settings = settings
        self.reset_speeds()

    def reset_speeds(self) -> None:
        """Put the speeds of a program's start in force."""
        self.speed_mm_s = self._settings.max_linear_speed_mm_s
        self.joint_percent = 100.0
        self.program_percent = 100.0
        self.acceleration_percent = 100.0
        self.braking_percent = 100.0

    def stand(self, joints_deg: JointTuple) -> Stand:
        """Return where the arm stands with these joints."""
        return Stand(self._kinematics, joints_deg)

    def limit_mask(self, joints_deg: JointTuple) -> int:
        """Return a bit for each joint that stands at a limit, J1 in bit 0."""
        l1, l2, l3, l4, l5, l6 = self._settings.joint_min_deg
        h1, h2, h3, h4, h5, h6 = self._settings.joint_max_deg
        j1, j2, j3, j4, j5, j6 = joints_deg
        return (
            (not l1 < j1 < h1)
            | (not l2 < j2 < h2) << 1
            | (not l3 < j3 < h3) << 2
            | (not l4 < j4 < h4) << 3
            | (not l5 < j5 < h5) << 4
            | (not l6 < j6 < h6) << 5
        )

    def target_stand(self, joints_deg: JointTuple) -> Stand:
        """Return where the arm would stand with these joints.

        Raises:
            Refusal: A joint leaves its limits, or the flange is too low.
        """
        settings = self._settings
        for angle, low, high in zip(
            joints_deg, settings.joint_min_deg, settings.joint_max_deg, strict=True
        ):
            if not low - _LIMIT_SLACK_DEG <= angle <= high + _LIMIT_SLACK_DEG:
                raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True)
        stand = self.stand(joints_deg)
        if flange_height_mm(stand.pose, settings.tool_mm) < settings.flange_min_z_mm:
            raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True)
        return stand

    def solve(self, start: Stand, target: Pose, flags: tuple[int, int] | None) -> Stand:
        """Return the stand at a target; without flags the posture stays as it is.

        Raises:
            Refusal: The target is out of reach, limits or height, or its flags are none.
        """
        near = JointPositions(start.joints_deg)
        posture, turns = (start.posture, None) if flags is None else flags
        if not 0 <= posture <= 7:
            raise Refusal(tables.ILLEGAL_POSITION, is_alarm=True)
        if flange_height_mm(target, self._settings.tool_mm) < self._settings.flange_min_z_mm:
            raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True)
        try:
            joints = self._kinematics.solve(target, posture, near, turns)
        except UnreachablePose as error:
            raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True) from error
        return Stand(self._kinematics, six(joints.values), target, posture)

    def line(
        self, start: Stand, target: Pose, flags: tuple[int, int] | None, percent: float, at_s: float
    ) -> tuple[PlannedPath, Stand]:
        """Plan a straight move.

        Raises:
            Refusal: The target or the way is out of reach, or the posture would change.
        """
        end = self.solve(start, target, flags)
        if end.posture != start.posture:
            raise Refusal(tables.POSTURE_MISMATCH, is_alarm=True)
        course = LineCourse(self._kinematics, start, target, end.joints_deg)
        return self._along(course, start, end, percent, at_s), end

    def arc(
        self, start: Stand, begin: Pose, target: Pose, circle: Circle, percent: float, at_s: float
    ) -> tuple[PlannedPath, Stand]:
        """Plan a circular move; an arm that does not stand at its beginning goes there first.

        Raises:
            Refusal: The target or the way is out of reach, or the posture would change.
        """
        first = self.solve(start, begin, None)
        end = self.solve(first, target, None)
        course: TurningCourse = ArcCourse(self._kinematics, first, target, end.joints_deg, circle)
        to_begin = LineCourse(self._kinematics, start, begin, first.joints_deg)
        if to_begin.length_mm > _STANDS_AT_MM:
            course = ChainedCourse(to_begin, course)
        return self._along(course, start, end, percent, at_s), end

    def _along(
        self, course: TurningCourse, start: Stand, end: Stand, percent: float, at_s: float
    ) -> PlannedPath:
        """Check a course of the tool point and give it its time."""
        try:
            course.check()
        except UnreachablePose as error:
            raise Refusal(tables.PATH_OUT_OF_RANGE, is_alarm=True) from error
        settings = self._settings
        share = percent * self.program_percent * 1e-4
        ramp = self.acceleration_percent * 0.01
        timing: Trapezoid | None = None
        if course.length_mm > _STILL:
            speed = self.speed_mm_s * share
            timing = Trapezoid(course.length_mm, speed, settings.acceleration_mm_s2 * ramp)
        if course.turn_deg > _STILL:
            speed = settings.max_turn_speed_deg_s * share
            turning = Trapezoid(course.turn_deg, speed, speed * ramp / settings.ramp_s)
            if timing is None or turning.duration_s > timing.duration_s:
                timing = turning
        least_s = self._least_s(start.joints_deg, end.joints_deg)
        return self._path(course, timing, least_s, at_s)

    def joint_move(self, start: Stand, end: Stand, percent: float, at_s: float) -> PlannedPath:
        """Plan a move with even joints between two allowed stands."""
        settings = self._settings
        way_s = self._least_s(start.joints_deg, end.joints_deg)
        timing: Trapezoid | None = None
        if way_s > _STILL:
            rate = self.joint_percent * percent * self.program_percent * 1e-6
            ramp = self.acceleration_percent * 0.01 / settings.ramp_s
            timing = Trapezoid(way_s, rate, ramp)
        return self._path(JointCourse(start.joints_deg, end.joints_deg), timing, 0.0, at_s)

    def _least_s(self, start_deg: JointTuple, end_deg: JointTuple) -> float:
        """Return the time at full joint speed."""
        v1, v2, v3, v4, v5, v6 = self._settings.joint_speed_deg_s
        a1, a2, a3, a4, a5, a6 = start_deg
        b1, b2, b3, b4, b5, b6 = end_deg
        return max(
            abs(b1 - a1) / v1,
            abs(b2 - a2) / v2,
            abs(b3 - a3) / v3,
            abs(b4 - a4) / v4,
            abs(b5 - a5) / v5,
            abs(b6 - a6) / v6,
        )

    def _path(
        self,
        course: Course,
        timing: Trapezoid | None,
        least_s: float,
        at_s: float,
    ) -> PlannedPath:
        if timing is None:
            timing = Trapezoid(1.0, 1e9, 1e18)
        elif timing.duration_s < least_s:
            timing = timing.stretched_to(least_s)
        slower = self.braking_percent / self.acceleration_percent
        return PlannedPath(course, timing, at_s, timing.braking * slower)
