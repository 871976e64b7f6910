"""Plays one scenario on a device in every way in which a driver can have it.

Ways
    memory          driver and emulator joined in memory
    pty             the emulator behind a pseudo-terminal that pyserial opens; asserts
                    that the port object has every parameter of the profile, and that the
                    kernel has its speed and stop bits (a pseudo-terminal shows no others);
                    a device on the network is behind a TCP port of loopback instead
    capture         recorded in memory, then replayed to a fresh driver
    standing clock  the same, on a clock that stands still while the replay says nothing
    pty capture     recorded over the pseudo-terminal, then replayed to a fresh driver

How to put a device under a contract
    1. Write a rig: an object with `clock` (a fresh SimulatedClock) and `emulator`, and
       whatever a hand beside the device needs (buttons, something between the fingers).
    2. Describe it: `Kind(name=..., line=<SerialProfile>, rig=Rig, driver=make)`, where
       `make(link, clock)` returns the driver.
    3. An arm becomes an `ArmCase` (tests/contracts/arm/case.py) in a module of its own in
       tests/contracts/arm/, with a line in tests/contracts/arm/arms.py; every test of
       test_arm_contract.py then runs on it, all ways. For another device write a test module
       with a fixture `@pytest.fixture(params=WAYS)` that returns
       `player(KIND, request.param, tmp_path)`.
    4. A scenario is a function of a `Bench`: `bench.device` is the driver, `bench.rig` is
       the rig, or None at a capture, where nobody stands beside the device. What a hand does
       must therefore be asked for through `bench.rig is not None`, and what the driver does
       must be the same either way.
"""

from __future__ import annotations

import termios
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import serial

from cell.clock import Clock, SimulatedClock
from cell.links.base import Direction, Emulator, Link
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.reconnecting import ReconnectingLink
from cell.links.scripted import ScriptedLink
from cell.links.serial import SerialLink
from cell.links.tcp import TcpLink
from cell.profile import SerialProfile, TcpProfile
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator
from tests.contracts.tcp_port import SteppedTcpPort

WAYS = ("memory", "pty", "capture", "standing clock", "pty capture")

_PARITIES = {"none": serial.PARITY_NONE, "even": serial.PARITY_EVEN, "odd": serial.PARITY_ODD}
_CFLAG, _OSPEED = 2, 5

Traffic = list[tuple[Direction, bytes]]


class Rig(Protocol):
    """A device's side: its emulator and the clock it runs on."""

    @property
    def clock(self) -> SimulatedClock:
        """The clock of driver and emulator."""

    @property
    def emulator(self) -> Emulator:
        """The device behind the wire."""


R = TypeVar("R", bound=Rig)
D = TypeVar("D")


@dataclass(frozen=True)
class Kind(Generic[R, D]):
    """A kind of device: how its emulator and its driver are made."""

    name: str
    line: SerialProfile
    rig: Callable[[], R]
    driver: Callable[[Link, Clock], D]
    is_on_network: bool = False


@dataclass
class Bench(Generic[R, D]):
    """A driver and whoever stands beside its device; at a capture there is nobody."""

    device: D
    rig: R | None


Scenario = Callable[[Bench[R, D]], None]
Player = Callable[[Scenario[R, D]], None]


def player(kind: Kind[R, D], way: str, folder: Path) -> Player[R, D]:
    """Return what plays scenarios on a kind of device in a way; `folder` holds its ports."""

    def play(scenario: Scenario[R, D]) -> None:
        recorded = (record_over_pty if way.startswith("pty") else record_in_memory)(
            kind, scenario, folder
        )
        if way not in ("memory", "pty"):
            _replay(kind, scenario, recorded, is_standing=way == "standing clock")

    return play


def record_in_memory(kind: Kind[R, D], scenario: Scenario[R, D], folder: Path) -> Traffic:
    """Play a scenario in memory and return every byte that passed."""
    rig = kind.rig()
    return _record(kind, scenario, rig, MemoryLink(kind.name, rig.emulator, rig.clock))


def record_over_pty(kind: Kind[R, D], scenario: Scenario[R, D], folder: Path) -> Traffic:
    """Play a scenario over a pseudo-terminal and return every byte that passed."""
    rig = kind.rig()
    if kind.is_on_network:
        return _record_over_tcp(kind, scenario, rig)
    path = folder / kind.name
    line = kind.line.model_copy(update={"port": str(path), "usb_serial": ""})
    wire = SteppedWire(FaultyEmulator(rig.emulator), PtyPort(path, line), rig.clock)
    opened: list[SerialLink] = []

    def open_port() -> Link:
        opened.append(SerialLink(kind.name, line))
        assert_line_is_as_in(line, opened[-1])
        return opened[-1]

    link = ReconnectingLink(kind.name, lambda: wire.open(open_port), rig.clock)
    try:
        traffic = _record(kind, scenario, rig, link)
        assert link.reopened == 0
        assert opened or not traffic
        return traffic
    finally:
        link.close()
        wire.close()


def _record_over_tcp(kind: Kind[R, D], scenario: Scenario[R, D], rig: R) -> Traffic:
    port = SteppedTcpPort()
    wire = SteppedWire(FaultyEmulator(rig.emulator), port, rig.clock)
    address = TcpProfile(host="127.0.0.1", port=port.number)
    link = ReconnectingLink(
        kind.name, lambda: wire.open(lambda: TcpLink(kind.name, address)), rig.clock
    )
    try:
        traffic = _record(kind, scenario, rig, link)
        assert link.reopened == 0
        assert link.is_connected or not traffic
        return traffic
    finally:
        link.close()
        wire.close()


def assert_line_is_as_in(line: SerialProfile, link: SerialLink) -> None:
    """Assert that pyserial and, as far as it can, the kernel have a profile's parameters."""
    port = link.port
    assert port.is_open
    assert port.exclusive
    assert port.baudrate == line.baud
    assert port.bytesize == line.data_bits
    assert port.parity == _PARITIES[line.parity]
    assert port.stopbits == line.stop_bits
    assert port.rtscts == (line.flow_control == "rts-cts")
    assert not port.xonxoff
    assert not port.dsrdtr
    attributes = termios.tcgetattr(port.fileno())
    assert attributes[_OSPEED] == vars(termios)[f"B{line.baud}"]
    assert bool(attributes[_CFLAG] & termios.CSTOPB) == (line.stop_bits == 2)


def _record(kind: Kind[R, D], scenario: Scenario[R, D], rig: R, link: Link) -> Traffic:
    traffic: Traffic = []

    def note(link: str, direction: Direction, data: bytes) -> None:
        traffic.append((direction, data))

    scenario(Bench(kind.driver(CapturedLink(link, note), rig.clock), rig))
    return traffic


def _replay(
    kind: Kind[R, D], scenario: Scenario[R, D], traffic: Traffic, *, is_standing: bool
) -> None:
    clock = SimulatedClock()
    link = ScriptedLink(kind.name, traffic, clock=None if is_standing else clock)
    scenario(Bench(kind.driver(link, clock), None))
    assert link.is_exhausted
