"""The IBM 7545's driver on its slave: servo, home, faults in words, and what is left after them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.ibm7545.gripper import RegisterGripper
from cell.drivers.ibm7545.outputs import FLUORESCENT, GRIPPER, HALOGEN
from cell.drivers.ibm7545.registers import MOTOR_POWER_OFF, Fault, Lamp, Register, explain
from cell.errors import DeviceError, DeviceRestarted, DeviceTimeout, Stopped
from cell.geometry import JointPositions
from cell.twin.emulators.ibm7545.slave import Mode
from cell.twin.wire_faults import WireFault
from tests.cell.drivers.ibm7545.bench import (
    KINEMATICS,
    SETTINGS,
    SLAVE_SETTINGS,
    Bench,
    joints,
    opened,
)

SETTLED_PULSES = 2.0
"""How far a joint stands from its target after a move: less than a hundredth of a degree."""


def _is_safe(bench: Bench) -> bool:
    command = bench.slave.read(Register.COMMAND, 1)[0]
    return bench.torques == (0.0,) * 4 and command == 0 and bench.slave.mode is Mode.IDLE


def test_opening_finds_home_and_says_that_the_bridge_is_an_assumption() -> None:
    bench = Bench()
    assert "home found" in bench.arm.open()
    assert bench.slave.mechanics.positions == [0.0] * 4
    assert bench.arm.read_joints() == joints(0, 0, 0, 0)
    assert len(bench.warnings) == 1
    assert "never tried on hardware" in bench.warnings[0]
    assert "bridge" in bench.warnings[0]


def test_home_is_found_once_and_again_only_after_the_slave_was_off() -> None:
    bench = opened()
    bench.arm.move_joints(joints(10, 10, -10, 5))
    bench.arm.open()
    assert bench.arm.read_joints().values == pytest.approx((10, 10, -10, 5), abs=0.01)
    bench.slave.switch(bench.clock.now_s(), is_on=False)
    bench.slave.switch(bench.clock.now_s(), is_on=True)
    assert not bench.arm.read_state().is_servo_on
    with pytest.raises(DeviceRestarted, match="does not know where home is"):
        bench.arm.move_joints(joints(20, 20, 0, 0))
    bench.arm.open()
    assert bench.slave.mechanics.positions == [0.0] * 4


@pytest.mark.parametrize(
    "target",
    [(45, 105, 0, 0), (0.5, 0.2, -1, 1), (200, 135, -250, 180), (96.9, 121.3, -227.7, -30)],
)
def test_the_sources_gains_settle_every_joint(target: tuple[float, ...]) -> None:
    bench = opened()
    bench.arm.move_joints(JointPositions(target))
    scales = (872.2222, 444.4444, -380.96, 227.5556)
    for is_pulses, value, scale in zip(
        bench.slave.mechanics.positions, target, scales, strict=True
    ):
        assert is_pulses == pytest.approx(value * scale, abs=SETTLED_PULSES)
    assert _is_safe(bench)


def test_between_moves_nothing_drifts() -> None:
    bench = opened()
    bench.arm.move_joints(joints(45, 60, -100, 20))
    before = list(bench.slave.mechanics.positions)
    bench.clock.sleep(3600.0)
    bench.arm.read_joints()
    assert bench.slave.mechanics.positions == pytest.approx(before, abs=1.0)


def test_a_line_ends_at_its_pose() -> None:
    bench = opened()
    bench.arm.move_joints(joints(45, 60, -50, 0))
    pose = KINEMATICS.forward(joints(40, 70, -150, 10))
    bench.arm.move(pose, interpolation="linear", posture=0)
    here = bench.arm.read_pose()
    assert (here.x_mm, here.y_mm, here.z_mm) == pytest.approx(
        (pose.x_mm, pose.y_mm, pose.z_mm), abs=0.05
    )


def test_a_blocked_joint_ends_in_the_slaves_torque_error_and_a_safe_stop() -> None:
    stuck = replace(SLAVE_SETTINGS, stop_max=(20000.0, 61500.0, 96500.0, 45000.0))
    bench = opened(slave_settings=stuck)
    with pytest.raises(DeviceError, match="J1 asked for more torque") as caught:
        bench.arm.move_joints(joints(60, 0, 0, 0))
    assert caught.value.code == Fault.TORQUE_1
    assert "holds the joint" in caught.value.hint
    assert _is_safe(bench)
    state = bench.arm.read_state()
    assert state.alarm == Fault.TORQUE_1
    assert not state.is_servo_on
    bench.arm.reset_alarm()
    assert bench.arm.read_state().alarm == 0


def test_torques_that_come_late_are_an_error_in_words_and_a_safe_stop() -> None:
    slow_line = replace(SLAVE_SETTINGS, byte_s=10 / 115200)
    bench = opened(slave_settings=slow_line)
    with pytest.raises(DeviceError, match="later than the sample period") as caught:
        bench.arm.move_joints(joints(10, 0, 0, 0))
    assert caught.value.code == Fault.TORQUES_LATE
    assert "faster bridge" in caught.value.hint
    assert _is_safe(bench)


def test_a_slave_that_waits_takes_a_slower_line() -> None:
    patient = replace(SLAVE_SETTINGS, byte_s=10 / 921600, lateness_s=0.002)
    bench = opened(slave_settings=patient)
    bench.arm.move_joints(joints(5, 5, -5, 5))
    assert bench.arm.read_joints().values == pytest.approx((5, 5, -5, 5), abs=0.05)


def test_a_joint_past_its_limit_is_named_until_it_is_moved_back_by_hand() -> None:
    bench = opened()
    bench.slave.push_joint(1, 60500.0, bench.clock.now_s())
    state = bench.arm.read_state()
    assert state.alarm == Fault.OVERRUN_2_POSITIVE
    assert "J2 stands past its positive limit" in state.alarm_text
    with pytest.raises(DeviceError, match="J2 stands past"):
        bench.arm.move_joints(joints(0, 0, 0, 0))
    with pytest.raises(DeviceError, match="cause remains"):
        bench.arm.reset_alarm()
    bench.slave.push_joint(1, 100.0, bench.clock.now_s())
    bench.arm.reset_alarm()
    bench.arm.open()
    assert bench.arm.read_state().is_servo_on


def test_a_stop_in_the_middle_of_a_move_lets_go_within_a_period() -> None:
    bench = opened()
    taken = 0
    check = bench.token.check

    def stop_after_a_while() -> None:
        nonlocal taken
        taken += 1
        if taken == 300:
            bench.token.stop("somebody pressed stop")
        check()

    bench.token.check = stop_after_a_while  # type: ignore[method-assign]
    with pytest.raises(Stopped, match="pressed stop"):
        bench.arm.move_joints(joints(90, 90, -100, 90))
    assert _is_safe(bench)
    assert 0.0 < bench.arm.read_joints().values[0] < 90.0


def test_motor_power_lost_in_the_middle_of_a_move_is_the_emergency_stop() -> None:
    bench = opened()
    check, taken = bench.token.check, 0

    def press_after_a_while() -> None:
        nonlocal taken
        taken += 1
        if taken == 200:
            bench.bridge.press_emergency_stop(bench.clock.now_s())
        check()

    bench.token.check = press_after_a_while  # type: ignore[method-assign]
    with pytest.raises(DeviceError, match="emergency stop") as caught:
        bench.arm.move_joints(joints(90, 90, -100, 90))
    assert caught.value.code == MOTOR_POWER_OFF
    assert _is_safe(bench)


def test_an_emergency_stop_that_nobody_saw_is_still_reported() -> None:
    bench = opened()
    bench.bridge.press_emergency_stop(bench.clock.now_s())
    bench.bridge.release_emergency_stop(bench.clock.now_s())
    with pytest.raises(DeviceError, match="emergency stop"):
        bench.arm.move_joints(joints(10, 0, 0, 0))


@pytest.mark.parametrize("fault", [WireFault.GARBAGE, WireFault.CORRUPTED, WireFault.LOST])
def test_a_spoiled_reply_is_a_timeout_and_the_next_one_is_understood(fault: WireFault) -> None:
    bench = opened()
    bench.wire.inject(fault)
    with pytest.raises(DeviceTimeout, match="did not answer within 1 s"):
        bench.arm.read_joints()
    assert bench.arm.read_joints() == joints(0, 0, 0, 0)


def test_a_cable_pulled_in_the_middle_of_a_move_leaves_the_arm_without_torque() -> None:
    bench = opened()
    check, taken = bench.token.check, 0

    def pull_after_a_while() -> None:
        nonlocal taken
        taken += 1
        if taken == 200:
            bench.wire.inject(WireFault.UNPLUGGED)
        check()

    bench.token.check = pull_after_a_while  # type: ignore[method-assign]
    with pytest.raises(DeviceTimeout, match="cannot be reached.*cable"):
        bench.arm.move_joints(joints(90, 90, -100, 90))
    bench.slave.advance(bench.clock.now_s() + 0.01)
    assert _is_safe(bench)
    bench.wire.clear()
    assert bench.arm.read_state().alarm == Fault.TORQUES_LATE


def test_gains_that_cannot_hold_a_joint_are_told_as_a_joint_that_does_not_settle() -> None:
    weak = replace(SETTINGS, kp=(0.1, 60.0, 55.0, 60.0), joint_speed_percent=5.0)
    bench = opened(settings=weak)
    with pytest.raises(DeviceTimeout, match="J1 is .* pulses from its target"):
        bench.arm.move_joints(joints(1, 0, 0, 0))
    assert _is_safe(bench)


def test_lamps_are_switched_one_by_one() -> None:
    bench = opened()
    bench.arm.set_output(HALOGEN, is_on=True)
    bench.arm.set_output(FLUORESCENT, is_on=True)
    bench.arm.set_output(HALOGEN, is_on=False)
    assert bench.slave.lamps() == Lamp.FLUORESCENT
    assert bench.arm.read_output(FLUORESCENT)
    with pytest.raises(DeviceError, match="there is no output 5"):
        bench.arm.set_output(5, is_on=True)


def test_the_gripper_closes_and_opens_through_its_register() -> None:
    bench = opened()
    notes: list[str] = []
    gripper = RegisterGripper(bench.arm.outputs, open_mm=30.0, on_warning=notes.append)
    gripper.open()
    assert "no sensor" in notes[0]
    assert gripper.grip(1.0).is_holding
    assert bench.slave.is_closed
    assert bench.arm.read_output(GRIPPER)
    assert gripper.read_state().position_mm == 0.0
    with pytest.raises(DeviceTimeout, match="stand at 0 mm"):
        gripper.wait_for_position(30.0, 1.0)
    gripper.move_to(30.0)
    assert not bench.slave.is_closed
    with pytest.raises(DeviceError, match="31 mm"):
        gripper.move_to(31.0)


def test_a_gripper_that_the_slave_does_not_work_is_a_timeout() -> None:
    bench = opened(slave_settings=replace(SLAVE_SETTINGS, gripper_s=60.0))
    with pytest.raises(DeviceTimeout, match="gripper was not worked within 5 s"):
        bench.arm.set_output(GRIPPER, is_on=True)


def test_home_that_is_not_found_is_a_timeout() -> None:
    slow = replace(SLAVE_SETTINGS, homing_speed=(10.0, 10.0, 10.0, 10.0))
    bench = Bench(slave_settings=slow)
    with pytest.raises(DeviceTimeout, match="home was not found within 180 s"):
        bench.arm.open()
    assert bench.torques == (0.0,) * 4


@pytest.mark.parametrize("bit", list(Fault))
def test_every_error_bit_has_words_and_a_hint(bit: Fault) -> None:
    text, hint = explain(int(bit))
    assert text
    assert hint
    assert explain(int(bit) | MOTOR_POWER_OFF)[0] == f"{explain(MOTOR_POWER_OFF)[0]}; {text}"


def test_a_new_driver_takes_a_known_home_over_and_moves_nothing() -> None:
    bench = opened()
    bench.arm.move_joints(joints(10, 10, -10, 5))
    fresh = Ibm7545Arm(bench.bus, KINEMATICS, bench.clock, SETTINGS, on_warning=lambda text: None)
    assert fresh.knows_position()
    fresh.open()
    assert fresh.read_joints().values == pytest.approx((10, 10, -10, 5), abs=0.01)


def test_a_home_that_was_not_found_is_known_to_no_later_driver() -> None:
    bench = opened()
    bench.slave.switch(bench.clock.now_s(), is_on=False)
    bench.slave.switch(bench.clock.now_s(), is_on=True)
    bench.bus.write(Register.SAMPLE_PERIOD, (SETTINGS.period_us + 1,))
    bench.token.stop("a test")
    with pytest.raises(Stopped):
        bench.arm.open()
    fresh = Ibm7545Arm(bench.bus, KINEMATICS, bench.clock, SETTINGS, on_warning=lambda text: None)
    assert not fresh.knows_position()
    with pytest.raises(DeviceRestarted, match="does not know where home is"):
        fresh.reopen()
