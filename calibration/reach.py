"""Whether the arm can bring its hand, pointing down, to places above the table."""

from __future__ import annotations

from collections.abc import Sequence

from cell.errors import CellError
from cell.geometry import JointPositions, Pose
from cell.motion.guard import Guard
from cell.profile import Profile


class TableReach:
    """Asks the cell's guard, without moving anything.

    Args:
        profile: The cell's profile.
    """

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self._guard = Guard.from_profile(profile)
        self._rest = JointPositions(tuple(profile.arm.rest_deg))

    def why_not(
        self, x_mm: float, y_mm: float, heights_mm: Sequence[float], *, holds_block: bool = False
    ) -> str:
        """Return why the tool point cannot go to a place; empty if it can.

        Args:
            x_mm: Robot x.
            y_mm: Robot y.
            heights_mm: Robot z, the highest first: it goes to that from where the arm rests,
                then straight down from one to the next.
            holds_block: Whether a block is between the fingers.
        """
        arm = self._profile.arm
        first, *rest = heights_mm
        z_mm = first
        try:
            move = self._guard.check_pose_joint(
                self._rest, Pose(x_mm, y_mm, first), posture=arm.posture,
                percent=arm.joint_speed_percent, holds_block=holds_block,
            )  # fmt: skip
            for z_mm in rest:
                move = self._guard.check_linear(
                    move.end, Pose(x_mm, y_mm, z_mm), posture=arm.posture,
                    speed_mm_s=arm.linear_speed_mm_s, holds_block=holds_block,
                )  # fmt: skip
        except CellError as error:
            return f"at z {z_mm:.0f} mm: {error}"
        return ""

    def why_not_lay(self, x_mm: float, y_mm: float) -> str:
        """Return why a block cannot be laid down at a place; empty if it can."""
        heights = self._profile.heights
        return self.why_not(x_mm, y_mm, (heights.service_mm, heights.laying_mm), holds_block=True)
