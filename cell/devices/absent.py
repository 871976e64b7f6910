"""Devices that the profile disables: they take every command, do nothing, and say so once.

"Once" is once an opening, so that a log tells what a session went without.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cell.devices.arm import ArmState, Interpolation
from cell.devices.gripper import GripperState, GripResult
from cell.geometry import JointPositions, Pose

OnSkip = Callable[[str, str], None]
"""Told the device and what is left out."""

DISABLED = "disabled in the profile"


class AbsentArm:
    """An `Arm` that moves nothing and tells of the place where it was last sent.

    Args:
        rest: Where it is taken to stand at first.
        forward: Gives the pose of joint positions.
        solve: Gives joint positions of a pose and a posture.
        on_skip: Told once an opening what is left out.
    """

    def __init__(
        self,
        rest: JointPositions,
        *,
        forward: Callable[[JointPositions], Pose],
        solve: Callable[[Pose, int], JointPositions],
        on_skip: OnSkip,
    ) -> None:
        self._joints = rest
        self._forward = forward
        self._solve = solve
        self._pose = forward(rest)
        self._on_skip = on_skip
        self._outputs: set[int] = set()

    def open(self) -> str:
        """Say that nothing will move."""
        self._on_skip("arm", "steps are answered, and nothing moves")
        return DISABLED

    def close(self) -> None:
        """Do nothing."""

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Do nothing."""

    def move(
        self,
        pose: Pose,
        *,
        interpolation: Interpolation,
        posture: int,
        turns: int = 0,
        expected_s: float = 0.0,
    ) -> None:
        """Tell of this place from now on."""
        self._pose, self._joints = pose, self._solve(pose, posture)

    def move_joints(self, joints: JointPositions, *, expected_s: float = 0.0) -> None:
        """Tell of this place from now on."""
        self._pose, self._joints = self._forward(joints), joints

    def read_pose(self) -> Pose:
        """Return where it was last sent."""
        return self._pose

    def read_joints(self) -> JointPositions:
        """Return where it was last sent."""
        return self._joints

    def read_state(self) -> ArmState:
        """Return a state in which nothing is wrong."""
        return ArmState(
            is_servo_on=True,
            is_moving=False,
            is_automatic=True,
            is_emergency_stopped=False,
            alarm=0,
            alarm_text="",
            override_percent=100,
        )

    def stop(self) -> None:
        """Do nothing: nothing moves."""

    def reset_alarm(self) -> None:
        """Do nothing: there is none."""

    def set_output(self, bit: int, *, is_on: bool) -> None:
        """Remember what would be switched."""
        (self._outputs.add if is_on else self._outputs.discard)(bit)

    def read_output(self, bit: int) -> bool:
        """Return what would be switched."""
        return bit in self._outputs


class AbsentGripper:
    """A `Gripper` that grips nothing.

    Args:
        opening_mm: Where its fingers are taken to stand.
        on_skip: Told once an opening what is left out.
    """

    def __init__(self, opening_mm: float, *, on_skip: OnSkip) -> None:
        self._opening_mm = opening_mm
        self._on_skip = on_skip

    def open(self, *, may_move: bool = True) -> str:
        """Say that nothing will be gripped."""
        self._on_skip("gripper", "nothing is gripped")
        return DISABLED

    def close(self) -> None:
        """Do nothing."""

    def reference(self) -> None:
        """Do nothing."""

    def move_to(self, opening_mm: float) -> None:
        """Tell of this opening from now on."""
        self._opening_mm = opening_mm

    def grip(self, current_a: float) -> GripResult:
        """Hold nothing."""
        return GripResult(is_holding=False, width_mm=0.0)

    def stop(self) -> None:
        """Do nothing."""

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Tell of this opening from now on."""
        self._opening_mm = opening_mm

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state at once."""
        return self.read_state()

    def read_state(self) -> GripperState:
        """Return a state in which nothing is wrong."""
        return GripperState(
            position_mm=self._opening_mm,
            velocity_mm_s=0.0,
            current_a=0.0,
            is_referenced=True,
            is_moving=False,
            has_error=False,
            error=0,
            error_text="",
        )

    def acknowledge(self) -> None:
        """Do nothing."""


class AbsentDisplay:
    """A `Display` that is never there and always as it should be.

    Args:
        number: The input it is taken to show.
        on_skip: Told once an opening what is left out.
    """

    def __init__(self, number: int, *, on_skip: OnSkip) -> None:
        self._number = number
        self._on_skip = on_skip

    def open(self) -> str:
        """Say that the playground keeps its look."""
        self._on_skip("display", "the playground keeps its look")
        return DISABLED

    def close(self) -> None:
        """Do nothing."""

    def switch_on(self) -> None:
        """Do nothing."""

    def switch_off(self) -> None:
        """Do nothing."""

    def is_on(self) -> bool:
        """Say yes, so that nobody waits for it."""
        return True

    def select_input(self, number: int) -> None:
        """Remember the number."""
        self._number = number

    def selected_input(self) -> int:
        """Return the input that was asked for."""
        return self._number

    def require_input(self, number: int) -> None:
        """Do nothing: any input is as good as another."""

    def set_volume(self, volume: int) -> None:
        """Do nothing."""

    def require_volume(self, volume: int) -> None:
        """Do nothing: any volume is as good as another."""


class AbsentScreen:
    """A `Screen` that remembers what it would show."""

    def __init__(self) -> None:
        self._picture = "black"

    def show(self, picture: str) -> None:
        """Remember the picture."""
        self._picture = picture

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Remember the picture's name."""
        self._picture = name

    def shown(self) -> str:
        """Return the picture that would be shown."""
        return self._picture

    def bookmark(self) -> Callable[[], None]:
        """Return what remembers the present picture again."""
        name = self._picture
        return lambda: self.show(name)
