import pytest

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.memory import MemoryLink


class Echo:
    """An emulator that says back what it hears, `delay_s` later."""

    def __init__(self, delay_s: float) -> None:
        self._delay_s = delay_s
        self._waiting: list[tuple[float, bytes]] = []
        self.heard_at_s: list[float] = []

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard_at_s.append(now_s)
        self._waiting.append((now_s + self._delay_s, data))

    def transmit(self, now_s: float) -> bytes:
        due = [data for due_s, data in self._waiting if due_s <= now_s]
        self._waiting = [(due_s, data) for due_s, data in self._waiting if due_s > now_s]
        return b"".join(due)

    def next_output_s(self) -> float | None:
        return min((due_s for due_s, _ in self._waiting), default=None)


class Tease:
    """An emulator that is always due and never says anything."""

    def __init__(self) -> None:
        self.asked = 0

    def receive(self, data: bytes, now_s: float) -> None:
        raise AssertionError("nothing is sent")

    def transmit(self, now_s: float) -> bytes:
        self.asked += 1
        return b""

    def next_output_s(self) -> float | None:
        return 0.0


def test_a_read_jumps_to_the_moment_of_the_answer() -> None:
    clock = SimulatedClock(7.0)
    link = MemoryLink("gripper", Echo(0.25), clock)
    link.write(b"hello")
    assert link.read(1.0) == b"hello"
    assert clock.now_s() == pytest.approx(7.25)


def test_a_read_without_an_answer_takes_its_time_out_and_no_more() -> None:
    clock = SimulatedClock(7.0)
    link = MemoryLink("gripper", Echo(0.25), clock)
    assert link.read(0.5) == b""
    assert clock.now_s() == pytest.approx(7.5)


def test_an_answer_after_the_deadline_waits_for_the_next_read() -> None:
    clock = SimulatedClock()
    link = MemoryLink("gripper", Echo(0.25), clock)
    link.write(b"late")
    assert link.read(0.1) == b""
    assert clock.now_s() == pytest.approx(0.1)
    assert link.read(1.0) == b"late"
    assert clock.now_s() == pytest.approx(0.25)


def test_an_answer_at_the_deadline_is_in_time() -> None:
    clock = SimulatedClock()
    link = MemoryLink("gripper", Echo(0.25), clock)
    link.write(b"just")
    assert link.read(0.25) == b"just"


@pytest.mark.parametrize("timeout_s", [0.0, -1.0])
def test_a_read_without_patience_takes_only_what_is_there(timeout_s: float) -> None:
    clock = SimulatedClock()
    link = MemoryLink("gripper", Echo(0.25), clock)
    link.write(b"x")
    assert link.read(timeout_s) == b""
    assert clock.now_s() == 0.0
    clock.sleep(1.0)
    assert link.read(timeout_s) == b"x"


def test_what_has_arrived_is_read_without_waiting() -> None:
    clock = SimulatedClock()
    link = MemoryLink("gripper", Echo(0.0), clock)
    link.write(b"a")
    link.write(b"b")
    assert link.read(5.0) == b"ab"
    assert clock.now_s() == 0.0


def test_the_emulator_hears_at_the_time_of_the_write() -> None:
    clock = SimulatedClock(3.0)
    echo = Echo(0.0)
    MemoryLink("gripper", echo, clock).write(b"x")
    assert echo.heard_at_s == [3.0]


def test_an_emulator_that_is_due_for_ever_does_not_hold_the_time_still() -> None:
    clock = SimulatedClock(100.0)
    tease = Tease()
    assert MemoryLink("gripper", tease, clock).read(30.0) == b""
    assert clock.now_s() >= 130.0
    assert tease.asked < 100


def test_a_closed_link_carries_nothing_and_says_whose_it_is() -> None:
    link = MemoryLink("gripper", Echo(0.0), SimulatedClock())
    link.close()
    link.close()
    with pytest.raises(LinkError, match="gripper is closed"):
        link.write(b"x")
    with pytest.raises(LinkError, match="gripper is closed"):
        link.read(0.0)


def test_a_link_has_the_name_of_its_device() -> None:
    assert MemoryLink("gripper", Echo(0.0), SimulatedClock()).name == "gripper"
