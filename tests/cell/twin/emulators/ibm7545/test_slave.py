"""The slave's program by its registers alone, and the joints behind it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cell.drivers.ibm7545.pulses import positions_of
from cell.drivers.ibm7545.registers import (
    Command,
    Fault,
    GripperBit,
    Register,
    TimingA,
    TimingB,
)
from cell.twin.emulators.ibm7545 import Slave, SlaveSettings
from cell.twin.emulators.ibm7545.mechanics import Mechanics
from cell.twin.emulators.ibm7545.slave import Mode

SETTINGS = SlaveSettings(start=(0, 0, 0, 0))
MIDDLE = (0x800,) * 4


def running(settings: SlaveSettings = SETTINGS) -> Slave:
    """Return a slave whose servo loop runs at 1 ms and waits for the first torques."""
    slave = Slave(settings)
    slave.write(Register.SAMPLE_PERIOD, (1000,))
    slave.write(Register.COMMAND, (int(Command.SERVO),))
    slave.advance(0.0002)
    return slave


def get(slave: Slave, register: Register) -> int:
    return slave.read(register, 1)[0]


def give(slave: Slave, words: tuple[int, ...]) -> None:
    slave.write(Register.TORQUES, words)
    slave.write(Register.TIMING_B, (int(TimingB.TORQUES),))


def test_a_period_goes_hand_in_hand() -> None:
    slave = Slave(SETTINGS)
    slave.write(Register.SAMPLE_PERIOD, (1000,))
    slave.write(Register.COMMAND, (int(Command.SERVO),))
    assert get(slave, Register.TIMING_A) == TimingA.STARTED
    slave.advance(0.0002)
    assert get(slave, Register.TIMING_A) == 0x000F
    give(slave, MIDDLE)
    assert get(slave, Register.TIMING_B) == 0
    slave.write(Register.TIMING_A, (0,))
    slave.advance(0.00099)
    assert get(slave, Register.TIMING_A) == 0
    slave.advance(0.00101)
    assert get(slave, Register.TIMING_A) == TimingA.STARTED
    assert get(slave, Register.ERROR) == 0


def test_torques_given_before_the_slave_asks_are_taken_when_it_does() -> None:
    slave = Slave(SETTINGS)
    slave.write(Register.SAMPLE_PERIOD, (1000,))
    slave.write(Register.COMMAND, (int(Command.SERVO),))
    give(slave, MIDDLE)
    assert get(slave, Register.TIMING_B) == 1
    slave.advance(0.0002)
    assert get(slave, Register.TIMING_B) == 0


def test_a_master_that_gives_no_torques_is_too_late() -> None:
    slave = running()
    slave.advance(0.0011)
    assert get(slave, Register.ERROR) == Fault.TORQUES_LATE
    assert (get(slave, Register.COMMAND), slave.mode) == (0, Mode.IDLE)


def test_a_master_that_does_not_end_the_period_is_too_slow() -> None:
    slave = running()
    give(slave, MIDDLE)
    slave.advance(0.0011)
    assert get(slave, Register.ERROR) == Fault.LOOP_TOO_SLOW


@pytest.mark.parametrize("joint", range(4))
def test_a_torque_beyond_twelve_bits_is_refused_and_none_is_put_out(joint: int) -> None:
    slave = running()
    words = [0xFFF] * 4
    words[joint] = 0x1000
    give(slave, tuple(words))
    assert get(slave, Register.ERROR) == Fault.TORQUE_1 << joint
    slave.advance(0.1)
    assert slave.mechanics.positions == [0.0] * 4


def test_a_cleared_command_ends_the_loop_without_an_error() -> None:
    slave = running()
    slave.write(Register.COMMAND, (0,))
    assert (get(slave, Register.ERROR), slave.mode) == (0, Mode.IDLE)


def test_errors_keep_the_slave_from_commands_until_they_are_cleared() -> None:
    slave = running()
    slave.advance(0.0011)
    slave.write(Register.COMMAND, (int(Command.SERVO),))
    assert slave.mode is Mode.IDLE
    slave.write(Register.ERROR, (0,))
    assert slave.mode is not Mode.IDLE


@pytest.mark.parametrize("joint", range(4))
@pytest.mark.parametrize("side", [0, 1])
def test_each_overrun_sets_its_bit_and_clears_it_when_the_joint_is_back(
    joint: int, side: int
) -> None:
    slave = Slave(SETTINGS)
    limit = SETTINGS.overrun_min[joint] - 1 if side else SETTINGS.overrun_max[joint] + 1
    slave.push_joint(joint, limit, 0.1)
    assert get(slave, Register.ERROR) == 1 << (2 * joint + side)
    slave.push_joint(joint, 0.0, 0.2)
    assert get(slave, Register.ERROR) == 0


def test_power_cut_on_the_way_home_leaves_the_joints_where_they_are() -> None:
    slave = Slave(SlaveSettings(start=(60000, 30000, 19000, 4000)))
    slave.write(Register.COMMAND, (int(Command.FIND_HOME),))
    slave.advance(0.5)
    assert slave.mechanics.positions == pytest.approx([60000, 30000, 9500, 4000])
    slave.cut_motor_power(0.5, is_on=False)
    slave.advance(60.0)
    assert slave.mechanics.positions == pytest.approx([60000, 30000, 9500, 4000])
    assert slave.mode is Mode.IDLE


def test_counters_start_at_zero_wherever_the_arm_stands_and_homing_sets_them_right() -> None:
    slave = Slave(SlaveSettings(start=(60000, 30000, 20000, 4000)))
    assert positions_of(slave.read(Register.POSITIONS, 8)) == (0, 0, 0, 0)
    slave.write(Register.COMMAND, (int(Command.FIND_HOME),))
    slave.advance(5.0)
    assert get(slave, Register.COMMAND) == Command.FIND_HOME
    slave.advance(60.0)
    assert get(slave, Register.COMMAND) == 0
    assert slave.mechanics.positions == [0.0] * 4
    slave.push_joint(0, 500.0, 61.0)
    assert positions_of(slave.read(Register.POSITIONS, 8)) == (500, 0, 0, 0)


@pytest.mark.parametrize(("bit", "is_closed"), [(GripperBit.CLOSE, True), (GripperBit.OPEN, False)])
def test_the_gripper_register_is_cleared_when_its_work_is_done(
    bit: GripperBit, is_closed: bool
) -> None:
    slave = Slave(SETTINGS)
    slave.write(Register.GRIPPER, (int(bit),))
    slave.advance(0.4)
    assert get(slave, Register.GRIPPER) == bit
    slave.advance(0.6)
    assert get(slave, Register.GRIPPER) == 0
    assert slave.is_closed is is_closed


def test_a_torque_brings_a_joint_to_its_final_speed() -> None:
    mechanics = Mechanics(SETTINGS)
    mechanics.apply((0x800 + 525, 0x800, 0x800, 0x800), 0.0)
    mechanics.advance(1.0)
    assert mechanics.speeds[0] == pytest.approx(2160 * 500 / 50)
    assert mechanics.speeds[1:] == [0.0] * 3


def test_how_time_is_cut_changes_nothing() -> None:
    coarse, fine = Mechanics(SETTINGS), Mechanics(SETTINGS)
    now_s = 0.0
    for word in (0xC00, 0x500, 0x810, 0x800):
        words = (word,) * 4
        coarse.apply(words, now_s)
        fine.apply(words, now_s)
        for step in range(1, 51):
            fine.advance(now_s + 0.05 * step / 50)
        now_s += 0.05
        coarse.advance(now_s)
        assert fine.positions == pytest.approx(coarse.positions, abs=1e-6)
        assert fine.speeds == pytest.approx(coarse.speeds, abs=1e-6)


def test_a_torque_within_the_friction_moves_nothing_and_a_moving_joint_comes_to_rest() -> None:
    mechanics = Mechanics(SETTINGS)
    mechanics.apply((0x800 + 20,) * 4, 0.0)
    mechanics.advance(1.0)
    assert mechanics.positions == [0.0] * 4
    mechanics.apply((0xA00,) * 4, 1.0)
    mechanics.advance(1.1)
    mechanics.relax(1.1)
    mechanics.advance(2.0)
    assert not mechanics.is_moving


def test_end_stops_hold() -> None:
    mechanics = Mechanics(replace(SETTINGS, stop_max=(100.0, 100.0, 100.0, 100.0)))
    mechanics.apply((0xFFF,) * 4, 0.0)
    mechanics.advance(5.0)
    assert mechanics.positions == [100.0] * 4
