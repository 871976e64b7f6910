"""The guard of any arm that is a chain of links, with the interface of the six-axis one.

It checks the whole path: reach, joint limits, the cell's boxes against the links, the work
space of the tool point, the speed of the tool and of each joint. How it looks between the
points that it computes, `chain_sweep` tells. A start that already violates something may be
left, but only inwards. A line is checked as the driver cuts it into joint moves, only finer.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import dist
from typing import Protocol

from cell.devices.arm import Interpolation
from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.kinematics.line import pose_between
from cell.motion.bounds import require_joints, require_pose
from cell.motion.boxes import AXES, Bounds
from cell.motion.chain_hull import ChainHull, ChainShape
from cell.motion.chain_sweep import MARGIN_MM, ChainStance, ChainSweep, ChainWalk
from cell.motion.guard import TURN_SPEED_DEG_S, GuardedMove
from cell.motion.hull import GROUPS
from cell.motion.refusals import Fault
from cell.profile.playground import BoxProfile

LINE_STEP_MM = 2.0
LINE_STEP_DEG = 2.0
"""A line is cut at least this finely before the joints between are looked at."""
_JUMP_DEG = 15.0
_HALVINGS = 14
_STILL = 1e-6
_ROUNDING = 1e-6
"""Share of a joint's speed by which rounding may exceed it."""


class LineLaw(Protocol):
    """How an arm's driver cuts a line into joint moves."""

    def __call__(
        self,
        start: JointPositions,
        target: Pose,
        posture: int,
        *,
        step_mm: float,
        step_deg: float,
    ) -> list[JointPositions]:
        """Return the joints at equal shares of a line, the start left out, the target last.

        Raises:
            UnreachablePose: A point of the line cannot be reached in the posture.
        """


