from __future__ import annotations

from dataclasses import replace

import pytest

from cell.drivers.melfa_r3.statements import (
    AssignPosition,
    Combined,
    Move,
    Position,
    SetFigure,
)
from cell.errors import DeviceError
from cell.geometry import Pose
from tests.contracts.arm.rig import (
    ABOVE,
    CONTROLLER_SETTINGS,
    PROFILE,
    ArmRig,
    opened_rig,
)


def test_the_override_is_taken_and_read_back() -> None:
    panel = opened_rig().arm.panel
    panel.set_override(25)
    assert panel.override() == 25


@pytest.mark.parametrize("percent", [0, 101, -1])
def test_an_impossible_override_is_refused_before_anything_is_sent(percent: int) -> None:
    rig = opened_rig()
    rig.traffic.clear()
    with pytest.raises(DeviceError, match="use 1 to 100"):
        rig.arm.panel.set_override(percent)
    assert rig.requests == []


def test_an_override_that_the_controller_changed_is_an_error() -> None:
    rig = opened_rig()
    rig.controller.replace_next_reply(b"QoK10\r")
    with pytest.raises(DeviceError, match="took an override of 10 % for 50 %"):
        rig.arm.panel.set_override(50)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("M_SVO", "+1"),
        ("M_JOVRD", "+30"),
        ("M_JOVRD;M", "+30"),
        ("M_ERR", "+0"),
        ("M_TOOL", "+1"),
        ("P_CURR", "(510.000,-65.000,98.000,180.000,0.000,180.000)(7,0)"),
        ("P_TOOL;P", "(0.000,0.000,159.200,0.000,0.000,0.000)(0,0)"),
    ],
)
def test_a_system_variable_is_read_in_the_controllers_notation(name: str, value: str) -> None:
    assert opened_rig().arm.panel.variable(name) == value


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("P3", "(+174.64,1,2,180,0,180)(7,0)", "(174.640,1.000,2.000,180.000,0.000,180.000)(7,0)"),
        ("J3", "(1,2,3,4,5,6)", "(1.0000,2.0000,3.0000,4.0000,5.0000,6.0000)"),
        ("M9", "-2.5", "-2.5"),
    ],
)
def test_a_variable_reads_as_it_was_written(name: str, value: str, read: str) -> None:
    panel = opened_rig().arm.panel
    panel.set_variable(name, value)
    assert panel.variable(name) == read


def test_an_unknown_variable_is_refused() -> None:
    with pytest.raises(DeviceError, match="no such variable"):
        opened_rig().arm.panel.variable("P99")


def test_parameters_are_those_of_the_cell() -> None:
    panel = opened_rig().arm.panel
    limits = [float(value) for value in panel.parameter("MEJAR")]
    assert tuple(limits[0::2]) == PROFILE.joint_min_deg
    assert tuple(limits[1::2]) == PROFILE.joint_max_deg
    assert [float(v) for v in panel.parameter("MEXTL")] == [0.0, 0.0, 159.2, 0.0, 0.0, 0.0]
    assert float(panel.parameter("MEPAR")[4]) == PROFILE.flange_min_z_mm
    assert tuple(float(v) for v in panel.parameter("JSAFE")) == PROFILE.rest_deg
    with pytest.raises(DeviceError, match="no such parameter"):
        panel.parameter("NOPE")


def test_a_hand_opens_and_closes() -> None:
    panel = opened_rig().arm.panel
    panel.move_hand(2, is_open=True)
    assert [hand.status for hand in panel.hands()][:3] == [2, 1, 2]
    panel.move_hand(2, is_open=False)
    assert [hand.status for hand in panel.hands()][:3] == [2, 2, 2]


def test_signals_travel_both_ways() -> None:
    rig = opened_rig()
    panel = rig.arm.panel
    panel.set_outputs(0, 0x8301)
    assert panel.outputs(0) == 0x8301
    assert panel.outputs(8) == 0x83
    assert [bit for bit, is_on in rig.body.outputs.items() if is_on] == [0, 8, 9, 15]
    rig.controller.set_input(3, is_on=True)
    panel.set_pseudo_inputs(16, 1)
    assert panel.inputs(0) == 0b1000
    assert panel.signals(1, 0) == (0x8004, 0x8301)


