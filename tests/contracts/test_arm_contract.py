"""What every arm does, whatever is behind its link: the emulator, or a capture of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from cell.clock import SimulatedClock
from cell.devices.arm import Arm
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.errors import DeviceError, DeviceTimeout
from cell.geometry import JointPositions, Pose
from cell.links.scripted import ScriptedLink
from tests.contracts.arm.rig import ABOVE, ARM_SETTINGS, PROFILE, ArmRig


@dataclass
class Bench:
    """An arm and whoever stands beside it; at a capture there is nobody."""

    arm: Arm
    rig: ArmRig | None

    def press_emergency_stop(self) -> None:
        if self.rig is not None:
            self.rig.controller.press_emergency_stop(self.rig.clock.now_s())

    def release_emergency_stop(self) -> None:
        if self.rig is not None:
            self.rig.controller.release_emergency_stop(self.rig.clock.now_s())

    def cut_the_cable(self) -> None:
        if self.rig is not None:
            self.rig.controller.fall_silent(is_silent=True)

    def turn_the_key_to_teach(self) -> None:
        if self.rig is not None:
            self.rig.controller.set_key_switch(self.rig.clock.now_s(), is_automatic=False)


Scenario = Callable[[Bench], None]
Play = Callable[[Scenario], object]


def _play_in_memory(scenario: Scenario) -> ArmRig:
    rig = ArmRig()
    scenario(Bench(rig.arm, rig))
    return rig


def _play_from_capture(scenario: Scenario) -> None:
    link = ScriptedLink("arm", _play_in_memory(scenario).traffic)
    arm = MelfaArm(link, SimulatedClock(), ARM_SETTINGS, on_warning=lambda text: None)
    scenario(Bench(arm, None))
    assert link.is_exhausted


@pytest.fixture(params=["memory", "capture"])
def play(request: pytest.FixtureRequest) -> Play:
    if request.param == "capture":
        return _play_from_capture
    return _play_in_memory


def _to_playground(arm: Arm) -> None:
    arm.open()
    arm.move(ABOVE, interpolation="joint", posture=7, expected_s=1.5)


def test_an_opened_arm_says_who_it_is_and_is_ready(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        assert "RV-6SDL" in bench.arm.open()
        state = bench.arm.read_state()
        assert state.is_servo_on
        assert state.is_automatic
        assert not state.is_moving
        assert not state.is_emergency_stopped
        assert (state.alarm, state.alarm_text) == (0, "")
        assert state.override_percent == 100

    play(scenario)


def test_opening_twice_and_closing_twice_is_harmless(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        assert bench.arm.open() == bench.arm.open()
        bench.arm.close()
        bench.arm.close()

    play(scenario)


def test_a_closed_arm_can_be_opened_again_and_moves(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        bench.arm.close()
        _to_playground(bench.arm)
        assert bench.arm.read_pose() == ABOVE

    play(scenario)


def test_a_move_returns_when_the_arm_stands_at_its_target(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        target = Pose(490.0, -65.0, 98.0)
        bench.arm.move(target, interpolation="linear", posture=7)
        assert bench.arm.read_pose() == target
        assert not bench.arm.read_state().is_moving

    play(scenario)


def test_the_expected_time_changes_nothing_but_the_questions(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        for expected_s, x_mm in ((0.0, 490.0), (0.1, 470.0), (5.0, 450.0)):
            target = Pose(x_mm, -65.0, 98.0)
            bench.arm.move(target, interpolation="linear", posture=7, expected_s=expected_s)
            assert bench.arm.read_pose() == target

    play(scenario)


def test_a_joint_move_ends_at_its_angles(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        target = JointPositions((80.0, -20.0, 110.0, 10.0, 80.0, -5.0))
        bench.arm.move_joints(target, expected_s=0.5)
        assert bench.arm.read_joints() == target

    play(scenario)


def test_a_slower_speed_is_taken(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        bench.arm.set_speed(20.0, 5.0)
        bench.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7, expected_s=1.0)
        assert bench.arm.read_pose().x_mm == 490.0

    play(scenario)


@pytest.mark.parametrize(("speed", "percent"), [(0.0, 10.0), (-5.0, 10.0), (100.0, 0.0), (1, 101)])
def test_an_impossible_speed_is_refused(play: Play, speed: float, percent: float) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        with pytest.raises(DeviceError, match="speed"):
            bench.arm.set_speed(speed, percent)

    play(scenario)


def test_an_output_reads_as_it_was_switched(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        assert not bench.arm.read_output(8)
        bench.arm.set_output(8, is_on=True)
        assert bench.arm.read_output(8)
        assert not bench.arm.read_output(9)
        bench.arm.set_output(8, is_on=False)
        assert not bench.arm.read_output(8)

    play(scenario)


def test_a_pose_out_of_reach_is_refused_and_the_arm_stays(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        with pytest.raises(DeviceError, match="out of range") as caught:
            bench.arm.move(Pose(1500.0, 0.0, 98.0), interpolation="linear", posture=7)
        assert caught.value.code == 2602
        assert bench.arm.read_pose() == ABOVE
        bench.arm.reset_alarm()
        assert bench.arm.read_state().alarm == 0
        bench.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)

    play(scenario)


def test_joints_beyond_a_limit_are_refused(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        with pytest.raises(DeviceError) as caught:
            bench.arm.move_joints(JointPositions((171.0, 0.0, 90.0, 0.0, 90.0, 0.0)))
        assert caught.value.code == 2602
        assert bench.arm.read_joints() == JointPositions(PROFILE.rest_deg)

    play(scenario)


def test_a_pose_that_is_no_number_is_refused_before_anything_is_sent(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.open()
        with pytest.raises(DeviceError, match="no position"):
            bench.arm.move(Pose(float("nan"), 0.0, 98.0), interpolation="joint", posture=7)

    play(scenario)


def test_an_emergency_stop_holds_the_arm_until_it_is_released_reset_and_opened_again(
    play: Play,
) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        bench.press_emergency_stop()
        state = bench.arm.read_state()
        assert state.is_emergency_stopped
        assert not state.is_servo_on
        assert state.alarm == 60
        assert "emergency stop" in state.alarm_text
        with pytest.raises(DeviceError, match="emergency stop"):
            bench.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)
        with pytest.raises(DeviceError, match="cause remains"):
            bench.arm.reset_alarm()
        bench.release_emergency_stop()
        bench.arm.reset_alarm()
        assert bench.arm.read_state().alarm == 0
        assert not bench.arm.read_state().is_servo_on
        with pytest.raises(DeviceError, match="open the arm again"):
            bench.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)
        bench.arm.open()
        bench.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)
        assert bench.arm.read_pose().x_mm == 490.0

    play(scenario)


def test_stop_works_in_every_state(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.arm.stop()
        _to_playground(bench.arm)
        bench.arm.stop()
        bench.press_emergency_stop()
        bench.arm.stop()

    play(scenario)


def test_an_arm_in_teach_mode_says_how_to_open_it(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.turn_the_key_to_teach()
        with pytest.raises(DeviceError, match="AUTO"):
            bench.arm.open()

    play(scenario)


def test_a_dead_arm_is_a_timeout_everywhere(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        _to_playground(bench.arm)
        bench.cut_the_cable()
        for verb in (
            bench.arm.read_pose,
            bench.arm.read_joints,
            bench.arm.read_state,
            bench.arm.stop,
            bench.arm.reset_alarm,
            lambda: bench.arm.move(ABOVE, interpolation="linear", posture=7),
            lambda: bench.arm.move_joints(JointPositions(PROFILE.rest_deg)),
            lambda: bench.arm.set_output(8, is_on=True),
            lambda: bench.arm.read_output(8),
            lambda: bench.arm.set_speed(100.0, 10.0),
            bench.arm.open,
            bench.arm.close,
        ):
            with pytest.raises(DeviceTimeout, match="arm: .*cable"):
                verb()

    play(scenario)
