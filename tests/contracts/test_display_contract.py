"""What every display does, whatever is behind its link: the emulator, or a capture of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from cell.clock import Clock, SimulatedClock
from cell.devices.display import Display
from cell.drivers.sharp_aquos.driver import SharpDisplay
from cell.drivers.sharp_aquos.settings import SharpSettings
from cell.errors import DeviceError, DeviceTimeout
from cell.links.base import Direction, Link
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.scripted import ScriptedLink
from cell.twin.emulators.sharp_aquos import SharpTelevision, SharpTelevisionSettings
from tests.cell.twin.emulators.sharp_aquos.bodies import BarePanel


class Rig:
    """An emulated set in standby, and every byte that passes."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.panel = BarePanel()
        self.television = SharpTelevision(self.panel, SharpTelevisionSettings())
        self.traffic: list[tuple[Direction, bytes]] = []
        wire = MemoryLink("display", self.television, self.clock)
        self.link = CapturedLink(wire, self._note)

    def _note(self, link: str, direction: Direction, data: bytes) -> None:
        self.traffic.append((direction, data))


@dataclass
class Bench:
    """A display and whoever looks at it; at a capture there is nobody."""

    display: Display
    rig: Rig | None

    def sees(self, *, is_lit: bool, input_number: int | None = None) -> bool:
        if self.rig is None:
            return True
        panel = self.rig.panel
        return panel.is_lit == is_lit and input_number in (None, panel.input_number)

    def cut_the_cable(self) -> None:
        if self.rig is not None:
            self.rig.television.go_silent()


Scenario = Callable[[Bench], None]
Play = Callable[[Scenario], object]


def _driver(link: Link, clock: Clock) -> SharpDisplay:
    return SharpDisplay(link, clock, SharpSettings(), on_warning=lambda text: None)


def _play_in_memory(scenario: Scenario) -> Rig:
    rig = Rig()
    scenario(Bench(_driver(rig.link, rig.clock), rig))
    return rig


def _play_from_capture(scenario: Scenario) -> None:
    clock = SimulatedClock()
    link = ScriptedLink("display", _play_in_memory(scenario).traffic, clock=clock)
    scenario(Bench(_driver(link, clock), None))
    assert link.is_exhausted


def _play_from_capture_on_a_clock_that_stands(scenario: Scenario) -> None:
    link = ScriptedLink("display", _play_in_memory(scenario).traffic)
    scenario(Bench(_driver(link, SimulatedClock()), None))
    assert link.is_exhausted


@pytest.fixture(params=["memory", "capture", "capture, clock standing"])
def play(request: pytest.FixtureRequest) -> Play:
    plays: dict[str, Play] = {
        "memory": _play_in_memory,
        "capture": _play_from_capture,
        "capture, clock standing": _play_from_capture_on_a_clock_that_stands,
    }
    return plays[str(request.param)]


def test_opening_says_who_is_there_and_changes_nothing(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        assert "AQUOS" in bench.display.open()
        assert not bench.display.is_on()
        assert bench.sees(is_lit=False)

    play(scenario)


def test_opening_twice_and_closing_twice_is_harmless(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        assert bench.display.open() == bench.display.open()
        bench.display.close()
        bench.display.close()
        bench.display.open()
        assert not bench.display.is_on()

    play(scenario)


def test_switched_on_it_is_lit_and_takes_commands(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.display.open()
        bench.display.switch_on()
        assert bench.display.is_on()
        bench.display.select_input(2)
        assert bench.sees(is_lit=True, input_number=2)
        bench.display.set_volume(0)

    play(scenario)


def test_switching_on_and_off_may_be_repeated(play: Play) -> None:
    def scenario(bench: Bench) -> None:
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
    def scenario(bench: Bench) -> None:
        bench.display.open()
        bench.display.switch_on()
        bench.display.close()
        assert bench.sees(is_lit=True)

    play(scenario)


def test_an_input_that_there_is_not_is_refused(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.display.open()
        bench.display.switch_on()
        with pytest.raises(DeviceError, match="no input 9"):
            bench.display.select_input(9)
        assert bench.sees(is_lit=True, input_number=1)

    play(scenario)


@pytest.mark.parametrize("volume", [-1, 61])
def test_a_volume_out_of_range_is_refused(play: Play, volume: int) -> None:
    def scenario(bench: Bench) -> None:
        bench.display.open()
        bench.display.switch_on()
        with pytest.raises(DeviceError, match="0 to 60"):
            bench.display.set_volume(volume)

    play(scenario)


def test_what_standby_does_not_do_is_refused(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.display.open()
        with pytest.raises(DeviceError, match="standby"):
            bench.display.select_input(1)

    play(scenario)


def test_a_cut_cable_is_a_time_out(play: Play) -> None:
    def scenario(bench: Bench) -> None:
        bench.display.open()
        bench.cut_the_cable()
        with pytest.raises(DeviceTimeout, match="no answer"):
            bench.display.is_on()
        with pytest.raises(DeviceTimeout, match="no answer"):
            bench.display.switch_on()

    play(scenario)
