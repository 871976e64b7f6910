"""The gripper emulator's handle on the twin's world."""

from __future__ import annotations

from cell.twin.bodies import FingerMotion
from cell.twin.world import World


class TwinFingers:
    """The world's fingers as a `cell.twin.bodies.FingerBody`."""

    def __init__(self, world: World) -> None:
        self._world = world

    def is_powered(self) -> bool:
        """Return whether the gripper has power."""
        return self._world.is_powered()

    def opening_mm(self, now_s: float) -> float:
        """Return the opening between the fingers."""
        return self._world.opening_mm(now_s)

    def begin(
        self, target_mm: float, speed_mm_s: float, acceleration_mm_s2: float, now_s: float
    ) -> FingerMotion:
        """Start towards an opening."""
        return self._world.begin(target_mm, speed_mm_s, acceleration_mm_s2, now_s)

    def halt(self, now_s: float) -> None:
        """Stand still at the present opening."""
        self._world.halt_fingers(now_s)
