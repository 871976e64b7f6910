"""What guard and emulators need of any arm's kinematics, whatever its joints are."""

from __future__ import annotations

from typing import Literal, Protocol

from cell.geometry import JointPositions, Pose

JointUnit = Literal["deg", "mm"]


class ArmKinematics(Protocol):
    """The geometry of one serial arm with its limits."""

    @property
    def joint_units(self) -> tuple[JointUnit, ...]:
        """Unit of each joint, the first one first; their number is the arm's."""

    @property
    def joint_min(self) -> tuple[float, ...]:
        """Least position of each joint, in its unit."""

    @property
    def joint_max(self) -> tuple[float, ...]:
        """Greatest position of each joint, in its unit."""

    @property
    def joint_speed(self) -> tuple[float, ...]:
        """Greatest speed of each joint, in its unit a second."""

    def forward(self, joints: JointPositions) -> Pose:
        """Return where the tool point is."""

    def solve(self, pose: Pose, posture: int, near: JointPositions | None = None) -> JointPositions:
        """Return the joints for a pose, in a posture, nearest to `near` where there is a choice.

        Raises:
            UnreachablePose: None within the limits give the pose.
        """

    def link_points_mm(self, values: tuple[float, ...]) -> tuple[tuple[float, float, float], ...]:
        """Return points along the arm, base first, tool point last; links run between them."""
