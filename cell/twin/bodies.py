"""What an emulator may do to the twin's world: its side of the physics.

Each emulator is handed one of these. The world decides what really happens (a
block stops the fingers, a low finger pushes a block); the emulator reports it
in its device's words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

JointTuple = tuple[float, float, float, float, float, float]


class JointPath(Protocol):
    """A motion that the controller has planned."""

    @property
    def start_s(self) -> float:
        """When it starts."""

    @property
    def end_s(self) -> float:
        """When the arm stands at the end."""

    def at(self, time_s: float) -> JointTuple:
        """Return the joint angles in degrees, clamped to start and end outside."""


class ArmBody(Protocol):
    """The arm's mechanics."""

    def joints_deg(self, now_s: float) -> JointTuple:
        """Return where the joints are."""

    def follow(self, path: JointPath) -> None:
        """Start a motion now; it replaces one under way."""

    def halt(self, now_s: float) -> None:
        """Stand still where the joints are."""

    def is_moving(self, now_s: float) -> bool:
        """Return whether a motion is under way."""

    def set_output(self, bit: int, *, is_on: bool, now_s: float) -> None:
        """Switch whatever hangs on an output of the controller."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerMotion:
    """How a motion of the fingers will go.

    Attributes:
        end_s: When the fingers stand still.
        end_mm: The opening they end at.
        is_blocked: Whether something stopped them before their target.
    """

    end_s: float
    end_mm: float
    is_blocked: bool


class FingerBody(Protocol):
    """The gripper's mechanics; openings are the total between both fingers."""

    def is_powered(self) -> bool:
        """Return whether the gripper has power (an output of the arm controller)."""

    def opening_mm(self, now_s: float) -> float:
        """Return the opening."""

    def begin(
        self, target_mm: float, speed_mm_s: float, acceleration_mm_s2: float, now_s: float
    ) -> FingerMotion:
        """Start towards an opening; the result says where and when it will end."""

    def halt(self, now_s: float) -> None:
        """Stand still at the present opening."""


class DisplayBody(Protocol):
    """The television's panel."""

    def set_lit(self, *, is_lit: bool, input_number: int, now_s: float) -> None:
        """Say whether the panel is lit and which input it shows."""
