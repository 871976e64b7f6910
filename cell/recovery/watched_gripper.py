"""The gripper as the rest of the cell may use it: brought back after faults, else the arm is held.

Fingers that open at the wrong moment drop a block, so they, too, move only when the resume
check allows it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from cell.devices.gripper import Gripper, GripperState, GripResult
from cell.errors import CellError, DeviceError, LinkError, OutOfRange
from cell.motion.guarded import GuardedArm
from cell.recovery.policy import may_recover
from cell.reporting import FaultReporter

_T = TypeVar("_T")


class WatchedGripper:
    """A `cell.devices.gripper.Gripper` whose motions are watched over.

    Args:
        gripper: The gripper itself.
        arm: The arm that is held when the gripper fails for good.
        may_hold_block: Says whether a block may be between the fingers.
        power_up: Switches the gripper's power on, if it is off.
        reporter: Told when it was brought back.
    """

    def __init__(
        self,
        gripper: Gripper,
        arm: GuardedArm,
        *,
        may_hold_block: Callable[[], bool],
        power_up: Callable[[], None],
        reporter: FaultReporter,
    ) -> None:
        self._gripper = gripper
        self._arm = arm
        self._may_hold_block = may_hold_block
        self._power_up = power_up
        self._reporter = reporter

    @property
    def gripper(self) -> Gripper:
        """The gripper itself."""
        return self._gripper

    def open(self, *, may_move: bool = True) -> str:
        """Bring it up; it is referenced only if nothing is held and nothing can be dropped."""
        is_free = may_move and not self._arm.is_held and not self._may_hold_block()
        return self._gripper.open(may_move=is_free)

    def close(self) -> None:
        """Stop and disconnect; the fingers keep what they hold."""
        self._gripper.close()

    def reference(self) -> None:
        """Find the zero position; the fingers open wide, even when they hold something."""
        self._moving(self._gripper.reference)

    def move_to(self, opening_mm: float) -> None:
        """Move the fingers to an opening and return when they stand there."""
        self._moving(lambda: self._gripper.move_to(opening_mm))

    def grip(self, current_a: float) -> GripResult:
        """Close with a force set by the motor current until something holds the fingers."""
        return self._moving(lambda: self._gripper.grip(current_a))

    def stop(self) -> None:
        """Stop the fingers now."""
        self._gripper.stop()

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Return when the fingers stand at an opening."""
        self._gripper.wait_for_position(opening_mm, timeout_s)

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state as soon as the fingers stand still."""
        return self._gripper.wait_for_stop(timeout_s)

    def read_state(self) -> GripperState:
        """Return position, speed, current, flags and error."""
        try:
            return self._gripper.read_state()
        except CellError as error:
            raise self._arm.fail("gripper", error) from error

    def acknowledge(self) -> None:
        """Acknowledge latched errors."""
        self._gripper.acknowledge()

    def _moving(self, work: Callable[[], _T]) -> _T:
        """Do a motion; after a fault bring the gripper back and do it once more, or hold the arm.

        Raises:
            ResumeRefused: The arm is held and the check is not clear.
            DeviceError: The gripper could not be brought back.
        """
        self._arm.ensure_clear()
        try:
            return work()
        except OutOfRange:
            # Nothing was sent: nobody has to stop for it.
            raise
        except (DeviceError, LinkError) as error:
            if not may_recover("gripper"):
                raise self._failed(error) from error
            try:
                how = self._bring_back(error)
                result = work()
            except CellError as again:
                raise self._failed(again) from again
        except CellError as error:
            raise self._failed(error) from error
        self._reporter.recovered("gripper", how)
        return result

    def _bring_back(self, error: DeviceError | LinkError) -> str:
        """Bring the gripper back after a fault; return how.

        Nothing moves here but, with nothing between the fingers, for referencing.

        Raises:
            CellError: It does not come back, or what was wrong is nothing that can be mended
                from here.
        """
        if isinstance(error, LinkError):
            raise error
        state = self._answering_state()
        if state is None:
            self._power_up()
            state = self._reopened()
        elif state.has_error:
            self._gripper.acknowledge()
            return f"acknowledged: {error.problem}"
        elif state.is_referenced:
            raise error
        else:
            state = self._reopened()
        if not state.is_referenced:
            raise error
        return f"opened again after: {error.problem}"

    def _answering_state(self) -> GripperState | None:
        try:
            return self._gripper.read_state()
        except DeviceError:
            return None

    def _reopened(self) -> GripperState:
        self._gripper.close()
        self._gripper.open(may_move=not self._may_hold_block())
        return self._gripper.read_state()

    def _failed(self, error: CellError) -> CellError:
        return self._arm.fail("gripper", error)
