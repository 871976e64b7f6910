"""Every fault of a wire, in memory and over a pseudo-terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.base import Link
from cell.links.memory import MemoryLink
from cell.links.reconnecting import ReconnectingLink
from cell.links.serial import SerialLink
from cell.profile import SerialProfile
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator, WireFault
from tests.cell.links.test_memory import Echo

WORD = b"a whole reply\r"


class Rig:
    """An echo behind a wire that can fail."""

    def __init__(self, way: str, folder: Path, stack: ExitStack) -> None:
        self.clock = SimulatedClock()
        self.wire = FaultyEmulator(Echo(0.01), seed=7)
        self.link: Link = MemoryLink("device", self.wire, self.clock)
        if way == "pty":
            line = SerialProfile(port=str(folder / "device"), baud=9600, parity="none", stop_bits=2)
            stepped = SteppedWire(self.wire, PtyPort(folder / "device", line), self.clock)
            stack.callback(stepped.close)
            self.link = ReconnectingLink(
                "device", lambda: stepped.open(lambda: SerialLink("device", line)), self.clock
            )
            stack.callback(self.link.close)

    def ask(self, timeout_s: float = 1.0) -> bytes:
        self.link.write(WORD)
        return self.gather(timeout_s)

    def gather(self, timeout_s: float = 1.0) -> bytes:
        """Return what comes until nothing has come for the time given."""
        data = b""
        while piece := self.link.read(timeout_s):
            data += piece
        return data


@pytest.fixture(params=["memory", "pty"])
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rig]:
    with ExitStack() as stack:
        yield Rig(str(request.param), tmp_path, stack)


def _one_bit_differs(data: bytes) -> bool:
    pairs = zip(data, WORD, strict=True)
    return sum((a ^ b).bit_count() for a, b in pairs) == 1


ONCE: dict[WireFault, Callable[[bytes], bool]] = {
    WireFault.LOST: lambda data: data == b"",
    WireFault.GARBAGE: lambda data: data != WORD and len(data) == len(WORD),
    WireFault.CORRUPTED: _one_bit_differs,
    WireFault.HALF: lambda data: data == WORD[: len(WORD) // 2],
}


@pytest.mark.parametrize("fault", ONCE)
def test_a_fault_of_one_reply_happens_to_one_reply(rig: Rig, fault: WireFault) -> None:
    rig.wire.inject(fault)
    assert rig.wire.has_fault
    assert ONCE[fault](rig.ask())
    assert not rig.wire.has_fault
    assert rig.ask() == WORD


def test_a_late_reply_comes_when_it_was_told_to(rig: Rig) -> None:
    rig.wire.inject(WireFault.LATE, delay_s=3.0)
    rig.link.write(WORD)
    assert rig.link.read(2.0) == b""
    assert rig.gather(2.0) == WORD


def test_a_slow_reply_trickles_in_byte_by_byte(rig: Rig) -> None:
    rig.wire.inject(WireFault.SLOW, delay_s=0.7)
    rig.link.write(WORD)
    pieces = [rig.link.read(1.0) for _ in WORD]
    assert b"".join(pieces) == WORD
    assert {len(piece) for piece in pieces} == {1}
    assert rig.clock.now_s() == pytest.approx(0.71)
    assert not rig.wire.has_fault


def test_what_follows_a_slow_reply_does_not_overtake_it(rig: Rig) -> None:
    rig.wire.inject(WireFault.SLOW, delay_s=0.7)
    rig.link.write(WORD)
    first = rig.link.read(1.0)
    rig.link.write(b"next")
    assert first + rig.gather() == WORD + b"next"


@pytest.mark.parametrize("fault", [WireFault.SILENT, WireFault.POWER])
def test_what_is_said_during_silence_is_lost_for_good(rig: Rig, fault: WireFault) -> None:
    rig.link.write(WORD)
    rig.wire.inject(fault)
    assert rig.gather() == b""
    assert rig.ask() == b""
    rig.wire.clear()
    assert rig.gather() == b""
    assert rig.ask() == WORD


def test_a_pulled_cable_is_an_error_until_it_is_back(rig: Rig) -> None:
    assert rig.ask() == WORD
    rig.link.write(b"before")
    rig.wire.inject(WireFault.UNPLUGGED)
    assert not rig.wire.is_plugged
    for _ in range(3):
        with pytest.raises(LinkError):
            rig.link.write(WORD)
        with pytest.raises(LinkError):
            rig.link.read(0.5)
    rig.clock.sleep(1.0)
    rig.wire.clear()
    assert rig.ask() == WORD
