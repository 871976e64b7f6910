"""Plans motions: where they end, whether they may be, how long they take."""

from __future__ import annotations

import math
from typing import Protocol

from cell.drivers.melfa_r3 import tables
from cell.errors import UnreachablePose
from cell.geometry import JointAngles, Pose, Transform
from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.paths import JointCourse, PlannedPath, Trapezoid
from cell.twin.emulators.melfa_r3.refusal import Refusal
from cell.twin.emulators.melfa_r3.settings import ControllerSettings

_CHECK_SPACING_MM = 40.0
_CHECK_SPACING_DEG = 15.0
_STILL = 1e-9
_LIMIT_SLACK_DEG = 1e-6


class ArmKinematics(Protocol):
    """What the controller needs to know of its arm; poses are the tool point's."""

    def solve(
        self,
        pose: Pose,
        posture: int,
        near: JointAngles | None = None,
        turns: int | None = None,
    ) -> JointAngles:
        """Return the joint angles of a pose in a posture (FL1) and turn (FL2).

        Raises:
            UnreachablePose: There are none within the limits.
        """

    def forward(self, joints: JointAngles) -> Pose:
        """Return the pose of joint angles."""

    def posture(self, joints: JointAngles) -> int:
        """Return the flag FL1 of joint angles."""

    def turns(self, joints: JointAngles) -> int:
        """Return the flag FL2 of joint angles."""


class Stand:
    """Where the arm stands: joints, pose and flags, computed when first asked for."""

    __slots__ = ("joints_deg", "_kinematics", "_pose", "_posture", "_reported")

    def __init__(
        self,
        kinematics: ArmKinematics,
        joints_deg: JointTuple,
        pose: Pose | None = None,
        posture: int | None = None,
    ) -> None:
        self.joints_deg = joints_deg
        self._kinematics = kinematics
        self._pose = pose
        self._posture = posture
        self._reported: Pose | None = None

    @property
    def pose(self) -> Pose:
        """The pose, as it was asked for if the arm was sent there."""
        if self._pose is None:
            self._pose = self.reported_pose
        return self._pose

    @property
    def reported_pose(self) -> Pose:
        """The pose that follows from the joints."""
        if self._reported is None:
            self._reported = self._kinematics.forward(JointAngles(self.joints_deg))
        return self._reported

    @property
    def posture(self) -> int:
        """The flag FL1."""
        if self._posture is None:
            self._posture = self._kinematics.posture(JointAngles(self.joints_deg))
        return self._posture

    @property
    def turns(self) -> int:
        """The flag FL2."""
        return self._kinematics.turns(JointAngles(self.joints_deg))


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
        self.turn_deg = _turn_deg(first, target)
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
            return six(self._solve(share, near).deg)
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

    def _solve(self, share: float, near_deg: JointTuple) -> JointAngles:
        pose = _between(*self._ends, share, is_turning=self.turn_deg > _STILL)
        return self._kinematics.solve(pose, self._posture, JointAngles(near_deg))


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
        near = JointAngles(start.joints_deg)
        posture, turns = (start.posture, None) if flags is None else flags
        if not 0 <= posture <= 7:
            raise Refusal(tables.ILLEGAL_POSITION, is_alarm=True)
        if flange_height_mm(target, self._settings.tool_mm) < self._settings.flange_min_z_mm:
            raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True)
        try:
            joints = self._kinematics.solve(target, posture, near, turns)
        except UnreachablePose as error:
            raise Refusal(tables.TARGET_OUT_OF_RANGE, is_alarm=True) from error
        return Stand(self._kinematics, six(joints.deg), target, posture)

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
        return self._path(course, timing, least_s, at_s), end

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
        return max(
            [
                abs(end - start) / speed
                for start, end, speed in zip(
                    start_deg, end_deg, self._settings.joint_speed_deg_s, strict=True
                )
            ]
        )

    def _path(
        self,
        course: JointCourse | LineCourse,
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


def six(angles_deg: tuple[float, ...]) -> JointTuple:
    """Return six joint angles as the twin's tuple."""
    a, b, c, d, e, f = angles_deg
    return a, b, c, d, e, f


def flange_height_mm(pose: Pose, tool_mm: tuple[float, float, float]) -> float:
    """Return the flange's height: the tool point's less the third row of R times the tool."""
    a, b = math.radians(pose.a_deg), math.radians(pose.b_deg)
    level = math.cos(b)
    x, y, z = tool_mm
    return pose.z_mm + math.sin(b) * x - level * (math.sin(a) * y + math.cos(a) * z)


def _turn_deg(first: Pose, second: Pose) -> float:
    """Return the angle between two orientations."""
    if first.a_deg == second.a_deg and first.b_deg == second.b_deg and first.c_deg == second.c_deg:
        return 0.0
    return _axis_angle(first, second)[3]


def _axis_angle(first: Pose, second: Pose) -> tuple[float, float, float, float]:
    """Return axis (in the first frame) and angle in degrees of first-from-second."""
    r = (Transform.from_pose(first).inverse() @ Transform.from_pose(second)).rotation
    x, y, z = (float(r[2, 1] - r[1, 2]), float(r[0, 2] - r[2, 0]), float(r[1, 0] - r[0, 1]))
    sine = math.sqrt(x * x + y * y + z * z)
    trace = float(r[0, 0] + r[1, 1] + r[2, 2]) - 1.0
    angle_deg = math.degrees(math.atan2(sine, trace))
    if sine > 1e-9:
        return x / sine, y / sine, z / sine, angle_deg
    if trace > 0:
        return 0.0, 0.0, 1.0, 0.0
    # Half a turn: the axis is the column of (R + 1) / 2 with the largest diagonal.
    column = max(range(3), key=lambda i: float(r[i, i]))
    axis = [float(r[i, column]) + (i == column) for i in range(3)]
    length = math.sqrt(sum(part * part for part in axis))
    return axis[0] / length, axis[1] / length, axis[2] / length, 180.0


def _between(first: Pose, second: Pose, share: float, *, is_turning: bool) -> Pose:
    """Return the pose at a share of the straight way."""
    x = first.x_mm + share * (second.x_mm - first.x_mm)
    y = first.y_mm + share * (second.y_mm - first.y_mm)
    z = first.z_mm + share * (second.z_mm - first.z_mm)
    if not is_turning:
        return Pose(x, y, z, first.a_deg, first.b_deg, first.c_deg)
    kx, ky, kz, angle_deg = _axis_angle(first, second)
    half = math.radians(share * angle_deg) / 2
    turned = Transform.from_pose(first) @ _turn(kx, ky, kz, half)
    pose = turned.to_pose()
    return Pose(x, y, z, pose.a_deg, pose.b_deg, pose.c_deg)


def _turn(kx: float, ky: float, kz: float, half_rad: float) -> Transform:
    """Return the rotation about an axis by twice `half_rad`, through its quaternion."""
    w, s = math.cos(half_rad), math.sin(half_rad)
    x, y, z = s * kx, s * ky, s * kz
    matrix = Transform.identity().matrix.copy()
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return Transform(matrix)
