"""A link that survives that its cable is pulled and put back."""

from __future__ import annotations

import pytest

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.base import Link
from cell.links.errors import PortMissing, is_lasting
from cell.links.reconnecting import ReconnectingLink
from cell.stop import StopToken


class Line:
    """A link that breaks when told."""

    name = "arm"

    def __init__(self, number: int) -> None:
        self.pending = b""
        self.number = number
        self.is_broken = False
        self.is_closed = False

    def write(self, data: bytes) -> None:
        self._check()
        self.pending += data

    def read(self, timeout_s: float) -> bytes:
        self._check()
        data, self.pending = self.pending, b""
        return data

    def close(self) -> None:
        self.is_closed = True

    def _check(self) -> None:
        if self.is_broken:
            raise LinkError("arm: gone")


class Socket:
    """Where lines are plugged in; notes when somebody tries."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.token = StopToken()
        self.tries_s: list[float] = []
        self.lines: list[Line] = []
        self.back_at_s = 0.0
        self.link = ReconnectingLink("arm", self._open, self.clock, token=self.token)

    def _open(self) -> Link:
        self.tries_s.append(self.clock.now_s())
        if self.clock.now_s() < self.back_at_s:
            raise LinkError("arm: no port")
        self.lines.append(Line(len(self.lines)))
        return self.lines[-1]

    def pull(self, back_after_s: float) -> None:
        self.lines[-1].is_broken = True
        self.back_at_s = self.clock.now_s() + back_after_s
        with pytest.raises(LinkError, match="gone"):
            self.link.write(b"?")
        self.tries_s.clear()


@pytest.fixture
def socket() -> Socket:
    made = Socket()
    made.link.write(b"first")
    return made


def test_nothing_is_opened_before_it_is_used() -> None:
    assert Socket().tries_s == []


def test_the_operation_that_finds_the_loss_fails_and_the_next_one_works(socket: Socket) -> None:
    socket.pull(0.0)
    socket.link.write(b"again")
    assert socket.link.read(0.0) == b"again"
    assert socket.link.reopened == 1
    assert socket.lines[0].is_closed


def test_bytes_of_the_old_link_are_never_delivered(socket: Socket) -> None:
    socket.lines[0].pending = b"stale"
    socket.pull(0.0)
    assert socket.link.read(0.0) == b""


def test_the_tries_come_at_once_and_then_further_and_further_apart(socket: Socket) -> None:
    socket.pull(100.0)
    with pytest.raises(LinkError, match="no port"):
        socket.link.write(b"?")
    gaps = [b - a for a, b in zip(socket.tries_s, socket.tries_s[1:], strict=False)]
    assert socket.tries_s[0] == 0.0
    assert gaps == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.6, 1.9])
    assert socket.clock.now_s() == pytest.approx(5.0)


def test_a_cable_that_is_back_in_time_is_not_noticed_further(socket: Socket) -> None:
    socket.pull(1.0)
    socket.link.write(b"again")
    assert socket.link.read(0.0) == b"again"
    assert 1.0 <= socket.clock.now_s() < 2.0


def test_after_its_patience_it_tries_once_and_costs_no_time(socket: Socket) -> None:
    socket.pull(100.0)
    with pytest.raises(LinkError):
        socket.link.write(b"?")
    now_s = socket.clock.now_s()
    socket.tries_s.clear()
    with pytest.raises(LinkError):
        socket.link.write(b"?")
    assert socket.tries_s == [now_s]
    assert socket.clock.now_s() == now_s


def test_where_a_stop_is_asked_for_nothing_is_waited_for(socket: Socket) -> None:
    socket.pull(100.0)
    socket.token.stop("somebody pressed it")
    with pytest.raises(LinkError, match="no port"):
        socket.link.write(b"?")
    assert socket.clock.now_s() == 0.0


def test_a_closed_link_is_not_opened_again(socket: Socket) -> None:
    socket.link.close()
    with pytest.raises(LinkError, match="arm is closed"):
        socket.link.write(b"?")


def _missing() -> Link:
    raise PortMissing("arm", "COM9", ())


def _why_not(link: ReconnectingLink) -> PortMissing:
    with pytest.raises(PortMissing) as caught:
        link.write(b"?")
    return caught.value


def test_a_port_that_never_was_is_told_as_lasting() -> None:
    link = ReconnectingLink("arm", _missing, SimulatedClock())
    assert is_lasting(_why_not(link))


def test_a_lost_port_is_told_as_lasting_when_the_patience_is_used_up() -> None:
    clock, token = SimulatedClock(), StopToken()
    openings = iter([lambda: Line(0)])
    link = ReconnectingLink("arm", lambda: next(openings, _missing)(), clock, token=token)
    link.write(b"first")
    line = link._link
    assert isinstance(line, Line)
    line.is_broken = True
    with pytest.raises(LinkError, match="gone") as lost:
        link.write(b"?")
    assert not is_lasting(lost.value)
    token.stop("somebody pressed it")
    assert not is_lasting(_why_not(link))
    token.clear()
    assert is_lasting(_why_not(link))
    assert clock.now_s() == pytest.approx(5.0)
