import pytest

from cell.errors import LinkError
from cell.links.base import Direction
from cell.links.capture import CapturedLink
from cell.links.scripted import ScriptedLink

TRAFFIC: list[tuple[Direction, bytes]] = [
    ("to_device", b"ask"),
    ("from_device", b"answer"),
    ("to_device", b"bye"),
]


class Notes:
    """A tap that remembers."""

    def __init__(self) -> None:
        self.seen: list[tuple[str, Direction, bytes]] = []

    def __call__(self, link: str, direction: Direction, data: bytes) -> None:
        self.seen.append((link, direction, data))


def test_a_tap_sees_both_directions_in_order_and_by_name() -> None:
    notes = Notes()
    link = CapturedLink(ScriptedLink("arm", TRAFFIC), notes)
    link.write(b"ask")
    assert link.read(1.0) == b"answer"
    link.write(b"bye")
    assert notes.seen == [("arm", direction, data) for direction, data in TRAFFIC]
    assert link.name == "arm"


def test_a_read_of_nothing_is_not_shown() -> None:
    notes = Notes()
    link = CapturedLink(ScriptedLink("arm", TRAFFIC), notes)
    assert link.read(1.0) == b""
    assert notes.seen == []


def test_what_could_not_be_sent_is_not_shown() -> None:
    notes = Notes()
    link = CapturedLink(ScriptedLink("arm", TRAFFIC), notes)
    with pytest.raises(LinkError):
        link.write(b"something else")
    assert notes.seen == []


def test_closing_closes_the_wrapped_link() -> None:
    inner = ScriptedLink("arm", TRAFFIC)
    CapturedLink(inner, Notes()).close()
    with pytest.raises(LinkError, match="closed"):
        inner.read(0.0)


def test_a_capture_plays_again_as_it_was_taken() -> None:
    notes = Notes()
    first = CapturedLink(ScriptedLink("arm", TRAFFIC), notes)
    first.write(b"ask")
    first.read(1.0)
    first.write(b"bye")
    again = ScriptedLink("arm", [(direction, data) for _, direction, data in notes.seen])
    again.write(b"ask")
    assert again.read(1.0) == b"answer"
    again.write(b"bye")
    assert again.is_exhausted
