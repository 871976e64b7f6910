"""What every display does, in every way in which a driver can have it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cell.clock import Clock, SimulatedClock
from cell.devices.display import Display
from cell.drivers.sharp_aquos.driver import SharpDisplay
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.errors import DeviceError, DeviceTimeout
from cell.links.base import Link
from cell.profile import load_profile
from cell.twin.emulators.sharp_aquos import SharpTelevision, SharpTelevisionSettings
from tests.cell.twin.emulators.sharp_aquos.bodies import BarePanel
from tests.contracts.harness import WAYS, Bench, Kind, player


class Rig:
    """An emulated set in standby, and its panel."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.panel = BarePanel()
        self.emulator = SharpTelevision(self.panel, SharpTelevisionSettings())


class DisplayBench:
    """A display and whoever looks at it; at a capture there is nobody."""

    def __init__(self, display: Display, rig: Rig | None) -> None:
        self.display = display
        self._rig = rig

    def sees(self, *, is_lit: bool, input_number: int | None = None) -> bool:
        if self._rig is None:
            return True
        panel = self._rig.panel
        return panel.is_lit == is_lit and input_number in (None, panel.input_number)

    def cut_the_cable(self) -> None:
        if self._rig is not None:
            self._rig.emulator.go_silent()


def _driver(link: Link, clock: Clock) -> Display:
    return SharpDisplay(link, clock, SharpSettings(), on_warning=lambda text: None)


KIND: Kind[Rig, Display] = Kind("display", load_profile("mash").display.serial, Rig, _driver)

Scenario = Callable[[DisplayBench], None]
Play = Callable[[Scenario], None]


@pytest.fixture(params=WAYS)
def play(request: pytest.FixtureRequest, tmp_path: Path) -> Play:
    play_on = player(KIND, str(request.param), tmp_path)

    def play(scenario: Scenario) -> None:
        def on_bench(bench: Bench[Rig, Display]) -> None:
            scenario(DisplayBench(bench.device, bench.rig))

        play_on(on_bench)

    return play


def test_opening_says_who_is_there_and_changes_nothing(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        assert "AQUOS" in bench.display.open()
        assert not bench.display.is_on()
        assert bench.sees(is_lit=False)

    play(scenario)


def test_opening_twice_and_closing_twice_is_harmless(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        assert bench.display.open() == bench.display.open()
        bench.display.close()
        bench.display.close()
        bench.display.open()
        assert not bench.display.is_on()

    play(scenario)


def test_switched_on_it_is_lit_and_takes_commands(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        bench.display.switch_on()
        assert bench.display.is_on()
        bench.display.select_input(2)
        assert bench.sees(is_lit=True, input_number=2)
        bench.display.set_volume(0)

    play(scenario)


def test_switching_on_and_off_may_be_repeated(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        for _ in range(2):
            bench.display.switch_on()
            bench.display.switch_on()
            assert bench.sees(is_lit=True)
            bench.display.switch_off()
            bench.display.switch_off()
            assert bench.sees(is_lit=False)

    play(scenario)


def test_closing_leaves_the_set_on(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        bench.display.switch_on()
        bench.display.close()
        assert bench.sees(is_lit=True)

    play(scenario)


def test_an_input_that_there_is_not_is_refused(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        bench.display.switch_on()
        with pytest.raises(DeviceError, match="no input 9"):
            bench.display.select_input(9)
        assert bench.sees(is_lit=True, input_number=1)

    play(scenario)


@pytest.mark.parametrize("volume", [-1, 61])
def test_a_volume_out_of_range_is_refused(play: Play, volume: int) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        bench.display.switch_on()
        with pytest.raises(DeviceError, match="0 to 60"):
            bench.display.set_volume(volume)

    play(scenario)


def test_what_standby_does_not_do_is_refused(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        with pytest.raises(DeviceError, match="standby"):
            bench.display.select_input(1)

    play(scenario)


def test_a_cut_cable_is_a_time_out(play: Play) -> None:
    def scenario(bench: DisplayBench) -> None:
        bench.display.open()
        bench.cut_the_cable()
        with pytest.raises(DeviceTimeout, match="no answer"):
            bench.display.is_on()
        with pytest.raises(DeviceTimeout, match="no answer"):
            bench.display.switch_on()

    play(scenario)
