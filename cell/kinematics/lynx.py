"""The Lynx (AL5D): five turning joints, so a tool that leans only in the arm's own plane.

Lengths and signs are those of the D-H table of the University of Pennsylvania's Lynx: with
all joints at zero the upper arm stands upright and forearm and hand point forward, level.
J2, J3 and J4 lean the arm forward and down, J5 turns the fingers about the hand.

Everything happens in an upright plane through the base axis, which J1 turns. In it, with
`r` away from the axis and `z` up, from the shoulder at (0, d1):

    elbow = shoulder + a2 (sin q2, cos q2)
    wrist = elbow + a3 (cos q23, -sin q23)
    tool  = wrist + tool_mm (cos pitch, -sin pitch)       pitch = q2 + q3 + q4

The tool's z axis points along the hand; with the gripper down (pitch 90) the pose is
(180, 0, c) with c = q1 - q5.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, asin, atan2, cos, degrees, hypot, inf, pi, radians, sin

from cell.errors import ProfileError, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import JointUnit
from cell.kinematics.rotation import Matrix34, matrix_from_pose, pose_from_matrix
from cell.profile import LynxProfile

Five = tuple[float, float, float, float, float]
Points = tuple[tuple[float, float, float], ...]

ELBOW_UP = 0
"""Posture: the forearm bends forward and down from the upper arm; the usual one."""
ELBOW_DOWN = 1
"""Posture bit: the forearm bends backward; within the limits J3 passes 90 deg either way."""
BACKWARD = 2
"""Posture bit: the tool point lies behind the base axis, the arm leans over backwards."""

_NAMES = ("J1", "J2", "J3", "J4", "J5")
_LIMIT_SLACK_DEG = 1e-7
"""Rounding of a solution that stands exactly at a limit."""
_REACH_SLACK = 1e-9
_ON_AXIS_MM = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class LynxGeometry:
    """The lengths of the arm; the defaults are those of two files of the Penn course.

    Attributes:
        shoulder_mm: Height of the shoulder above the base (d1).
        upper_arm_mm: From shoulder to elbow (a2).
        forearm_mm: From elbow to wrist (a3).
        tool_mm: From the wrist to the middle between the fingertips (d4 + lg).
    """

    shoulder_mm: float = 76.2
    upper_arm_mm: float = 146.05
    forearm_mm: float = 187.325
    tool_mm: float = 68.0


@dataclass(frozen=True, slots=True)
class _Hand:
    """A pose taken apart, in the plane that J1 turns to.

    Attributes:
        q1_rad: Where J1 stands.
        wrist_r_mm: The wrist's distance from the base axis.
        wrist_z_mm: The wrist's height.
        pitch_rad: How far the hand points down from level.
        roll_rad: Where J5 stands.
    """

    q1_rad: float
    wrist_r_mm: float
    wrist_z_mm: float
    pitch_rad: float
    roll_rad: float


class LynxArm:
    """Kinematics of one Lynx, in millimetres and degrees, within its joint limits.

    Args:
        joint_min: Lower limits in degrees, J1 first.
        joint_max: Upper limits in degrees, J1 first.
        joint_speed: Greatest speeds in degrees a second, J1 first.
        geometry: The arm's lengths.
        lean_tolerance_deg: How far a pose's hand may point out of the arm's plane and still
            be taken for the nearest one in it.

    Raises:
        ProfileError: A lower limit is not below its upper limit.
    """

    def __init__(
        self,
        joint_min: Five,
        joint_max: Five,
        joint_speed: Five,
        geometry: LynxGeometry | None = None,
        *,
        lean_tolerance_deg: float = 0.01,
    ) -> None:
        for name, low, high in zip(_NAMES, joint_min, joint_max, strict=True):
            if low >= high:
                raise ProfileError(f"{name}: the lower limit {low:g} deg is not below {high:g}")
        self.geometry = LynxGeometry() if geometry is None else geometry
        self._joint_min = joint_min
        self._joint_max = joint_max
        self._joint_speed = joint_speed
        self._lean_tolerance_deg = lean_tolerance_deg

    @staticmethod
    def from_profile(profile: LynxProfile) -> LynxArm:
        """Return the arm that a profile describes."""
        lengths = profile.lengths
        return LynxArm(
            profile.joint_min_deg,
            profile.joint_max_deg,
            profile.joint_speed_deg_s,
            LynxGeometry(
                shoulder_mm=lengths.shoulder_mm,
                upper_arm_mm=lengths.upper_arm_mm,
                forearm_mm=lengths.forearm_mm,
                tool_mm=lengths.tool_mm,
            ),
        )

    @property
    def joint_units(self) -> tuple[JointUnit, ...]:
        """Unit of each joint: all five turn."""
        return ("deg",) * 5

    @property
    def joint_min(self) -> tuple[float, ...]:
        """Least angle of each joint in degrees."""
        return self._joint_min

    @property
    def joint_max(self) -> tuple[float, ...]:
        """Greatest angle of each joint in degrees."""
        return self._joint_max

    @property
    def joint_speed(self) -> tuple[float, ...]:
        """Greatest speed of each joint in degrees a second."""
        return self._joint_speed

    def forward(self, joints: JointPositions) -> Pose:
        """Return where the tool point is."""
        return pose_from_matrix(self.tool_matrix(joints.values))

    def tool_matrix(self, values: tuple[float, ...]) -> Matrix34:
        """Return robot-from-tool, the upper three rows in twelve floats."""
        q1, _, _, _, q5 = (radians(value) for value in values)
        pitch = radians(values[1] + values[2] + values[3])
        x, y, z = self.link_points_mm(values)[-1]
        c1, s1, cp, sp, c5, s5 = cos(q1), sin(q1), cos(pitch), sin(pitch), cos(q5), sin(q5)
        # Tool axes at q5 = 0: x is `up`, y is `right`, z is along the hand.
        up, right = (sp * c1, sp * s1, cp), (s1, -c1, 0.0)
        tool_x = tuple(c5 * u + s5 * v for u, v in zip(up, right, strict=True))
        tool_y = tuple(-s5 * u + c5 * v for u, v in zip(up, right, strict=True))
        return (
            tool_x[0], tool_y[0], cp * c1, x,
            tool_x[1], tool_y[1], cp * s1, y,
            tool_x[2], tool_y[2], -sp, z,
        )  # fmt: skip

    def link_points_mm(self, values: tuple[float, ...]) -> Points:
        """Return base, shoulder, elbow, wrist and tool point."""
        shape = self.geometry
        q1, q2 = radians(values[0]), radians(values[1])
        q23, pitch = radians(values[1] + values[2]), radians(values[1] + values[2] + values[3])
        elbow_r = shape.upper_arm_mm * sin(q2)
        elbow_z = shape.shoulder_mm + shape.upper_arm_mm * cos(q2)
        wrist_r = elbow_r + shape.forearm_mm * cos(q23)
        wrist_z = elbow_z - shape.forearm_mm * sin(q23)
        tool_r = wrist_r + shape.tool_mm * cos(pitch)
        tool_z = wrist_z - shape.tool_mm * sin(pitch)
        c1, s1 = cos(q1), sin(q1)
        return (
            (0.0, 0.0, 0.0),
            (0.0, 0.0, shape.shoulder_mm),
            (c1 * elbow_r, s1 * elbow_r, elbow_z),
            (c1 * wrist_r, s1 * wrist_r, wrist_z),
            (c1 * tool_r, s1 * tool_r, tool_z),
        )

    def posture(self, joints: JointPositions) -> int:
        """Return the posture bits of joint angles."""
        values = joints.values
        x, y, _ = self.link_points_mm(values)[-1]
        q1 = radians(values[0])
        # J3 is -90 with the arm stretched and 90 with the forearm folded onto the upper arm.
        is_down = cos(radians(values[2])) < 0.0
        is_backward = cos(q1) * x + sin(q1) * y < -_ON_AXIS_MM
        return (ELBOW_DOWN if is_down else ELBOW_UP) | (BACKWARD if is_backward else 0)

    def lean_deg(self, pose: Pose) -> float:
        """Return how far a pose's hand points out of the arm's plane, 0 to 90 degrees.

        That is the least turn of the tool that makes the pose one of a five-joint arm.
        """
        matrix = matrix_from_pose(pose)
        return abs(degrees(_lean_rad(matrix, _heading_rad(matrix, 0.0))))

    def nearest_pose(self, pose: Pose) -> Pose:
        """Return the pose at the same point whose orientation is the nearest that exists.

        Joint limits and reach are not looked at.
        """
        matrix = matrix_from_pose(pose)
        return pose_from_matrix(_leaned(matrix, _heading_rad(matrix, 0.0)))

    def solve(self, pose: Pose, posture: int, near: JointPositions | None = None) -> JointPositions:
        """Return the joint angles of a pose in one posture.

        Args:
            pose: Where the tool point shall be.
            posture: `ELBOW_UP` or `ELBOW_DOWN`, with `BACKWARD` added or not.
            near: J1 keeps its angle in this where it is free: the hand points straight up
                or down on the base axis. Without it J1 is 0 there.

        Raises:
            UnreachablePose: The hand points out of the arm's plane, the wrist is out of
                reach, or a joint would pass its limit; the error says by how much.
        """
        if not 0 <= posture <= ELBOW_DOWN | BACKWARD:
            raise UnreachablePose(
                f"the Lynx has no posture {posture}; 0 is elbow up, 1 elbow down, "
                "2 more is backwards over the shoulder",
                what="posture",
                value=posture,
                limit=ELBOW_DOWN | BACKWARD,
            )
        matrix = matrix_from_pose(pose)
        free_rad = 0.0 if near is None else radians(near.values[0])
        hand = self._hand(pose, matrix, posture, free_rad)
        values = self._angles(pose, hand, posture)
        self._require_limits(pose, values)
        return JointPositions(values)

    def _hand(self, pose: Pose, matrix: Matrix34, posture: int, free_rad: float) -> _Hand:
        heading = _heading_rad(matrix, free_rad)
        lean_deg = abs(degrees(_lean_rad(matrix, heading)))
        if lean_deg > self._lean_tolerance_deg:
            nearest = pose_from_matrix(_leaned(matrix, heading))
            raise UnreachablePose(
                f"the pose {pose} cannot be taken by five joints: the hand points "
                f"{lean_deg:.2f} deg out of the arm's plane; the nearest is {nearest}",
                what="lean",
                value=lean_deg,
                limit=self._lean_tolerance_deg,
                unit="deg",
            )
        q1 = _wrapped(heading + pi) if posture & BACKWARD else heading
        leaned = _leaned(matrix, heading)
        c1, s1 = cos(q1), sin(q1)
        pitch = atan2(-leaned[10], c1 * leaned[2] + s1 * leaned[6])
        # The tool's y axis is (sin q1, -cos q1, 0) at q5 = 0; its x axis turns towards it.
        roll = atan2(s1 * leaned[0] - c1 * leaned[4], s1 * leaned[1] - c1 * leaned[5])
        tool = self.geometry.tool_mm
        return _Hand(
            q1,
            c1 * pose.x_mm + s1 * pose.y_mm - tool * cos(pitch),
            pose.z_mm + tool * sin(pitch),
            pitch,
            roll,
        )

    def _angles(self, pose: Pose, hand: _Hand, posture: int) -> Five:
        """Return the joint angles of a hand, whatever their limits."""
        shape = self.geometry
        height = hand.wrist_z_mm - shape.shoulder_mm
        distance = hypot(hand.wrist_r_mm, height)
        upper, fore = shape.upper_arm_mm, shape.forearm_mm
        cosine = (distance**2 - upper**2 - fore**2) / (2 * upper * fore)
        if not -1.0 - _REACH_SLACK <= cosine <= 1.0 + _REACH_SLACK:
            raise self._out_of_reach(pose, distance)
        bend = acos(min(max(cosine, -1.0), 1.0))
        if posture & ELBOW_DOWN:
            bend = -bend
        # Angles from upright, growing forwards and down.
        line = atan2(hand.wrist_r_mm, height)
        q2 = _wrapped(line - atan2(fore * sin(bend), upper + fore * cos(bend)))
        q3 = _into(bend - pi / 2, radians(self._joint_min[2]), radians(self._joint_max[2]))
        q4 = _wrapped(hand.pitch_rad - q2 - q3)
        return (degrees(hand.q1_rad), degrees(q2), degrees(q3), degrees(q4), degrees(hand.roll_rad))

    def _out_of_reach(self, pose: Pose, distance_mm: float) -> UnreachablePose:
        shape = self.geometry
        outer = shape.upper_arm_mm + shape.forearm_mm
        inner = abs(shape.upper_arm_mm - shape.forearm_mm)
        is_far = distance_mm > outer
        limit = outer if is_far else inner
        return UnreachablePose(
            f"the pose {pose} cannot be reached: the wrist would be {distance_mm:.1f} mm from "
            f"the shoulder, {abs(distance_mm - limit):.1f} mm too {'far' if is_far else 'near'}",
            what="reach",
            value=distance_mm,
            limit=limit,
            unit="mm",
        )

    def _require_limits(self, pose: Pose, values: Five) -> None:
        worst, worst_excess = None, _LIMIT_SLACK_DEG
        for name, value, low, high in zip(
            _NAMES, values, self._joint_min, self._joint_max, strict=True
        ):
            limit = low if value < low else high
            excess = max(low - value, value - high, -inf)
            if excess > worst_excess:
                worst, worst_excess = (name, value, limit), excess
        if worst is None:
            return
        name, value, limit = worst
        raise UnreachablePose(
            f"the pose {pose} cannot be reached: {name} would have to stand at {value:.2f} deg, "
            f"{worst_excess:.2f} deg beyond its limit of {limit:.2f} deg",
            what=name,
            value=value,
            limit=limit,
            unit="deg",
        )


def _heading_rad(matrix: Matrix34, free_rad: float) -> float:
    """Return the angle about the base axis at which the arm's plane lies.

    The tool point decides it; on the axis the hand's direction does, and where that points
    straight up or down, too, it is `free_rad`.
    """
    x, y = matrix[3], matrix[7]
    if hypot(x, y) > _ON_AXIS_MM:
        return atan2(y, x)
    if hypot(matrix[2], matrix[6]) > _REACH_SLACK:
        return atan2(matrix[6], matrix[2])
    return free_rad


def _lean_rad(matrix: Matrix34, heading_rad: float) -> float:
    """Return how far the tool's z axis points out of the plane at `heading_rad`, to its left."""
    out = cos(heading_rad) * matrix[6] - sin(heading_rad) * matrix[2]
    return asin(min(max(out, -1.0), 1.0))


