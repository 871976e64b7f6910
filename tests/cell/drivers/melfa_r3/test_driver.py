from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import pytest

from cell.drivers.melfa_r3.driver import MelfaArm
from cell.errors import DeviceError, DeviceTimeout, LinkError
from cell.geometry import JointPositions, Pose
from tests.contracts.arm.rig import (
    ABOVE,
    ARM_SETTINGS,
    CONTROLLER_SETTINGS,
    KINEMATICS,
    PROFILE,
    ArmRig,
    opened_rig,
)

NEXT = Pose(490.0, -65.0, 98.0)
TILTED = KINEMATICS.forward(JointPositions((-5.0, 20.0, 90.0, 60.0, 50.0, 10.0)))
"""A pose that the arm reaches with J5 up and with J5 down."""


class HookedClock:
    """Lets something happen at a moment of the simulated time."""

    def __init__(self, rig: ArmRig) -> None:
        self._rig = rig
        self._clock = rig.clock
        self._sleep = rig.clock.sleep

    def press_emergency_stop_after(self, delay_s: float) -> None:
        due_s = self._clock.now_s() + delay_s
        self._interrupt(due_s, self._rig.controller.press_emergency_stop)

    def press_stop_after(self, delay_s: float) -> None:
        due_s = self._clock.now_s() + delay_s
        self._interrupt(due_s, self._rig.controller.press_stop_button)

    def _interrupt(self, due_s: float, act: Callable[[float], None]) -> None:
        sleep, clock = self._sleep, self._clock
        done: list[bool] = []

        def hooked(duration_s: float) -> None:
            now_s = clock.now_s()
            if not done and now_s + duration_s >= due_s:
                done.append(True)
                sleep(due_s - now_s)
                act(due_s)
                sleep(now_s + duration_s - due_s)
            else:
                sleep(duration_s)

        self._rig.clock.sleep = hooked  # type: ignore[method-assign]


def test_opening_follows_the_order_of_the_field() -> None:
    rig = ArmRig()
    rig.arm.open()
    words = [request for request in rig.requests if request != "DSTATE"]
    assert words == [
        "OPEN=ROBOCELL", "STATE", "ERROR", "CNTLON", "RSTPRG", "PRGLOAD=1", "OVRD=100", "SRVON",
        "EXECSPD 250", "EXECJOVRD 30",
    ]  # fmt: skip
    assert 1.0 <= rig.clock.now_s() <= 1.4


def test_closing_stops_and_gives_everything_back() -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.arm.close()
    assert rig.requests == ["STOP", "SRVOFF", "CNTLOFF", "CLOSE"]


def test_a_driver_never_tried_on_hardware_says_so_when_it_opens(
    caplog: pytest.LogCaptureFixture,
) -> None:
    rig = ArmRig()
    with caplog.at_level(logging.WARNING):
        MelfaArm(rig.link, rig.clock, ARM_SETTINGS).open()
    assert "never tried on hardware" in caplog.text


def test_a_driver_tried_on_hardware_keeps_quiet() -> None:
    rig = ArmRig(arm_settings=replace(ARM_SETTINGS, was_tried_on_hardware=True))
    rig.arm.open()
    assert rig.warnings == []


def test_opening_clears_an_alarm_whose_cause_is_gone() -> None:
    rig = ArmRig()
    rig.controller.raise_alarm(2600, 0.0)
    rig.arm.open()
    assert "RSTALRM" in rig.requests
    assert rig.arm.read_state().alarm == 0


def test_opening_with_the_emergency_stop_pressed_fails_and_lets_go() -> None:
    rig = ArmRig()
    rig.controller.press_emergency_stop(0.0)
    with pytest.raises(DeviceError, match="release the emergency stop") as caught:
        rig.arm.open()
    assert caught.value.code == 60
    assert rig.requests[-4:] == ["STOP", "SRVOFF", "CNTLOFF", "CLOSE"]


