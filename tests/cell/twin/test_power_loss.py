"""What each emulated device forgets when its power goes, and what it keeps."""

from __future__ import annotations

import pytest

from cell.drivers.schunk_smp.tables import Code
from cell.errors import DeviceError, DeviceRestarted, DeviceTimeout
from tests.sessions.fault_rig import FaultRig


@pytest.fixture
def rig() -> FaultRig:
    rig = FaultRig(3)
    rig.cell.open()
    return rig


def test_a_controller_forgets_its_session_and_outputs_and_keeps_its_place(rig: FaultRig) -> None:
    rig.cell.move_to(650.0, -165.0, 150.0)
    before = rig.cell.world.joints_deg(rig.now_s())
    rig.behind.controller.lose_power(rig.now_s(), for_s=1.0)
    assert not rig.cell.world.is_powered()
    rig.timetable.clock.sleep(1.1)
    with pytest.raises(DeviceRestarted, match="no session is open"):
        rig.cell.arm.arm.read_state()
    assert rig.cell.world.joints_deg(rig.now_s()) == before


def test_a_controller_without_power_is_silent(rig: FaultRig) -> None:
    rig.behind.controller.lose_power(rig.now_s(), for_s=60.0)
    with pytest.raises(DeviceTimeout):
        rig.cell.arm.arm.read_state()


def test_a_gripper_forgets_its_zero_and_keeps_its_opening(rig: FaultRig) -> None:
    opening_mm = rig.cell.gripper.read_state().position_mm
    rig.behind.module.lose_power(rig.now_s(), for_s=0.2)
    rig.timetable.clock.sleep(1.0)
    state = rig.cell.gripper.read_state()
    assert not state.is_referenced
    assert state.position_mm == opening_mm


def test_a_television_cannot_be_woken_over_the_line_until_somebody_presses_its_key(
    rig: FaultRig,
) -> None:
    rig.behind.television.unplug(rig.now_s())
    with pytest.raises(DeviceTimeout):
        rig.cell.display.switch_on()
    rig.behind.television.press_power(rig.now_s())
    rig.cell.display.switch_on()
    assert rig.cell.display.is_on()


def test_jammed_fingers_are_blocked_both_ways(rig: FaultRig) -> None:
    rig.cell.world.jam_fingers(are_jammed=True)
    with pytest.raises(DeviceError, match="blocked at"):
        rig.cell.gripper.move_to(20.0)


def test_a_block_slips_only_from_fingers_that_hold_one(rig: FaultRig) -> None:
    assert not rig.cell.world.slip(rig.now_s())
    rig.cell.grip_at(rig.cell.manipulator.slot_place(7))
    assert rig.cell.world.slip(rig.now_s())
    rig.behind.module.raise_error(Code.SOFT_LIMIT_LOW)
    assert rig.cell.gripper.gripper.read_state().position_mm == 0.0
