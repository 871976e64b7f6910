"""What every link does: in memory, captured, replayed, over a port, over TCP, reopened."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from cell.clock import Clock, SimulatedClock, SystemClock
from cell.errors import LinkError
from cell.links.base import Direction, Link
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.opening import lazy_link
from cell.links.reconnecting import ReconnectingLink
from cell.links.scripted import ScriptedLink
from cell.links.serial import SerialLink
from cell.links.tcp import TcpLink
from cell.profile import SerialProfile, TcpProfile
from cell.twin.serving.ends import DeviceEnd, PtyEnd, TcpEnd
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.server import EmulatorServer
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator

DELAY_S = 0.02
LINE = SerialProfile(baud=38400, parity="even", stop_bits=2)
TRAFFIC: list[tuple[Direction, bytes]] = [
    ("to_device", b"ping"),
    ("from_device", b"pong"),
    ("to_device", b"bye"),
]


class Pong:
    """Answers `ping` with `pong`, a while later, and nothing else."""

    def __init__(self) -> None:
        self._due_s: float | None = None

    def receive(self, data: bytes, now_s: float) -> None:
        if data == b"ping":
            self._due_s = now_s + DELAY_S

    def transmit(self, now_s: float) -> bytes:
        if self._due_s is None or now_s < self._due_s:
            return b""
        self._due_s = None
        return b"pong"

    def next_output_s(self) -> float | None:
        return self._due_s


class Bench:
    """What a link is made of: a clock, a folder for ports, and what must be ended."""

    def __init__(self, clock: Clock, folder: Path, stack: ExitStack) -> None:
        self.clock = clock
        self.line = LINE.model_copy(update={"port": str(folder / "device")})
        self.stack = stack

    def stepped(self) -> Link:
        wire = SteppedWire(FaultyEmulator(Pong()), self._port(), self.clock)
        self.stack.callback(wire.close)
        return wire.open(lambda: SerialLink("device", self.line))

    def served(self) -> None:
        """Have a thread serve the device on the port."""
        self._serve(PtyEnd(self._port()))

    def served_on_tcp(self) -> TcpProfile:
        end = TcpEnd("127.0.0.1", 0)
        self._serve(end)
        return TcpProfile(host="127.0.0.1", port=end.port)

    def _port(self) -> PtyPort:
        return PtyPort(Path(self.line.port), self.line)

    def _serve(self, end: DeviceEnd) -> None:
        device = FaultyEmulator(Pong())
        self.stack.enter_context(EmulatorServer("device", device, end, self.clock))


def _memory(bench: Bench) -> Link:
    return MemoryLink("device", Pong(), bench.clock)


def _captured(bench: Bench) -> Link:
    return CapturedLink(_memory(bench), lambda link, direction, data: None)


def _scripted(bench: Bench) -> Link:
    return ScriptedLink("device", TRAFFIC, clock=bench.clock)


def _captured_and_scripted(bench: Bench) -> Link:
    return CapturedLink(_scripted(bench), lambda link, direction, data: None)


def _reconnecting(bench: Bench) -> Link:
    return ReconnectingLink("device", lambda: _memory(bench), bench.clock)


def _stepped_pty(bench: Bench) -> Link:
    return bench.stepped()


def _serial(bench: Bench) -> Link:
    bench.served()
    return SerialLink("device", bench.line)


def _serial_by_pyserial(bench: Bench) -> Link:
    bench.served()
    return SerialLink("device", bench.line, is_polled=False)


def _tcp(bench: Bench) -> Link:
    return TcpLink("device", bench.served_on_tcp())


def _lazy_serial(bench: Bench) -> Link:
    bench.served()
    return lazy_link("device", bench.line, bench.clock)


SIMULATED: list[Callable[[Bench], Link]] = [
    _memory,
    _captured,
    _scripted,
    _captured_and_scripted,
    _reconnecting,
    _stepped_pty,
]
REAL_TIME: list[Callable[[Bench], Link]] = [_serial, _serial_by_pyserial, _tcp, _lazy_serial]


@pytest.fixture(params=SIMULATED + REAL_TIME, ids=lambda maker: maker.__name__)
def maker(request: pytest.FixtureRequest) -> Callable[[Bench], Link]:
    made: Callable[[Bench], Link] = request.param
    return made


@pytest.fixture
def clock(maker: Callable[[Bench], Link]) -> Clock:
    return SystemClock() if maker in REAL_TIME else SimulatedClock(10.0)


@pytest.fixture
def link(maker: Callable[[Bench], Link], clock: Clock, tmp_path: Path) -> Iterator[Link]:
    with ExitStack() as stack:
        made = maker(Bench(clock, tmp_path, stack))
        stack.callback(made.close)
        yield made


def test_a_link_has_the_name_of_its_device(link: Link) -> None:
    assert link.name == "device"


def test_an_answer_is_read_within_the_time_given(link: Link, clock: Clock) -> None:
    start_s = clock.now_s()
    link.write(b"ping")
    assert _read_all(link, 4) == b"pong"
    assert clock.now_s() - start_s <= 10.0


def test_an_answer_is_read_once(link: Link) -> None:
    link.write(b"ping")
    assert _read_all(link, 4) == b"pong"
    assert link.read(0.05) == b""


def test_a_read_of_nothing_is_empty_after_the_time_given(link: Link, clock: Clock) -> None:
    start_s = clock.now_s()
    assert link.read(0.05) == b""
    assert clock.now_s() - start_s >= 0.05 - 1e-9


def test_a_read_without_patience_returns_nothing(link: Link) -> None:
    assert link.read(0.0) == b""


def test_a_read_without_patience_lets_no_time_pass_on_a_simulated_clock(
    link: Link, clock: Clock
) -> None:
    start_s = clock.now_s()
    link.read(0.0)
    assert clock.now_s() == start_s or isinstance(clock, SystemClock)


def _read_all(link: Link, count: int) -> bytes:
    """Return that many bytes, which a port may deliver in pieces."""
    data = link.read(10.0)
    while 0 < len(data) < count:
        data += link.read(10.0)
    return data


def test_closing_twice_is_harmless_and_afterwards_nothing_passes(link: Link) -> None:
    link.close()
    link.close()
    with pytest.raises(LinkError, match="device is closed"):
        link.write(b"ping")
    with pytest.raises(LinkError, match="device is closed"):
        link.read(0.0)
