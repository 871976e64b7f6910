from __future__ import annotations

import pytest

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
from cell.recovery.diagnosis import fault_of
from cell.recovery.faults import Deed, Fault
from cell.recovery.policy import POLICY, deed_for, may_recover


@pytest.mark.parametrize(
    ("error", "fault"),
    [
        (DeviceTimeout("arm", "silent"), Fault.SILENCE),
        (DeviceError("arm", "refused"), Fault.REFUSAL),
        (DeviceRestarted("arm", "was off"), Fault.POWER_LOSS),
        (MotionInterrupted("arm", "ended early"), Fault.STOP_BUTTON),
        (LinkError("out"), Fault.UNPLUGGED),
        (LedgerError("full"), Fault.DISK),
        (Stopped("asked"), Fault.STOPPED),
    ],
)
def test_an_error_tells_its_fault(error: CellError, fault: Fault) -> None:
    assert fault_of(error) is fault


@pytest.mark.parametrize(
    "fault",
    [Fault.EMERGENCY_STOP, Fault.STOP_BUTTON, Fault.TEACH, Fault.RIGHT_TAKEN, Fault.POWER_LOSS],
)
def test_what_a_person_does_at_the_arm_ends_the_task(fault: Fault) -> None:
    assert deed_for("arm", fault) is Deed.STOP


def test_whatever_is_in_no_row_holds_the_arm() -> None:
    assert deed_for("screen", Fault.REFUSAL) is Deed.HOLD
    assert deed_for("gripper", Fault.SILENCE) is Deed.HOLD


def test_a_device_is_brought_back_where_a_row_says_so() -> None:
    assert may_recover("gripper")
    assert may_recover("display")
    assert not may_recover("arm")


def test_no_row_is_there_twice() -> None:
    keys = [(rule.device, rule.fault, rule.when) for rule in POLICY]
    assert len(keys) == len(set(keys))


def test_rows_that_fail_have_a_reply_and_rows_that_do_not_have_none() -> None:
    for rule in POLICY:
        assert (rule.reply != "-") == (rule.deed in (Deed.HOLD, Deed.STOP)), rule
