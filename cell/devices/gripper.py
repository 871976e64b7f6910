"""What callers need of a two-finger gripper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True, kw_only=True)
class GripperState:
    """The gripper at one moment; the position is the opening between the fingers."""

    position_mm: float
    velocity_mm_s: float
    current_a: float
    is_referenced: bool
    is_moving: bool
    has_error: bool
    error: int
    """The device's error number, 0 for none."""
    error_text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GripResult:
    """How closing the fingers ended."""

    is_holding: bool
    width_mm: float


class Gripper(Protocol):
    """A gripper whose fingers open and close together.

    Every method raises `DeviceError` when the device refuses and `DeviceTimeout`
    when it does not answer or does not finish in time. Power is not its concern:
    whoever opens it has switched it on.
    """

    def open(self, *, may_move: bool = True) -> str:
        """Connect, acknowledge errors, reference if needed; return the identity.

        Args:
            may_move: Whether the fingers may move, as referencing makes them; when not, a
                gripper that needs referencing stays as it is until `reference`.
        """

    def close(self) -> None:
        """Stop and disconnect; the fingers keep what they hold."""

    def reference(self) -> None:
        """Find the zero position; the fingers open over their whole stroke."""

    def move_to(self, opening_mm: float) -> None:
        """Move the fingers to an opening and return when they stand there."""

    def grip(self, current_a: float) -> GripResult:
        """Close with a force set by the motor current until something holds the fingers."""

    def stop(self) -> None:
        """Stop the fingers now."""

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Return when the fingers stand at an opening."""

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state as soon as the fingers stand still."""

    def read_state(self) -> GripperState:
        """Return position, speed, current, flags and error."""

    def acknowledge(self) -> None:
        """Acknowledge latched errors."""