def test_opening_waits_for_the_right_as_the_field_does() -> None:
    rig = ArmRig()
    rig.controller.hold_right_by_panel(0.0, is_held=True)
    with pytest.raises(DeviceError, match="somebody else holds"):
        rig.arm.open()
    assert rig.requests.count("CNTLON") == 5
    rig.controller.hold_right_by_panel(rig.clock.now_s(), is_held=False)
    rig.arm.open()


def test_opening_without_its_empty_program_says_what_to_create() -> None:
    rig = ArmRig(controller_settings=replace(CONTROLLER_SETTINGS, programs={"WORK": ()}))
    with pytest.raises(DeviceError, match="no such program.*create the program"):
        rig.arm.open()


def test_servos_that_never_come_are_a_timeout() -> None:
    rig = ArmRig(controller_settings=replace(CONTROLLER_SETTINGS, servo_on_s=60.0))
    with pytest.raises(DeviceTimeout, match="servos did not come on within 10 s"):
        rig.arm.open()
    assert rig.clock.now_s() < 15.0


def test_an_alarm_while_the_servos_come_on_is_told() -> None:
    rig = ArmRig()
    HookedClock(rig).press_emergency_stop_after(0.7)
    with pytest.raises(DeviceError, match="kept the servos off"):
        rig.arm.open()


def test_one_question_is_enough_when_the_expected_time_is_right() -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="linear", posture=7, expected_s=0.08)
    assert rig.requests == [
        "EXECP1=(490.000,-65.000,98.000,180.000,0.000,180.000)(7,0)",
        "EXECMVS P1",
        "PPOSF",
    ]


def test_the_first_question_comes_when_the_ramps_are_over_too() -> None:
    rig = opened_rig()
    before_s = rig.clock.now_s()
    rig.arm.move(NEXT, interpolation="linear", posture=7, expected_s=5.0)
    assert rig.clock.now_s() - before_s == pytest.approx(5.0 + ARM_SETTINGS.ramp_s, abs=0.1)


def test_without_an_expected_time_the_driver_asks_every_50_ms() -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="linear", posture=7)
    assert 3 <= rig.requests.count("DSTATE") <= 5


def test_joint_interpolation_is_asked_for_by_its_own_word() -> None:
    rig = opened_rig()
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="joint", posture=7)
    assert "EXECMOV P1" in rig.requests


def test_an_emergency_stop_during_a_move_stops_the_arm_and_names_itself() -> None:
    rig = opened_rig()
    HookedClock(rig).press_emergency_stop_after(0.3)
    target = Pose(510.0, 200.0, 98.0)
    with pytest.raises(DeviceError, match="emergency stop is pressed.*release") as caught:
        rig.arm.move(target, interpolation="linear", posture=7)
    assert caught.value.code == 60
    assert rig.requests[-1] == "STOP"
    assert -65.0 < rig.tool_pose().y_mm < 200.0
    assert not rig.body.is_moving(rig.clock.now_s())


def test_a_move_that_an_operator_stopped_is_no_arrival() -> None:
    rig = opened_rig()
    HookedClock(rig).press_stop_after(0.3)
    with pytest.raises(DeviceError, match="without an alarm; see whether somebody pressed a stop"):
        rig.arm.move(Pose(510.0, 200.0, 98.0), interpolation="linear", posture=7, expected_s=1.2)


def test_a_joint_move_that_an_operator_stopped_is_no_arrival() -> None:
    rig = opened_rig()
    HookedClock(rig).press_stop_after(0.3)
    with pytest.raises(DeviceError, match="ended with J1 at"):
        rig.arm.move_joints(JointPositions(PROFILE.rest_deg), expected_s=2.0)


def test_a_move_that_does_not_end_is_stopped_and_a_timeout() -> None:
    rig = opened_rig(replace(ARM_SETTINGS, move_timeout_s=1.0, override_percent=1))
    with pytest.raises(DeviceTimeout, match="did not end within 1.5 s and was stopped"):
        rig.arm.move(Pose(510.0, 200.0, 98.0), interpolation="linear", posture=7, expected_s=0.5)
    assert rig.requests[-1] == "STOP"
    rig.clock.sleep(1.0)
    assert not rig.body.is_moving(rig.clock.now_s())


