import pytest

from cell.clock import SimulatedClock
from cell.errors import LinkError
from cell.links.base import Direction
from cell.links.scripted import ScriptedLink

ASK: tuple[Direction, bytes] = ("to_device", b"ask")
ANSWER: tuple[Direction, bytes] = ("from_device", b"answer")


def test_the_recorded_answer_follows_the_recorded_request() -> None:
    link = ScriptedLink("tv", [ASK, ANSWER])
    assert not link.is_exhausted
    link.write(b"ask")
    assert link.read(1.0) == b"answer"
    assert link.is_exhausted


def test_an_answer_does_not_come_before_its_request() -> None:
    link = ScriptedLink("tv", [ASK, ANSWER])
    assert link.read(1.0) == b""
    link.write(b"ask")
    assert link.read(1.0) == b"answer"
    assert link.read(1.0) == b""


def test_answers_come_in_the_recorded_pieces() -> None:
    link = ScriptedLink("tv", [("from_device", b"an"), ("from_device", b"swer")])
    assert [link.read(1.0), link.read(1.0), link.read(1.0)] == [b"an", b"swer", b""]


@pytest.mark.parametrize("pieces", [[b"a", b"sk"], [b"ask"], [b"a", b"s", b"k"]])
def test_a_request_may_be_written_in_other_pieces(pieces: list[bytes]) -> None:
    link = ScriptedLink("tv", [ASK, ANSWER])
    for piece in pieces:
        link.write(piece)
    assert link.read(1.0) == b"answer"


def test_one_write_may_be_two_recorded_ones() -> None:
    link = ScriptedLink("tv", [ASK, ASK])
    link.write(b"askask")
    assert link.is_exhausted


def test_half_a_request_does_not_bring_its_answer() -> None:
    link = ScriptedLink("tv", [ASK, ANSWER])
    link.write(b"as")
    assert link.read(1.0) == b""


@pytest.mark.parametrize("data", [b"other", b"asK", b"askmore"])
def test_another_request_than_the_recorded_one_is_told(data: bytes) -> None:
    link = ScriptedLink("tv", [ASK, ANSWER])
    with pytest.raises(LinkError, match="tv: the capture has"):
        link.write(data)


def test_a_request_where_an_answer_is_due_is_told() -> None:
    link = ScriptedLink("tv", [ANSWER])
    with pytest.raises(LinkError, match="no request here"):
        link.write(b"ask")


def test_a_read_of_nothing_takes_its_time_on_a_clock_that_is_given() -> None:
    clock = SimulatedClock()
    link = ScriptedLink("tv", [ASK, ANSWER], clock=clock)
    assert link.read(0.5) == b""
    assert clock.now_s() == 0.5
    link.write(b"ask")
    link.read(0.5)
    assert clock.now_s() == 0.5


def test_a_closed_link_carries_nothing() -> None:
    link = ScriptedLink("tv", [ASK])
    link.close()
    link.close()
    with pytest.raises(LinkError, match="tv is closed"):
        link.write(b"ask")
    with pytest.raises(LinkError, match="tv is closed"):
        link.read(1.0)
