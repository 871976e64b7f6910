"""The guard: nothing reaches an arm's driver that it has not passed.

It checks the whole path, not only its end: reach, joint limits, the flange's lowest
height, the cell's boxes against the arm's body, the speed of the tool and of each
joint. A start that already violates something (after a fault, or moved by hand) may
be left, but only inwards: until the arm is clear no violation may grow and none may
be added. Blocks and people are not known here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cell.devices.arm import Interpolation
from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics import Joints, SixAxisArm, matrix_from_pose
from cell.motion.bounds import require_joints, require_pose
from cell.motion.explain import Explainer
from cell.motion.hull import ArmHull, HandShape, Stance
from cell.motion.paths import JointPath, LinearPath, Path
from cell.motion.refusals import Fault
from cell.motion.sweep import Sweep
from cell.profile import BoxProfile, Profile

TURN_SPEED_DEG_S = 120.0
"""How fast the tool may turn along a line; matters where it turns more than it moves."""
_SAME_DEG = 0.05
KEPT_LINES = 4096
"""How many passed lines are remembered; on a lattice of 12 x 12 there are 528 steps."""


@dataclass(frozen=True, slots=True)
class GuardedMove:
    """A motion that the guard has passed.

    Attributes:
        interpolation: How the arm goes.
        start: Joint angles it starts from.
        end: Joint angles it ends at.
        end_pose: Where the tool point ends.
        posture: The controller's flag FL1 at the end.
        turns: The controller's flag FL2 at the end.
        duration_s: The least time it takes, without speeding up and slowing down.
    """

    interpolation: Interpolation
    start: JointPositions
    end: JointPositions
    end_pose: Pose
    posture: int
    turns: int
    duration_s: float


class Guard:
    """Passes or refuses motions of one arm in one cell.

    Args:
        arm: The arm with its limits and tool.
        boxes: Boxes that no moving part may enter.
        flange_min_z_mm: Lowest height of the flange.
        max_linear_speed_mm_s: Largest speed of the tool point along a line.
        hand: Shape of the empty hand.
        loaded_hand: Shape of the hand that holds a block.
    """

    def __init__(
        self,
        arm: SixAxisArm,
        *,
        boxes: Sequence[BoxProfile],
        flange_min_z_mm: float,
        max_linear_speed_mm_s: float,
        hand: HandShape,
        loaded_hand: HandShape,
    ) -> None:
        self.arm = arm
        self._max_speed_mm_s = max_linear_speed_mm_s
        # A verdict depends on nothing but the line itself: everything else is frozen.
        self._lines: dict[tuple[JointPositions, Pose, int, float, bool], GuardedMove] = {}
        bounds = [(*box.min_mm, *box.max_mm) for box in boxes]
        self._hulls = (ArmHull(arm, hand), ArmHull(arm, loaded_hand))
        self._sweeps = tuple(Sweep(arm, hull, bounds, flange_min_z_mm) for hull in self._hulls)
        self._recent: list[Stance | None] = [None, None]
        self._explainers = tuple(
            Explainer(arm, hull, sweep, [box.name for box in boxes], bounds, flange_min_z_mm)
            for hull, sweep in zip(self._hulls, self._sweeps, strict=True)
        )

    @staticmethod
    def from_profile(profile: Profile) -> Guard:
        """Return the guard of the cell that a profile describes."""
        hand = HandShape.of_gripper(profile.gripper)
        return Guard(
            SixAxisArm.from_profile(profile.arm),
            boxes=profile.boxes,
            flange_min_z_mm=profile.arm.flange_min_z_mm,
            max_linear_speed_mm_s=profile.arm.max_linear_speed_mm_s,
            hand=hand,
            loaded_hand=hand.holding(profile.blocks.values()),
        )

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

        Args:
            start: Where the joints stand.
            target: Where the tool point shall go.
            posture: The controller's flag FL1, the same along the whole line.
            speed_mm_s: Speed of the tool point.
            holds_block: Whether a block is between the fingers.

        Raises:
            MotionRefused: The motion is not allowed; the error says what, by how much,
                and how far it would be.
        """
        line = (start, target, posture, speed_mm_s, holds_block)
        known = self._lines.get(line)
        if known is None:
            known = self._check_line(*line)
            if len(self._lines) >= KEPT_LINES:
                self._lines.clear()
            self._lines[line] = known
        return known

    def _check_line(
        self,
        start: JointPositions,
        target: Pose,
        posture: int,
        speed_mm_s: float,
        holds_block: bool,
    ) -> GuardedMove:
        self._check_speed(speed_mm_s)
        require_pose(
            self.arm.forward(start),
            target,
            lambda pose: self._check_line(start, pose, posture, speed_mm_s, holds_block),
        )
        hull, sweep = self._hulls[holds_block], self._sweeps[holds_block]
        first = self._stance(start, holds_block)
        path = LinearPath(self.arm, hull, first, matrix_from_pose(target), posture)
        duration_s = max(path.way_mm / speed_mm_s, path.turn_deg / TURN_SPEED_DEG_S)
        if self.arm.posture(start) != posture and not self._is_start_of(path):
            raise self._explainers[holds_block].wrong_posture(path, posture)
        last, fault = self._travel(sweep, path, duration_s)
        if fault is not None:
            if fault.kind not in ("plane", "box"):
                self._check_reach(first, target, posture, holds_block)
            raise self._explainers[holds_block].refusal(path, last, fault, duration_s, speed_mm_s)
        self._recent[holds_block] = last
        return self._passed("linear", start, last.joints, target, posture, duration_s)

    def check_joint(
        self,
        start: JointPositions,
        target: JointPositions,
        *,
        percent: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of all joints at once to joint angles.

        Args:
            start: Where the joints stand.
            target: Where they shall go.
            percent: Share of the joints' full speed.
            holds_block: Whether a block is between the fingers.

        Raises:
            MotionRefused: The motion is not allowed.
        """
        arm = self.arm
        require_joints(target, arm.joint_min_deg, arm.joint_max_deg, ("deg",) * 6)
        end = _six(target)
        pose = arm.forward(target)
        return self._check_joint(start, end, pose, arm.posture(target), percent, holds_block)

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

        Args:
            start: Where the joints stand.
            target: Where the tool point shall go.
            posture: The controller's flag FL1 at the end.
            percent: Share of the joints' full speed.
            holds_block: Whether a block is between the fingers.

        Raises:
            MotionRefused: The motion is not allowed.
        """
        first = self._stance(start, holds_block)
        require_pose(
            self.arm.forward(start),
            target,
            lambda pose: self._check_reach(first, pose, posture, holds_block),
        )
        end = self._check_reach(first, target, posture, holds_block)
        return self._check_joint(start, end, target, posture, percent, holds_block)

    def _check_joint(
        self,
        start: JointPositions,
        end: Joints,
        pose: Pose,
        posture: int,
        percent: float,
        holds_block: bool,
    ) -> GuardedMove:
        if not 0.0 < percent <= 100.0:
            raise MotionRefused(
                "joint speed",
                value=percent,
                limit=100.0 if percent > 0 else 0.0,
                nearest=min(max(percent, 1.0), 100.0),
                unit="%",
                why="is out of range",
            )
        hull, sweep = self._hulls[holds_block], self._sweeps[holds_block]
        path = JointPath(hull, self._stance(start, holds_block), end)
        last, fault = self._travel(sweep, path, None)
        if fault is not None:
            raise self._explainers[holds_block].refusal(path, last, fault, None, percent)
        self._recent[holds_block] = last
        duration_s = 100.0 / percent * self._fastest_s(start.values, end)
        return self._passed("joint", start, end, pose, posture, duration_s)

    def _travel(
        self, sweep: Sweep, path: Path, duration_s: float | None
    ) -> tuple[Stance, Fault | None]:
        here = path.start
        if not sweep.is_clean(here) and next(sweep.faults(here), None) is not None:
            here, fault = sweep.escape(path, here)
            if fault is not None or here.t >= 1.0:
                return here, fault
        return sweep.walk(path, here, 1.0, duration_s)

    def _stance(self, start: JointPositions, holds_block: bool) -> Stance:
        """Return the stance of a start, most often that of the last move's end."""
        recent = self._recent[holds_block]
        if recent is not None and recent.joints == start.values:
            return recent._replace(t=0.0)
        return self._hulls[holds_block].stance(0.0, _six(start))

    def _check_reach(self, first: Stance, target: Pose, posture: int, holds_block: bool) -> Joints:
        """Return the joint angles of a target.

        A line to a target out of reach is stopped by the joints' speeds first, where
        the arm is nearly stretched; the reason is the target.
        """
        try:
            return _six(self.arm.solve(target, posture, JointPositions(first.joints)))
        except UnreachablePose as error:
            raise self._explainers[holds_block].unreachable(
                first, target, posture, error
            ) from error

    def _check_speed(self, speed_mm_s: float) -> None:
        limit = self._max_speed_mm_s
        if not 0.0 < speed_mm_s <= limit:
            raise MotionRefused(
                "linear speed",
                value=speed_mm_s,
                limit=limit if speed_mm_s > 0 else 0.0,
                nearest=min(max(speed_mm_s, 1.0), limit),
                unit="mm/s",
                why="is out of range",
            )

    def _is_start_of(self, path: LinearPath) -> bool:
        """Return whether the path's posture has its start on the border to another."""
        start = path.start.joints
        try:
            same = path.stance(0.0, start).joints
        except UnreachablePose:
            return False
        return all(abs(a - b) <= _SAME_DEG for a, b in zip(start, same, strict=True))

    def _fastest_s(self, start: Sequence[float], end: Joints) -> float:
        return max(
            abs(b - a) / speed
            for a, b, speed in zip(start, end, self.arm.joint_speed_deg_s, strict=True)
        )

    def _passed(
        self,
        interpolation: Interpolation,
        start: JointPositions,
        end: Joints,
        pose: Pose,
        posture: int,
        duration_s: float,
    ) -> GuardedMove:
        joints = JointPositions(end)
        turns = self.arm.turns(joints)
        return GuardedMove(interpolation, start, joints, pose, posture, turns, duration_s)


def _six(joints: JointPositions) -> Joints:
    j1, j2, j3, j4, j5, j6 = joints.values
    return (j1, j2, j3, j4, j5, j6)