def test_a_controller_still_busy_is_asked_again() -> None:
    rig = opened_rig()
    rig.say("EXECJ1=(10,0,90,0,90,0)")
    assert rig.say("EXECMOV J1") == "QoK"
    rig.traffic.clear()
    rig.arm.move(NEXT, interpolation="linear", posture=7)
    refusals = [data for direction, data in rig.traffic if data == b"QeR5640\r"]
    assert refusals
    assert rig.arm.read_pose() == NEXT


def test_a_controller_busy_for_too_long_is_a_timeout() -> None:
    rig = opened_rig(replace(ARM_SETTINGS, override_percent=1))
    rig.say("EXECJ1=(80,0,90,0,90,0)")
    rig.say("EXECMOV J1")
    with pytest.raises(DeviceTimeout, match="earlier move still under way") as caught:
        rig.arm.move(NEXT, interpolation="linear", posture=7)
    assert caught.value.code == 5640


def test_a_refusal_in_alarm_names_the_alarm_behind_it() -> None:
    rig = opened_rig()
    rig.controller.raise_alarm(1310, rig.clock.now_s())
    with pytest.raises(DeviceError, match="while alarm 1310 is active: a servo amplifier"):
        rig.arm.set_output(8, is_on=True)


def test_an_error_that_no_table_knows_is_asked_of_the_controller() -> None:
    rig = opened_rig()
    rig.controller.replace_next_reply(b"QeR9111\r")
    with pytest.raises(DeviceError, match="unknown error") as caught:
        rig.arm.set_output(8, is_on=True)
    assert caught.value.code == 9111
    assert "ERRORMES9111" in rig.requests


def test_a_straight_move_cannot_change_the_posture() -> None:
    rig = opened_rig()
    with pytest.raises(DeviceError, match="posture") as caught:
        rig.arm.move(TILTED, interpolation="linear", posture=6)
    assert caught.value.code == 2810


@pytest.mark.parametrize("posture", [7, 6])
def test_a_joint_move_takes_the_posture_it_is_given(posture: int) -> None:
    rig = opened_rig()
    rig.arm.move(TILTED, interpolation="joint", posture=posture)
    assert rig.arm.panel.axes("PPOSF").flags == (posture, 0)


def test_turning_the_key_to_teach_takes_the_servos_and_the_right_away() -> None:
    rig = opened_rig()
    rig.controller.set_key_switch(rig.clock.now_s(), is_automatic=False)
    state = rig.arm.read_state()
    assert not state.is_automatic
    assert not state.is_servo_on
    with pytest.raises(DeviceError, match="right is not held"):
        rig.arm.move(NEXT, interpolation="linear", posture=7)


def test_the_safe_position_is_the_controllers_own() -> None:
    rig = opened_rig()
    rig.arm.move_to_safe_position(expected_s=1.0)
    assert rig.arm.read_joints() == JointPositions(PROFILE.rest_deg)


def test_a_broken_link_while_opening_is_told_as_it_is() -> None:
    rig = ArmRig()
    rig.link.close()
    with pytest.raises(LinkError):
        rig.arm.open()


def test_closing_tries_every_step_and_tells_the_first_failure() -> None:
    rig = opened_rig(replace(ARM_SETTINGS, attempts=1))
    rig.traffic.clear()
    rig.controller.replace_next_reply(b"?\r")
    with pytest.raises(DeviceError, match="which is no reply"):
        rig.arm.close()
    assert rig.requests == ["STOP", "SRVOFF", "CNTLOFF", "CLOSE"]


def test_the_same_run_gives_the_same_bytes_twice() -> None:
    def run() -> list[object]:
        rig = opened_rig()
        for x_mm in (490.0, 470.0, 450.0):
            rig.arm.move(Pose(x_mm, -65.0, 98.0), interpolation="linear", posture=7)
        rig.arm.move(ABOVE, interpolation="joint", posture=7)
        rig.arm.close()
        return [*rig.traffic, rig.clock.now_s()]

    assert run() == run()
