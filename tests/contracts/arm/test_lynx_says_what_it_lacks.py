"""Where the Lynx cannot do what the arm contract asks, it says so, in every way to have it."""

from __future__ import annotations

from pathlib import Path

import pytest

from cell.clock import Clock
from cell.devices.arm import Arm
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.errors import DeviceError
from cell.links.base import Link
from tests.cell.drivers.ssc32.bench import KINEMATICS, PROFILE, SETTINGS
from tests.contracts.arm.lynx import LYNX, SteppedLynx
from tests.contracts.harness import WAYS, Bench, Kind, Player, player

LynxBench = Bench[SteppedLynx, Arm]


@pytest.fixture(params=WAYS)
def play(request: pytest.FixtureRequest, tmp_path: Path) -> Player[SteppedLynx, Arm]:
    return player(LYNX.kind, str(request.param), tmp_path)


@pytest.mark.parametrize("way", WAYS)
def test_opening_warns_that_there_is_no_emergency_stop_and_that_the_first_move_jumps(
    way: str, tmp_path: Path
) -> None:
    heard: list[str] = []

    def driver(link: Link, clock: Clock) -> Arm:
        return Ssc32Arm(link, clock, SETTINGS, KINEMATICS, on_warning=heard.append)

    def scenario(bench: LynxBench) -> None:
        heard.clear()
        bench.device.open()
        text = "\n".join(heard)
        assert "never tried on hardware" in text
        assert "no emergency stop and no alarms" in text
        assert "measures nothing" in text
        assert "in 5 s the joints jump" in text

    player(Kind("arm", PROFILE.serial, SteppedLynx, driver), way, tmp_path)(scenario)


def test_a_state_without_pulses_says_that_the_controller_was_restarted(
    play: Player[SteppedLynx, Arm],
) -> None:
    def scenario(bench: LynxBench) -> None:
        state = bench.device.read_state()
        assert not state.is_servo_on
        assert not state.is_emergency_stopped
        assert state.alarm == 0
        assert "no pulses to J1, J2, J3, J4, J5" in state.alarm_text
        assert "its first move jumps" in state.alarm_text

    play(scenario)


def test_losing_power_is_noticed_before_anything_is_sent_and_needs_opening_again(
    play: Player[SteppedLynx, Arm],
) -> None:
    def scenario(bench: LynxBench) -> None:
        arm = bench.device
        arm.open()
        if bench.rig is not None:
            now_s = bench.rig.clock.now_s()
            bench.rig.emulator.cut_power(now_s)
            bench.rig.emulator.restore_power(now_s)
            bench.rig.clock.sleep(1.0)
        assert not arm.read_state().is_servo_on
        with pytest.raises(DeviceError, match="since its power-up.*open it again"):
            arm.move_joints(LYNX.above.joints)
        with pytest.raises(DeviceError, match="since its power-up"):
            arm.read_pose()
        arm.open()
        arm.move_joints(LYNX.above.joints)

    play(scenario)


def test_an_output_is_unknown_until_it_was_switched(play: Player[SteppedLynx, Arm]) -> None:
    def scenario(bench: LynxBench) -> None:
        arm = bench.device
        arm.open()
        with pytest.raises(DeviceError, match="does not tell its outputs"):
            arm.read_output(8)
        arm.set_output(8, is_on=True)
        assert arm.read_output(8)
        arm.set_output(8, is_on=False)
        assert not arm.read_output(8)
        with pytest.raises(DeviceError, match="does not tell its outputs"):
            arm.read_output(9)

    play(scenario)


@pytest.mark.parametrize("channel", [0, 1, 2, 3, 4, 5])
def test_a_servo_is_no_output(play: Player[SteppedLynx, Arm], channel: int) -> None:
    def scenario(bench: LynxBench) -> None:
        bench.device.open()
        with pytest.raises(DeviceError, match="drives a servo"):
            bench.device.set_output(channel, is_on=True)

    play(scenario)


def test_closing_leaves_the_arm_held(play: Player[SteppedLynx, Arm]) -> None:
    def scenario(bench: LynxBench) -> None:
        bench.device.open()
        bench.device.close()
        assert bench.device.read_state().is_servo_on

    play(scenario)


def test_a_closed_arm_refuses_to_move(play: Player[SteppedLynx, Arm]) -> None:
    def scenario(bench: LynxBench) -> None:
        bench.device.open()
        bench.device.close()
        with pytest.raises(DeviceError, match="open the arm first"):
            bench.device.move_joints(LYNX.above.joints)

    play(scenario)
