"""What the cell asks of a guard, whichever arm it is for."""

from __future__ import annotations

from typing import Protocol

from cell.geometry import JointPositions, Pose
from cell.motion.guard import GuardedMove


class PlacesTool(Protocol):
    """Where joints bring the tool point, and the other way round."""

    def forward(self, joints: JointPositions) -> Pose:
        """Return where the tool point is."""

    def solve(self, pose: Pose, posture: int, near: JointPositions | None = None) -> JointPositions:
        """Return the joints for a pose in a posture.

        Raises:
            UnreachablePose: None within the limits give the pose.
        """


class MotionFigures(Protocol):
    """The figures of an arm's profile that its guarded motions need."""

    @property
    def enabled(self) -> bool:
        """Whether the cell has its arm."""

    @property
    def linear_speed_mm_s(self) -> float:
        """Speed along lines until another is set."""

    @property
    def max_linear_speed_mm_s(self) -> float:
        """Greatest speed along lines."""

    @property
    def joint_speed_percent(self) -> float:
        """Share of the joints' speed until another is set."""

    @property
    def posture(self) -> int:
        """Posture of every pose."""

    @property
    def rest_deg(self) -> tuple[float, ...]:
        """Joint positions where the arm stands aside, in the joints' own units."""


class MotionGuard(Protocol):
    """Passes or refuses motions of one arm in one cell.

    Every method raises `MotionRefused` when a motion is not allowed.
    """

    @property
    def arm(self) -> PlacesTool:
        """The arm whose motions it judges."""

    def check_linear(
        self,
        start: JointPositions,
        target: Pose,
        *,
        posture: int,
        speed_mm_s: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of the tool point along a straight line."""

    def check_joint(
        self,
        start: JointPositions,
        target: JointPositions,
        *,
        percent: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of all joints at once to joint positions."""

    def check_pose_joint(
        self,
        start: JointPositions,
        target: Pose,
        *,
        posture: int,
        percent: float,
        holds_block: bool = False,
    ) -> GuardedMove:
        """Check a move of all joints at once to a pose."""
