"""The pneumatic gripper on the slave's gripper register: open or closed, nothing between.

It has no sensor. Its state is what it was told last, and a grip reports that the fingers
closed; whether something is between them only a camera can tell.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from cell.devices.gripper import GripperState, GripResult
from cell.drivers.ibm7545.outputs import NOT_WORKED, Outputs
from cell.errors import DeviceTimeout, OutOfRange

_log = logging.getLogger(__name__)


def _log_warning(text: str) -> None:
    _log.warning("%s", text)


class RegisterGripper:
    """The gripper of the arm's slave; shares the arm's registers and its thread.

    Args:
        outputs: The outputs of the arm that carries it.
        open_mm: Opening between the fingers when open.
        device: Its name in messages.
        on_warning: Told what a technician should know although nothing failed.
    """

    def __init__(
        self,
        outputs: Outputs,
        *,
        open_mm: float,
        device: str = "gripper",
        on_warning: Callable[[str], None] = _log_warning,
    ) -> None:
        self._outputs = outputs
        self._open_mm = open_mm
        self._device = device
        self._on_warning = on_warning

    def open(self, *, may_move: bool = True) -> str:
        """Return the identity; nothing moves, with or without leave."""
        self._on_warning(f"{self._device}: it has no sensor; a grip is not checked")
        return "pneumatic gripper on the IBM 7545's slave"

    def close(self) -> None:
        """Leave the fingers as they are."""

    def reference(self) -> None:
        """Do nothing: it knows two positions and needs no zero."""

    def move_to(self, opening_mm: float) -> None:
        """Open or close, whichever is nearer to the opening asked for.

        Raises:
            DeviceError: The opening is wider than the fingers go.
            DeviceTimeout: The slave does not work the valve.
        """
        if not 0.0 <= opening_mm <= self._open_mm:
            raise OutOfRange(
                self._device,
                f"an opening of {opening_mm:g} mm was asked for",
                hint=f"it opens 0 to {self._open_mm:g} mm",
            )
        self._outputs.work_gripper(is_closing=opening_mm < self._open_mm / 2.0)

    def grip(self, current_a: float) -> GripResult:
        """Close; the air's pressure sets the force, not `current_a`."""
        self._outputs.work_gripper(is_closing=True)
        return GripResult(is_holding=True, width_mm=0.0)

    def stop(self) -> None:
        """Do nothing: air cannot be stopped half way."""

    def wait_for_position(self, opening_mm: float, timeout_s: float) -> None:
        """Return at once if the fingers stand there: a move ends before it returns.

        Raises:
            DeviceTimeout: They stand at the other end, and nothing moves them.
        """
        here_mm = self.read_state().position_mm
        if abs(here_mm - opening_mm) > self._open_mm / 2.0:
            raise DeviceTimeout(
                self._device,
                f"the fingers stand at {here_mm:g} mm instead of {opening_mm:g} mm",
                hint="move them there first",
            )

    def wait_for_stop(self, timeout_s: float) -> GripperState:
        """Return the state: the fingers always stand still between two requests."""
        return self.read_state()

    def read_state(self) -> GripperState:
        """Return what the fingers were told last.

        Until they were told anything they count as not referenced; their opening is told as
        the open one, and is not known.
        """
        is_closed = self._outputs.is_closed
        return GripperState(
            position_mm=0.0 if is_closed else self._open_mm,
            velocity_mm_s=0.0,
            current_a=0.0,
            is_referenced=is_closed is not None,
            is_moving=False,
            has_error=False,
            error=0,
            error_text=NOT_WORKED if is_closed is None else "",
        )

    def acknowledge(self) -> None:
        """Do nothing: the gripper latches no errors."""
