"""What every link does: in memory, captured, replayed."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.base import Direction, Link
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.scripted import ScriptedLink

DELAY_S = 0.2
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


def _memory(clock: SimulatedClock) -> Link:
    return MemoryLink("device", Pong(), clock)


def _captured(clock: SimulatedClock) -> Link:
    return CapturedLink(_memory(clock), lambda link, direction, data: None)


def _scripted(clock: SimulatedClock) -> Link:
    return ScriptedLink("device", TRAFFIC, clock=clock)


def _captured_and_scripted(clock: SimulatedClock) -> Link:
    return CapturedLink(_scripted(clock), lambda link, direction, data: None)


MAKERS: list[Callable[[SimulatedClock], Link]] = [
    _memory,
    _captured,
    _scripted,
    _captured_and_scripted,
]


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock(10.0)


@pytest.fixture(params=MAKERS, ids=lambda maker: maker.__name__)
def link(request: pytest.FixtureRequest, clock: SimulatedClock) -> Link:
    made: Link = request.param(clock)
    return made


def test_a_link_has_the_name_of_its_device(link: Link) -> None:
    assert link.name == "device"


def test_an_answer_is_read_within_the_time_given(link: Link, clock: SimulatedClock) -> None:
    link.write(b"ping")
    assert link.read(1.0) == b"pong"
    assert clock.now_s() <= 11.0


def test_an_answer_is_read_once(link: Link) -> None:
    link.write(b"ping")
    link.read(1.0)
    assert link.read(1.0) == b""


def test_a_read_of_nothing_is_empty_after_the_time_given(link: Link, clock: SimulatedClock) -> None:
    assert link.read(0.5) == b""
    assert clock.now_s() == pytest.approx(10.5)


def test_a_read_without_patience_returns_at_once(link: Link, clock: SimulatedClock) -> None:
    assert link.read(0.0) == b""
    assert clock.now_s() == 10.0


def test_closing_twice_is_harmless_and_afterwards_nothing_passes(link: Link) -> None:
    link.close()
    link.close()
    with pytest.raises(LinkError, match="device is closed"):
        link.write(b"ping")
    with pytest.raises(LinkError, match="device is closed"):
        link.read(0.0)