class ChainGuard:
    """Passes or refuses motions of one arm in one cell.

    Args:
        arm: The arm with its limits.
        shape: How thick its links are.
        line: How its driver cuts a line.
        boxes: Boxes that no moving part may enter.
        max_linear_speed_mm_s: Largest speed of the tool point along a line.
        work_space: Box that the tool point must not leave, low corner first, or None.
    """

    def __init__(
        self,
        arm: ArmKinematics,
        shape: ChainShape,
        line: LineLaw,
        *,
        boxes: Sequence[BoxProfile],
        max_linear_speed_mm_s: float,
        work_space: Bounds | None = None,
    ) -> None:
        self._arm = arm
        self._line = line
        self._max_speed_mm_s = max_linear_speed_mm_s
        self._names = tuple(box.name for box in boxes)
        self._work_space = work_space
        bounds = [(*box.min_mm, *box.max_mm) for box in boxes]
        hull = ChainHull(arm, shape, margin_mm=MARGIN_MM)
        self._sweeps = tuple(
            ChainSweep(arm, hull, bounds, work_space, is_loaded=is_loaded)
            for is_loaded in (False, True)
        )

    @property
    def arm(self) -> ArmKinematics:
        """The arm whose motions it judges."""
        return self._arm

    def check_linear(
        self,
        start: JointPositions,
        target: Pose,
        *,
        posture: int,
        speed_mm_s: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of the tool point along a straight line.

        Raises:
            MotionRefused: The motion is not allowed; the error says what, by how much,
                and how far it would be.
        """
        _require_in_range("linear speed", speed_mm_s, self._max_speed_mm_s, "mm/s")
        require_pose(
            self._arm.forward(start),
            target,
            lambda pose: self.check_linear(
                start, pose, posture=posture, speed_mm_s=speed_mm_s, holds_block=holds_block
            ),
        )
        try:
            stances = self._line(
                start, target, posture, step_mm=LINE_STEP_MM, step_deg=LINE_STEP_DEG
            )
        except UnreachablePose as error:
            raise self._unreachable(start, target, posture, error, "along the line") from error
        path = [start, *stances]
        first = self._arm.forward(start)
        way_mm = dist(_point(first), _point(target))
        duration_s = max(way_mm / speed_mm_s, _turn_deg(first, target) / TURN_SPEED_DEG_S)
        self._check_path(path, holds_block)
        self._check_jumps(path)
        self._check_joint_speeds(path, duration_s, speed_mm_s)
        return GuardedMove("linear", start, stances[-1], target, posture, 0, duration_s)

    def check_joint(
        self,
        start: JointPositions,
        target: JointPositions,
        *,
        percent: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of all joints at once to joint positions.

        Raises:
            MotionRefused: The motion is not allowed.
        """
        arm = self._arm
        require_joints(target, arm.joint_min, arm.joint_max, arm.joint_units)
        return self._check_joint(start, target, arm.forward(target), 0, percent, holds_block)

    def check_pose_joint(
        self,
        start: JointPositions,
        target: Pose,
        *,
        posture: int,
        percent: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of all joints at once to a pose; the tool point's path is a curve.

        Raises:
            MotionRefused: The motion is not allowed.
        """
        require_pose(
            self._arm.forward(start),
            target,
            lambda pose: self._solve(start, pose, posture),
        )
        end = self._solve(start, target, posture)
        return self._check_joint(start, end, target, posture, percent, holds_block)

    def _solve(self, start: JointPositions, target: Pose, posture: int) -> JointPositions:
        try:
            return self._arm.solve(target, posture, start)
        except UnreachablePose as error:
            raise self._unreachable(start, target, posture, error, f"for {target}") from error

    def _check_joint(
        self,
        start: JointPositions,
        end: JointPositions,
        pose: Pose,
        posture: int,
        percent: float,
        holds_block: bool,
    ) -> GuardedMove:
        _require_in_range("joint speed", percent, 100.0, "%")
        self._check_path([start, end], holds_block)
        fastest_s = max(
            abs(b - a) / speed
            for a, b, speed in zip(start.values, end.values, self._arm.joint_speed, strict=True)
        )
        interpolation: Interpolation = "joint"
        duration_s = 100.0 / percent * fastest_s
        return GuardedMove(interpolation, start, end, pose, posture, 0, duration_s)

    def _check_path(self, path: Sequence[JointPositions], holds_block: bool) -> None:
        sweep = self._sweeps[holds_block]
        walk = sweep.walk([joints.values for joints in path])
        if walk.fault is not None:
            raise self._refusal(walk, walk.fault, sweep.stance(path[-1].values))

    def _check_jumps(self, path: Sequence[JointPositions]) -> None:
        for here, there in pairwise(path):
            for axis, (a, b) in enumerate(zip(here.values, there.values, strict=True)):
                if self._arm.joint_units[axis] == "deg" and abs(b - a) > _JUMP_DEG:
                    raise MotionRefused(
                        f"J{axis + 1}", value=b, limit=a, nearest=a, unit="deg",
                        why="would have to jump where the arm passes a singular stance",
                        nearest_point_mm=_point(self._arm.forward(here)),
                    )  # fmt: skip

    def _check_joint_speeds(
        self, path: Sequence[JointPositions], duration_s: float, speed_mm_s: float
    ) -> None:
        """Refuse a line that some joint cannot follow; the stretches take equal times."""
        step_s = duration_s / (len(path) - 1)
        worst, worst_axis = 1.0 + _ROUNDING, -1
        for here, there in pairwise(path):
            for axis, (a, b, speed) in enumerate(
                zip(here.values, there.values, self._arm.joint_speed, strict=True)
            ):
                if abs(b - a) > _STILL and abs(b - a) > worst * speed * step_s:
                    worst = abs(b - a) / (speed * step_s) if step_s else float("inf")
                    worst_axis = axis
        if worst_axis >= 0:
            allowed = speed_mm_s / worst
            raise MotionRefused(
                "linear speed", value=speed_mm_s, limit=allowed, nearest=allowed, unit="mm/s",
                why=f"is more than J{worst_axis + 1} can follow "
                f"({self._arm.joint_speed[worst_axis]:g} {self._arm.joint_units[worst_axis]}/s)",
            )  # fmt: skip

    def _refusal(self, walk: ChainWalk, fault: Fault, end: ChainStance) -> MotionRefused:
        last, worst = walk.last, walk.worst or walk.last
        if fault.kind == "joint":
            axis = fault.index
            low, high = self._arm.joint_min[axis], self._arm.joint_max[axis]
            value = worst.values[axis]
            return MotionRefused(
                f"J{axis + 1}",
                value=value,
                limit=low if value < low else high,
                nearest=last.values[axis],
                unit=self._arm.joint_units[axis],
                why="would pass its limit",
                nearest_point_mm=last.tool_mm,
            )
        if fault.kind == "box":
            axis = max(range(3), key=lambda index: abs(end.tool_mm[index] - last.tool_mm[index]))
            return MotionRefused(
                f"tool {AXES[axis]}",
                value=end.tool_mm[axis],
                limit=last.tool_mm[axis],
                nearest=last.tool_mm[axis],
                unit="mm",
                why=f"would bring the {GROUPS[fault.group]} into the {self._names[fault.index]}",
                nearest_point_mm=last.tool_mm,
            )
        return self._out_of_work_space(last, worst)

    def _out_of_work_space(self, last: ChainStance, worst: ChainStance) -> MotionRefused:
        bounds = self._work_space or (0.0,) * 6
        beyond = [bounds[i] - worst.tool_mm[i] for i in range(3)] + [
            worst.tool_mm[i] - bounds[3 + i] for i in range(3)
        ]
        face = max(range(6), key=lambda index: beyond[index])
        axis = face % 3
        return MotionRefused(
            f"tool {AXES[axis]}",
            value=worst.tool_mm[axis],
            limit=bounds[face],
            nearest=last.tool_mm[axis],
            unit="mm",
            why="would leave the work space",
            nearest_point_mm=last.tool_mm,
        )

    def _unreachable(
        self,
        start: JointPositions,
        target: Pose,
        posture: int,
        error: UnreachablePose,
        where: str,
    ) -> MotionRefused:
        """Return the error for a pose that the arm cannot take.

        The nearest allowed values are those of the last reachable point on the straight line
        from where the tool stands.
        """
        first = self._arm.forward(start)
        low, high, best = 0.0, 1.0, start
        for _ in range(_HALVINGS):
            share = 0.5 * (low + high)
            try:
                best = self._arm.solve(pose_between(first, target, share), posture, best)
                low = share
            except UnreachablePose:
                high = share
        here = self._arm.forward(best)
        is_joint = error.what.startswith("J")
        return MotionRefused(
            error.what,
            value=error.value,
            limit=error.limit,
            nearest=best.values[int(error.what[1:]) - 1] if is_joint else error.limit,
            unit=error.unit,
            why=("cannot go far enough " if is_joint else "is not possible ") + where,
            nearest_point_mm=_point(here),
        )


def _require_in_range(what: str, value: float, limit: float, unit: str) -> None:
    if not 0.0 < value <= limit:
        raise MotionRefused(
            what,
            value=value,
            limit=limit if value > 0 else 0.0,
            nearest=min(max(value, 1.0), limit),
            unit=unit,
            why="is out of range",
        )


def _point(pose: Pose) -> tuple[float, float, float]:
    return pose.x_mm, pose.y_mm, pose.z_mm


def _turn_deg(first: Pose, last: Pose) -> float:
    """Return an upper bound of how far the tool turns along a line."""
    return sum(
        abs((b - a + 180.0) % 360.0 - 180.0)
        for a, b in (
            (first.a_deg, last.a_deg),
            (first.b_deg, last.b_deg),
            (first.c_deg, last.c_deg),
        )
    )
