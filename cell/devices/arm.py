"""What callers need of an arm and its controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from cell.geometry import JointPositions, Pose

Interpolation = Literal["joint", "linear"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmState:
    """The controller's state at one moment."""

    is_servo_on: bool
    is_moving: bool
    is_automatic: bool
    is_emergency_stopped: bool
    alarm: int
    """Number of the active alarm, 0 for none."""
    alarm_text: str
    override_percent: int
    has_right: bool = True
    """Whether commands that move are taken from us and from nobody else."""


class ArmSignals(Protocol):
    """What may be asked of an arm and its controller without moving anything.

    Every method raises `DeviceError` when the controller refuses and
    `DeviceTimeout` when it does not answer in time.
    """

    def read_pose(self) -> Pose:
        """Return where the tool point is."""

    def read_joints(self) -> JointPositions:
        """Return the joint angles."""

    def read_state(self) -> ArmState:
        """Return the controller's state."""

    def stop(self) -> None:
        """Stop any motion now; works in every state."""

    def reset_alarm(self) -> None:
        """Clear an active alarm whose cause is gone."""

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Switch one output of the controller."""

    def read_output(self, bit: int) -> bool:
        """Return whether one output is on."""


class OpenableArm(ArmSignals, Protocol):
    """An arm that may be brought up and asked, and not moved."""

    def open(self) -> str:
        """Connect, take control, clear alarms, switch the servos on; return the identity."""


class Arm(OpenableArm, Protocol):
    """An arm that moves only when its caller has passed the guard.

    Every method raises `DeviceError` when the controller refuses and
    `DeviceTimeout` when it does not answer or does not finish in time.
    """

    def close(self) -> None:
        """Stop, switch the servos off, give control back, disconnect."""

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of linear moves and the share of full speed of joint moves."""

    def move(
        self,
        pose: Pose,
        *,
        interpolation: Interpolation,
        posture: int,
        turns: int = 0,
        expected_s: float = 0.0,
    ) -> None:
        """Move the tool point to `pose` and return when the arm stands there.

        `posture` and `turns` are the controller's flags FL1 and FL2. `expected_s` is
        how long the caller thinks it takes; the driver need not ask before that.
        """

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Move every joint to its angle and return when the arm stands there."""
