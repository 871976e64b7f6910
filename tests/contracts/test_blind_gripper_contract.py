"""What fingers on a servo do, in every way to have them, and what they say they cannot.

The contract of a gripper that measures is test_gripper_contract.py; of its promises, these
fingers keep those that a commanded opening can keep.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cell.clock import Clock, SimulatedClock
from cell.devices.gripper import Gripper
from cell.drivers.ssc32.gripper import Ssc32Gripper
from cell.errors import DeviceError, DeviceTimeout
from cell.links.base import Link
from cell.twin.emulators.ssc32 import LynxMechanics, ServoBank, Ssc32Controller
from tests.cell.drivers.ssc32.bench import CONTROLLER_SETTINGS, FINGERS, KINEMATICS, PROFILE
from tests.contracts.harness import WAYS, Bench, Kind, Player, player


class Rig:
    """A controller, freshly powered, and what is between the fingers."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        bank = ServoBank.from_profile(PROFILE, seed=1)
        self.emulator = Ssc32Controller(bank, CONTROLLER_SETTINGS)
        self.mechanics = LynxMechanics(PROFILE, bank, KINEMATICS)


FingerBench = Bench[Rig, Gripper]
_HEARD: list[str] = []


def _driver(link: Link, clock: Clock) -> Gripper:
    _HEARD.clear()
    return Ssc32Gripper(link, clock, FINGERS, on_warning=_HEARD.append)


@pytest.fixture(params=WAYS)
def play(request: pytest.FixtureRequest, tmp_path: Path) -> Player[Rig, Gripper]:
    kind: Kind[Rig, Gripper] = Kind("gripper", PROFILE.serial, Rig, _driver)
    return player(kind, str(request.param), tmp_path)


def test_opening_says_who_it_is_and_what_nobody_measures(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        assert not bench.device.read_state().is_referenced
        assert "servo channel 4" in bench.device.open()
        text = "\n".join(_HEARD)
        assert "never tried on hardware" in text
        assert "a grip always counts as holding" in text
        assert "the fingers jump to 30 mm" in text
        state = bench.device.read_state()
        assert state.is_referenced
        assert not state.is_moving
        assert not state.has_error
        assert (state.error, state.error_text, state.current_a) == (0, "", 0.0)

    play(scenario)


def test_opening_twice_and_closing_twice_is_harmless(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        assert bench.device.open() == bench.device.open()
        bench.device.close()
        bench.device.close()
        bench.device.open()
        bench.device.move_to(12.0)

    play(scenario)


def test_fingers_that_may_not_move_at_opening_stay_limp_until_they_are_referenced(
    play: Player[Rig, Gripper],
) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open(may_move=False)
        assert not bench.device.read_state().is_referenced
        with pytest.raises(DeviceError, match="reference it"):
            bench.device.move_to(10.0)
        bench.device.reference()
        assert bench.device.read_state().is_referenced
        bench.device.move_to(10.0)
        bench.device.reference()
        assert bench.device.read_state().position_mm == pytest.approx(10.0, abs=0.05)

    play(scenario)


def test_a_move_returns_when_the_opening_is_commanded(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        for opening_mm in (30.0, 10.0, 0.0, -15.0, -15.0, 30.0):
            bench.device.move_to(opening_mm)
            state = bench.device.read_state()
            assert state.position_mm == pytest.approx(opening_mm, abs=0.05)
            assert not state.is_moving
            bench.device.wait_for_position(opening_mm, 0.1)

    play(scenario)


@pytest.mark.parametrize("opening_mm", [-15.1, 30.1, float("nan"), float("inf")])
def test_an_opening_out_of_reach_is_refused(play: Player[Rig, Gripper], opening_mm: float) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        with pytest.raises(DeviceError, match="out of reach.*-15.0 to 30.0 mm"):
            bench.device.move_to(opening_mm)

    play(scenario)


@pytest.mark.parametrize("width_mm", [None, 20.0])
def test_a_grip_tells_the_commanded_opening_whatever_is_held(
    play: Player[Rig, Gripper], width_mm: float | None
) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        if bench.rig is not None:
            bench.rig.mechanics.held_mm = width_mm
        result = bench.device.grip(0.5)
        assert result.is_holding
        assert result.width_mm == FINGERS.grip_mm
        if bench.rig is not None:
            # The twin knows better: it holds, or it has closed on nothing.
            opening_mm = bench.rig.mechanics.opening_mm(bench.rig.clock.now_s())
            assert opening_mm == (0.0 if width_mm is None else width_mm)
            assert (bench.rig.mechanics.squeeze_mm(bench.rig.clock.now_s()) > 15.0) == (
                width_mm is not None
            )

    play(scenario)


@pytest.mark.parametrize("current_a", [0.0, -1.0, float("nan")])
def test_an_impossible_force_is_refused(play: Player[Rig, Gripper], current_a: float) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        with pytest.raises(DeviceError, match="current"):
            bench.device.grip(current_a)

    play(scenario)


def test_stopping_what_stands_is_harmless(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.stop()
        bench.device.open()
        bench.device.stop()
        bench.device.acknowledge()
        assert bench.device.wait_for_stop(0.1).is_referenced

    play(scenario)


def test_waiting_for_a_position_nobody_commands_times_out(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        with pytest.raises(DeviceTimeout, match="instead of 5.0 mm"):
            bench.device.wait_for_position(5.0, 0.5)

    play(scenario)


def test_a_restarted_controller_is_noticed_and_needs_opening_again(
    play: Player[Rig, Gripper],
) -> None:
    def scenario(bench: FingerBench) -> None:
        bench.device.open()
        if bench.rig is not None:
            bench.rig.emulator.cut_power(bench.rig.clock.now_s())
            bench.rig.emulator.restore_power(bench.rig.clock.now_s())
            bench.rig.clock.sleep(1.0)
        with pytest.raises(
            DeviceError, match="since its power-up.*open the gripper again or reference it"
        ):
            bench.device.move_to(10.0)
        assert not bench.device.read_state().is_referenced
        bench.device.open()
        bench.device.move_to(10.0)

    play(scenario)


def test_a_dead_controller_is_a_time_out_everywhere(play: Player[Rig, Gripper]) -> None:
    def scenario(bench: FingerBench) -> None:
        gripper = bench.device
        gripper.open()
        if bench.rig is not None:
            bench.rig.emulator.fall_silent(is_silent=True)
        for verb in (
            gripper.read_state,
            gripper.stop,
            gripper.acknowledge,
            lambda: gripper.move_to(10.0),
            lambda: gripper.grip(0.5),
            lambda: gripper.wait_for_stop(1.0),
            lambda: gripper.wait_for_position(10.0, 1.0),
            gripper.open,
        ):
            with pytest.raises(DeviceTimeout, match="gripper: .*cable"):
                verb()
        gripper.close()

    play(scenario)