def _leaned(matrix: Matrix34, heading_rad: float) -> Matrix34:
    """Return the frame turned by the least angle that brings its z axis into the plane.

    Rodrigues' formula about the axis at right angles to z axis and plane's normal; a hand
    that points straight out of the plane may turn any way and is turned to point forward.
    """
    ahead = (cos(heading_rad), sin(heading_rad), 0.0)
    normal = (-ahead[1], ahead[0], 0.0)
    angle = _lean_rad(matrix, heading_rad)
    z_axis = (matrix[2], matrix[6], matrix[10])
    axis = _cross(z_axis, normal)
    length = hypot(*axis)
    axis = (0.0, 0.0, 1.0) if length < _REACH_SLACK else tuple(a / length for a in axis)
    turn = -angle
    columns = []
    for column in ((matrix[0], matrix[4], matrix[8]), (matrix[1], matrix[5], matrix[9]), z_axis):
        across = _cross(axis, column)
        along = sum(a * b for a, b in zip(axis, column, strict=True))
        columns.append(
            tuple(
                cos(turn) * v + sin(turn) * w + (1.0 - cos(turn)) * along * a
                for v, w, a in zip(column, across, axis, strict=True)
            )
        )
    (x0, x1, x2), (y0, y1, y2), (z0, z1, z2) = columns
    return (x0, y0, z0, matrix[3], x1, y1, z1, matrix[7], x2, y2, z2, matrix[11])


def _cross(u: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


def _wrapped(angle_rad: float) -> float:
    """Return an angle in [-pi, pi)."""
    return (angle_rad + pi) % (2 * pi) - pi


def _into(angle_rad: float, low_rad: float, high_rad: float) -> float:
    """Return the angle, a whole turn on or back if only that lies within the limits."""
    for turned in (angle_rad, angle_rad + 2 * pi, angle_rad - 2 * pi):
        if low_rad <= turned <= high_rad:
            return turned
    return angle_rad
