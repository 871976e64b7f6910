"""What every gripper does, in every way in which a driver can have it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cell.clock import Clock, SimulatedClock
from cell.devices.gripper import Gripper
from cell.drivers.schunk_smp.driver import SchunkGripper
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.schunk_smp.tables import Code
from cell.errors import DeviceError, DeviceTimeout
from cell.links.base import Link
from cell.profile import load_profile
from cell.twin.emulators.schunk_smp import SchunkModule, SchunkModuleSettings
from tests.cell.twin.emulators.schunk_smp.bodies import BareFingers
from tests.contracts.harness import WAYS, Bench, Kind, player


class Rig:
    """An emulated module, freshly switched on, and what is between its fingers."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.body = BareFingers()
        self.emulator = SchunkModule(self.body, SchunkModuleSettings())


class GripperBench:
    """A gripper and whoever stands beside it; at a capture there is nobody."""

    def __init__(self, gripper: Gripper, rig: Rig | None) -> None:
        self.gripper = gripper
        self._rig = rig

    def put_between_the_fingers(self, width_mm: float | None) -> None:
        if self._rig is not None:
            self._rig.body.width_mm = width_mm

    def switch_power(self, *, is_on: bool) -> None:
        if self._rig is not None:
            self._rig.body.has_power = is_on

    def break_it(self, *, is_lasting: bool) -> None:
        if self._rig is not None:
            self._rig.emulator.raise_error(Code.TOW, is_lasting=is_lasting)


def _driver(link: Link, clock: Clock) -> Gripper:
    return SchunkGripper(link, clock, SchunkSettings(), on_warning=lambda text: None)


KIND: Kind[Rig, Gripper] = Kind("gripper", load_profile("mash").gripper.serial, Rig, _driver)

Scenario = Callable[[GripperBench], None]
Play = Callable[[Scenario], None]


@pytest.fixture(params=WAYS)
def play(request: pytest.FixtureRequest, tmp_path: Path) -> Play:
    play_on = player(KIND, str(request.param), tmp_path)

    def play(scenario: Scenario) -> None:
        def on_bench(bench: Bench[Rig, Gripper]) -> None:
            scenario(GripperBench(bench.device, bench.rig))

        play_on(on_bench)

    return play


def test_an_opened_gripper_says_who_it_is_and_is_ready(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        assert "PG070" in bench.gripper.open()
        state = bench.gripper.read_state()
        assert state.is_referenced
        assert not state.is_moving
        assert not state.has_error
        assert (state.error, state.error_text) == (0, "")

    play(scenario)


def test_opening_twice_and_closing_twice_is_harmless(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        assert bench.gripper.open() == bench.gripper.open()
        bench.gripper.close()
        bench.gripper.close()

    play(scenario)


def test_a_closed_gripper_can_be_opened_again_and_moves(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.gripper.close()
        bench.gripper.open()
        bench.gripper.move_to(50.0)
        assert bench.gripper.read_state().position_mm == 50.0

    play(scenario)


def test_a_move_returns_when_the_fingers_stand_at_the_opening(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        for opening_mm in (60.0, 50.0, 60.0, 60.0, 0.0, 70.0):
            bench.gripper.move_to(opening_mm)
            state = bench.gripper.read_state()
            assert state.position_mm == opening_mm
            assert not state.is_moving

    play(scenario)


@pytest.mark.parametrize("opening_mm", [-1.0, 71.0])
def test_an_opening_out_of_reach_is_refused(play: Play, opening_mm: float) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        with pytest.raises(DeviceError, match="out of reach"):
            bench.gripper.move_to(opening_mm)

    play(scenario)


@pytest.mark.parametrize("width_mm", [33.0, 10.0, 55.5])
def test_closing_on_something_holds_and_measures_it(play: Play, width_mm: float) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.gripper.move_to(60.0)
        bench.put_between_the_fingers(width_mm)
        result = bench.gripper.grip(1.0)
        assert result.is_holding
        assert result.width_mm == width_mm
        assert bench.gripper.read_state().position_mm == width_mm
        bench.gripper.move_to(60.0)

    play(scenario)


def test_closing_on_nothing_is_told_and_the_gripper_goes_on(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        result = bench.gripper.grip(1.0)
        assert not result.is_holding
        assert not bench.gripper.read_state().has_error
        bench.gripper.move_to(60.0)

    play(scenario)


@pytest.mark.parametrize("current_a", [0.0, -1.0, 100.0])
def test_an_impossible_force_is_refused(play: Play, current_a: float) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        with pytest.raises(DeviceError, match="out of range"):
            bench.gripper.grip(current_a)

    play(scenario)


def test_a_move_into_something_fails_and_the_gripper_goes_on(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.put_between_the_fingers(33.0)
        with pytest.raises(DeviceError, match="33.0 mm"):
            bench.gripper.move_to(20.0)
        bench.put_between_the_fingers(None)
        bench.gripper.move_to(20.0)

    play(scenario)


def test_stopping_what_stands_is_harmless(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.gripper.stop()
        assert not bench.gripper.wait_for_stop(1.0).is_moving

    play(scenario)


def test_waiting_for_a_position_returns_there_or_times_out(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.gripper.move_to(60.0)
        bench.gripper.wait_for_position(60.0, timeout_s=1.0)

    play(scenario)


def test_an_error_is_reported_acknowledged_and_gone(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.break_it(is_lasting=False)
        bench.gripper.read_state()
        state = bench.gripper.read_state()
        assert state.has_error
        assert state.error == Code.TOW
        assert state.error_text
        with pytest.raises(DeviceError):
            bench.gripper.move_to(60.0)
        bench.gripper.acknowledge()
        bench.gripper.move_to(60.0)

    play(scenario)


def test_an_error_whose_cause_stays_is_raised_by_acknowledging(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.break_it(is_lasting=True)
        with pytest.raises(DeviceError) as caught:
            bench.gripper.acknowledge()
        assert caught.value.code == Code.TOW

    play(scenario)


def test_a_gripper_without_power_is_a_time_out_and_comes_back(play: Play) -> None:
    def scenario(bench: GripperBench) -> None:
        bench.gripper.open()
        bench.switch_power(is_on=False)
        with pytest.raises(DeviceTimeout, match="power"):
            bench.gripper.read_state()
        with pytest.raises(DeviceTimeout, match="power"):
            bench.gripper.move_to(60.0)
        bench.gripper.close()
        bench.switch_power(is_on=True)
        bench.gripper.open()
        bench.gripper.move_to(60.0)

    play(scenario)