def test_programs_are_listed_loaded_and_run() -> None:
    programs = {"1": (), "DANCE": ("SPD 100", "J1=(80,-30,120,0,90,0)", "MOV J1", "M_OUT(4)=1")}
    rig = ArmRig(controller_settings=replace(CONTROLLER_SETTINGS, programs=programs))
    rig.arm.open()
    panel = rig.arm.panel
    assert panel.programs() == ("1", "DANCE")
    panel.run_program("DANCE")
    assert rig.arm.read_state().is_moving
    with pytest.raises(DeviceError, match="still under way"):
        panel.load_program("1")
    rig.clock.sleep(3.0)
    assert not rig.arm.read_state().is_moving
    assert rig.arm.read_joints().values[0] == 80.0
    assert rig.arm.read_output(4)
    panel.reset_program()
    panel.reset_slots()


def test_a_program_that_repeats_runs_until_it_is_stopped() -> None:
    rig = opened_rig()
    rig.arm.panel.run_program("1", is_cyclic=False)
    rig.clock.sleep(60.0)
    assert rig.arm.read_state().is_moving
    rig.arm.stop()
    assert not rig.arm.read_state().is_moving


def test_a_program_that_cannot_go_on_raises_an_alarm() -> None:
    programs = {"1": (), "BAD": ("MOV P77",)}
    rig = ArmRig(controller_settings=replace(CONTROLLER_SETTINGS, programs=programs))
    rig.arm.open()
    rig.arm.panel.run_program("BAD")
    state = rig.arm.read_state()
    assert state.alarm == 4330
    assert not state.is_moving


def test_an_alarm_is_named_and_remembered() -> None:
    rig = opened_rig()
    panel = rig.arm.panel
    assert panel.alarm() == 0
    assert panel.last_alarm() == ("",)
    rig.controller.raise_alarm(2600, rig.clock.now_s())
    assert panel.alarm() == 2600
    assert "out of range" in panel.alarm_text(2600)
    panel.reset_alarm()
    assert panel.alarm() == 0
    number, _, text = panel.last_alarm()
    assert (number, text) == ("2600", panel.alarm_text(2600))


def test_the_emergency_stop_shows_in_the_stop_sources() -> None:
    rig = opened_rig()
    assert rig.arm.panel.stop_sources() == (0, 0)
    rig.controller.press_emergency_stop(rig.clock.now_s())
    assert rig.arm.panel.stop_sources() == (0, 0b10)


def test_single_axes_are_read_by_name() -> None:
    panel = opened_rig().arm.panel
    assert panel.axes("PPOS", "X")[:2] == (("X",), (510.0,))
    assert panel.axes("JPOS", "5").names == ("J5",)
    with pytest.raises(DeviceError, match="out of range"):
        panel.axes("PPOS", "W")


def test_a_move_relative_to_the_tool_goes_along_the_tool() -> None:
    rig = opened_rig()
    panel = rig.arm.panel
    panel.execute(AssignPosition("PT", Position(Pose(0.0, 0.0, 10.0, 0.0, 0.0, 0.0), None)))
    panel.execute(Move(True, Combined("P_CURR", "*", "PT")))
    rig.clock.sleep(2.0)
    assert rig.arm.read_pose() == ABOVE.at_height(88.0)


def test_a_shift_in_the_robot_frame_adds_up() -> None:
    rig = opened_rig()
    panel = rig.arm.panel
    panel.execute(AssignPosition("PD", Position(Pose(0.0, 5.0, 10.0, 0.0, 0.0, 0.0), None)))
    panel.execute(Move(True, Combined("P_CURR", "+", "PD")))
    rig.clock.sleep(2.0)
    assert rig.arm.read_pose() == Pose(510.0, -60.0, 108.0)


def test_another_tool_moves_the_reported_pose_and_the_targets() -> None:
    tools = {1: PROFILE.tool_mm, 2: (0.0, 0.0, 109.2)}
    rig = ArmRig(controller_settings=replace(CONTROLLER_SETTINGS, tools=tools))
    rig.arm.open()
    rig.arm.move(ABOVE, interpolation="joint", posture=7)
    rig.arm.panel.select_tool(2)
    assert rig.arm.read_pose() == ABOVE.at_height(148.0)
    rig.arm.move(ABOVE.at_height(128.0), interpolation="linear", posture=7)
    assert rig.tool_pose().z_mm == pytest.approx(78.0, abs=1e-6)
    with pytest.raises(DeviceError, match="out of range"):
        rig.arm.panel.select_tool(7)


@pytest.mark.parametrize(
    "statement", [SetFigure("SPD", (99999.0,)), SetFigure("ACCEL", (0.0, 50.0))]
)
def test_figures_out_of_range_are_refused(statement: SetFigure) -> None:
    with pytest.raises(DeviceError, match="out of range"):
        opened_rig().arm.panel.execute(statement)
