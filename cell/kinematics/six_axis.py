"""A six-axis arm with its limits and tool: forward, inverse, Jacobian, reach."""

from __future__ import annotations

from math import cos, hypot, radians, sin

import numpy as np
from numpy.typing import NDArray

from cell.errors import ProfileError, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.batch import BatchKinematics
from cell.kinematics.closed_form import ClosedForm, Joints, LinkPoints, OutOfReach
from cell.kinematics.flags import NON_FLIP, RIGHT, axis_turns, turns_flag
from cell.kinematics.geometry import GEOMETRIES, SixAxisGeometry
from cell.kinematics.rotation import Matrix34, matrix_from_pose, pose_from_matrix
from cell.kinematics.solutions import IkSolution, LimitViolation, ReachProblem
from cell.profile import MelfaProfile

_NAMES = ("J1", "J2", "J3", "J4", "J5", "J6")
_LIMIT_SLACK_DEG = 1e-7
"""Rounding of a solution that stands exactly at a limit."""


class SixAxisArm:
    """Kinematics of one arm, in millimetres and degrees, within its joint limits.

    Args:
        geometry: The arm's lengths.
        joint_min_deg: Lower limits, J1 first.
        joint_max_deg: Upper limits, J1 first.
        joint_speed_deg_s: Largest joint speeds, J1 first.
        tool_mm: The tool point in the flange frame.
    """

    def __init__(
        self,
        geometry: SixAxisGeometry,
        joint_min_deg: Joints,
        joint_max_deg: Joints,
        joint_speed_deg_s: Joints,
        tool_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        for axis, (low, high) in enumerate(zip(joint_min_deg, joint_max_deg, strict=True), 1):
            if low >= high:
                raise ProfileError(f"J{axis}: the lower limit {low:g} deg is not below {high:g}")
        self.geometry = geometry
        self.joint_min_deg = joint_min_deg
        self.joint_max_deg = joint_max_deg
        self.joint_speed_deg_s = joint_speed_deg_s
        self.tool_mm = tool_mm
        self._form = ClosedForm(geometry, tool_mm)
        self._bare = ClosedForm(geometry, (0.0, 0.0, 0.0))
        self._batch = BatchKinematics(geometry, tool_mm, joint_min_deg, joint_max_deg)
        self._low = tuple(limit - _LIMIT_SLACK_DEG for limit in joint_min_deg)
        self._high = tuple(limit + _LIMIT_SLACK_DEG for limit in joint_max_deg)
        self._low6, self._high6 = self._low[5], self._high[5]

    @staticmethod
    def from_profile(profile: MelfaProfile) -> SixAxisArm:
        """Return the arm that a profile describes."""
        return SixAxisArm(
            GEOMETRIES[profile.model],
            profile.joint_min_deg,
            profile.joint_max_deg,
            profile.joint_speed_deg_s,
            profile.tool_mm,
        )

    def forward(self, joints: JointPositions) -> Pose:
        """Return the pose of the tool point."""
        return pose_from_matrix(self._form.chain(joints.values)[1])

    def flange(self, joints: JointPositions) -> Pose:
        """Return the pose of the flange."""
        return pose_from_matrix(self._bare.chain(joints.values)[1])

    def chain(self, joints_deg: tuple[float, ...]) -> tuple[LinkPoints, Matrix34]:
        """Return link points and tool matrix of six joint angles in one go."""
        return self._form.chain(joints_deg)

    def link_points_mm(self, joints_deg: tuple[float, ...]) -> LinkPoints:
        """Return base, shoulder, elbow, forearm axis, wrist, flange and tool point."""
        return self._form.chain(joints_deg)[0]

    def tool_matrix(self, joints_deg: tuple[float, ...]) -> Matrix34:
        """Return robot-from-tool, the upper three rows in twelve floats."""
        return self._form.chain(joints_deg)[1]

    def posture(self, joints: JointPositions) -> int:
        """Return the controller's flag FL1 of joint angles."""
        return self._form.posture(joints.values)

    def turns(self, joints: JointPositions) -> int:
        """Return the controller's flag FL2 of joint angles."""
        return turns_flag(joints.values)

    def violations(self, joints_deg: tuple[float, ...]) -> tuple[LimitViolation, ...]:
        """Return every joint limit that the angles violate."""
        return tuple(
            [
                LimitViolation(name, angle, smallest if angle < low else largest)
                for name, angle, low, high, smallest, largest in zip(
                    _NAMES, joints_deg, self._low, self._high, self.joint_min_deg,
                    self.joint_max_deg, strict=True,
                )
                if not low <= angle <= high
            ]
        )  # fmt: skip

    def inverse(self, pose: Pose, near: JointPositions | None = None) -> tuple[IkSolution, ...]:
        """Return every solution of a pose, also those outside the joint limits.

        There are eight at most: none on a side that is out of reach, and where J5 is 0
        flip is the same as non-flip and left out. J6 is given in the turn nearest to
        `near` (or to 0) that its limits allow; `equivalents` lists the others. A free axis
        keeps its angle in `near`, or is 0: J4 where J5 is 0, J1 where the wrist lies on
        the J1 axis.
        """
        near_deg = None if near is None else near.values
        l1, l2, l3, l4, l5, l6 = self._low
        h1, h2, h3, h4, h5, h6 = self._high
        solutions = []
        for posture, joints in self._form.branches(matrix_from_pose(pose), near_deg):
            j1, j2, j3, j4, j5, j6 = joints
            if not l6 <= j6 <= h6:
                joints = (j1, j2, j3, j4, j5, self._turned_into_limits(j6))
                j6 = joints[5]
            is_allowed = (
                l1 <= j1 <= h1 and l2 <= j2 <= h2 and l3 <= j3 <= h3
                and l4 <= j4 <= h4 and l5 <= j5 <= h5 and l6 <= j6 <= h6
            )  # fmt: skip
            solutions.append(
                IkSolution(
                    JointPositions(joints),
                    posture,
                    0 if -180.0 <= j6 <= 180.0 else turns_flag(joints),
                    () if is_allowed else self.violations(joints),
                )
            )
        return tuple(solutions)

    def solve(
        self,
        pose: Pose,
        posture: int,
        near: JointPositions | None = None,
        turns: int | None = None,
    ) -> JointPositions:
        """Return the joint angles of a pose in one posture.

        Args:
            pose: Where the tool point shall be.
            posture: The controller's flag FL1.
            near: J6 takes the turn nearest to this; free axes keep their angle.
            turns: The controller's flag FL2; with it J6 takes that turn instead.

        Raises:
            UnreachablePose: It is out of reach or outside a joint limit; the error
                says which and by how much.
        """
        matrix = matrix_from_pose(pose)
        try:
            joints = self._form.branch(matrix, posture, None if near is None else near.values)
        except OutOfReach:
            raise self._unreachable(pose, posture) from None
        j6 = joints[5]
        if turns is not None:
            wanted = axis_turns(turns, 6) - axis_turns(turns_flag(joints), 6)
            joints = (*joints[:5], j6 + 360.0 * wanted)
        elif not self._low6 <= j6 <= self._high6:
            joints = (*joints[:5], self._turned_into_limits(j6))
        for low, angle, high in zip(self._low, joints, self._high, strict=True):
            if not low <= angle <= high:
                raise _as_error(pose, self._limit_problem(self.violations(joints), posture))
        return JointPositions(joints)

    def follow(self, matrix: Matrix34, posture: int, near_deg: tuple[float, ...] | None) -> Joints:
        """Return the joint angles of one posture, continuous with `near_deg`, unlimited.

        For sampling a path: J1, J4 and J6 are within a half turn of `near_deg` even if
        that leaves their limits.

        Raises:
            UnreachablePose: The wrist is out of reach.
        """
        try:
            return self._form.branch(matrix, posture, near_deg)
        except OutOfReach:
            raise self._unreachable(pose_from_matrix(matrix), posture) from None

    def equivalents(self, joints: JointPositions) -> tuple[JointPositions, ...]:
        """Return the joint angles with J6 in every turn that its limits allow."""
        first = joints.values[:5]
        return tuple(JointPositions((*first, angle)) for angle in self._turns_of(joints.values[5]))

    def jacobian(self, joints: JointPositions) -> NDArray[np.float64]:
        """Return the geometric Jacobian of the tool point, shape (6, 6), robot frame.

        Rows 0 to 2 are the tool point's velocity in mm for each deg of a joint, rows 3
        to 5 the tool's angular velocity in deg for each deg of a joint (a vector along
        the axis of rotation, not the rates of A, B, C).
        """
        points, matrix = self._form.chain(joints.values)
        tool = np.array(points[6])
        q1, q23, q4 = (
            radians(joints.values[0]),
            radians(sum(joints.values[1:3])),
            radians(joints.values[3]),
        )
        c1, s1, c23, s23, c4, s4 = cos(q1), sin(q1), cos(q23), sin(q23), cos(q4), sin(q4)
        level = (-s1, c1, 0.0)
        forearm = (c1 * s23, s1 * s23, c23)
        upright = (c1 * c23, s1 * c23, -s23)
        bend = tuple(c4 * y - s4 * x for x, y in zip(upright, level, strict=True))
        roll = (matrix[2], matrix[6], matrix[10])
        wrist = points[4]
        axes = (
            ((0.0, 0.0, 1.0), points[0]), (level, points[1]), (level, points[2]),
            (forearm, wrist), (bend, wrist), (roll, wrist),
        )  # fmt: skip
        jacobian = np.empty((6, 6))
        for column, (axis, origin) in enumerate(axes):
            jacobian[:3, column] = np.radians(np.cross(axis, tool - np.array(origin)))
            jacobian[3:, column] = axis
        return jacobian

    def forward_batch(self, joints_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return robot-from-tool matrices, shape (N, 4, 4), of joint angles (N, 6)."""
        return self._batch.forward(joints_deg)

    def inverse_batch(
        self, matrices: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return all solutions of many robot-from-tool matrices, shape (N, 4, 4).

        Returns:
            Joint angles in degrees, shape (N, 8, 6), where the second index is the
            posture FL1, NaN where out of reach; and a mask, shape (N, 8), of those within
            the joint limits. Free axes are 0; where J5 is 0 flip equals non-flip.
        """
        return self._batch.inverse(matrices)

    def is_reachable(self, pose: Pose, posture: int | None = None) -> bool:
        """Return whether the arm can stand at a pose, in one posture or in any."""
        return any(
            solution.is_allowed and _stands_in(solution, posture) for solution in self.inverse(pose)
        )

    def reach_problem(self, pose: Pose, posture: int | None = None) -> ReachProblem | None:
        """Return why the arm cannot stand at a pose, None if it can.

        Without a posture the one that comes closest is examined.
        """
        solutions = [found for found in self.inverse(pose) if _stands_in(found, posture)]
        if not solutions:
            return self._reach_problem(pose, posture)
        best = min(solutions, key=lambda solution: solution.worst_deg)
        if best.is_allowed:
            return None
        return self._limit_problem(best.violations, posture)

    def _turns_of(self, angle_deg: float) -> list[float]:
        first = angle_deg - 360.0 * ((angle_deg - self._low6) // 360.0)
        turns = []
        while first <= self._high6:
            turns.append(first)
            first += 360.0
        return turns

    def _turned_into_limits(self, angle_deg: float) -> float:
        """Return the allowed equivalent nearest to an angle, or the angle itself."""
        return min(
            self._turns_of(angle_deg),
            key=lambda turned: abs(turned - angle_deg),
            default=angle_deg,
        )

    def _unreachable(self, pose: Pose, posture: int) -> UnreachablePose:
        return _as_error(pose, self._reach_problem(pose, posture))

    def _limit_problem(
        self, violations: tuple[LimitViolation, ...], posture: int | None
    ) -> ReachProblem:
        worst = max(violations, key=lambda violation: violation.excess_deg)
        return ReachProblem(
            what=worst.joint,
            value=worst.value_deg,
            limit=worst.limit_deg,
            unit="deg",
            text=(
                f"{worst.joint} would have to stand at {worst.value_deg:.2f} deg, "
                f"{worst.excess_deg:.2f} deg beyond its limit of {worst.limit_deg:.2f} deg"
            ),
            posture=posture,
        )

    def _reach_problem(self, pose: Pose, posture: int | None) -> ReachProblem:
        """Return how far the wrist's centre is out of the shoulder's reach."""
        shape = self.geometry
        x, y, z = self._form.wrist(matrix_from_pose(pose))
        level, height = hypot(x, y), z - shape.d1_mm
        is_left = posture is not None and not posture & RIGHT
        distance = hypot(level + shape.a1_mm if is_left else level - shape.a1_mm, height)
        is_far = distance > shape.outer_reach_mm
        limit = shape.outer_reach_mm if is_far else shape.inner_reach_mm
        text = (
            f"the wrist, {level:.1f} mm from the upright axis and {z:.1f} mm high, would be "
            f"{distance:.1f} mm from the shoulder, {abs(distance - limit):.1f} mm too "
            f"{'far' if is_far else 'near'}"
        )
        return ReachProblem(
            what="reach", value=distance, limit=limit, unit="mm", text=text, posture=posture
        )


def _stands_in(solution: IkSolution, posture: int | None) -> bool:
    """Return whether a solution has a posture; a straight wrist is flip and non-flip."""
    if posture is None or solution.posture == posture:
        return True
    return solution.joints.values[4] == 0.0 and solution.posture == posture | NON_FLIP


def _as_error(pose: Pose, problem: ReachProblem) -> UnreachablePose:
    return UnreachablePose(
        f"the pose {pose} cannot be reached: {problem}",
        what=problem.what,
        value=problem.value,
        limit=problem.limit,
        unit=problem.unit,
    )
