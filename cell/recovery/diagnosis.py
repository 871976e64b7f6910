"""From an error, and what the arm's controller says of itself, to the fault behind it."""

from __future__ import annotations

from cell.devices.arm import ArmSignals, ArmState
from cell.errors import (
    CellError,
    DeviceError,
    DeviceRestarted,
    DeviceTimeout,
    LedgerError,
    LinkError,
    MotionInterrupted,
    Stopped,
)
from cell.recovery.faults import Fault

_BY_ERROR: tuple[tuple[type[CellError], Fault], ...] = (
    (LedgerError, Fault.DISK),
    (Stopped, Fault.STOPPED),
    (LinkError, Fault.UNPLUGGED),
    (DeviceRestarted, Fault.POWER_LOSS),
    (MotionInterrupted, Fault.STOP_BUTTON),
    (DeviceTimeout, Fault.SILENCE),
)


def fault_of(error: CellError) -> Fault:
    """Return what an error of any device stands for."""
    return next((fault for kind, fault in _BY_ERROR if isinstance(error, kind)), Fault.REFUSAL)


def fault_of_arm(error: CellError, arm: ArmSignals) -> Fault:
    """Return what stopped the arm: its controller knows better than the error.

    A stop button leaves no trace but the motion's early end, so the state goes first.
    """
    fault = fault_of(error)
    if fault in (Fault.UNPLUGGED, Fault.POWER_LOSS, Fault.STOPPED, Fault.DISK):
        return fault
    try:
        return _fault_of_state(arm.read_state()) or fault
    except DeviceRestarted:
        return Fault.POWER_LOSS
    except (DeviceError, LinkError):
        return fault


def _fault_of_state(state: ArmState) -> Fault | None:
    """Return what is wrong with an arm, the gravest first, or None if it could move."""
    if state.is_emergency_stopped:
        return Fault.EMERGENCY_STOP
    if not state.is_automatic:
        return Fault.TEACH
    if state.alarm:
        return Fault.ALARM
    if not state.has_right:
        return Fault.RIGHT_TAKEN
    return None
