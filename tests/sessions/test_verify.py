from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from cell.devices.camera import Frame
from sessions.journal import Reply, SentView
from sessions.recording import SessionRecording
from sessions.verify import compare
from tests.sessions.recording.samples import a_bench, a_frame, a_view_reply

MOVE = Reply(text=b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n")
WALL = Reply(text=b"REWARD -10\nEVENT 'Robot hit the wall'\nSTATE_UPDATED\n")
BYE = Reply(text=b"GOODBYE\n", closes=True)
READY = Reply(text=b"READY\n")


class Parrot:
    """A session that answers as it was told to."""

    def __init__(self, replies: Sequence[Reply]) -> None:
        self.replies = list(replies)
        self.lines: list[bytes] = []
        self.ends: list[str] = []

    def handle(self, line: bytes) -> Reply:
        self.lines.append(line)
        return self.replies[len(self.lines) - 1]

    def end(self, reason: str) -> None:
        self.ends.append(reason)


def _recorded(
    folder: Path, exchanges: Sequence[tuple[bytes, Reply]], *, close: bool = True
) -> SessionRecording:
    bench = a_bench(folder, "none")
    for line, reply in exchanges:
        bench.recorder.received(line)
        bench.recorder.replied(reply)
    if close:
        bench.recorder.close("done")
    recording = SessionRecording.open(bench.path)
    bench.recorder.close("done")
    return recording


def _changed(frame: Frame) -> Reply:
    reply = a_view_reply(frame)
    data = bytearray(reply.data)
    data[-1] ^= 1
    return Reply(text=reply.text, data=bytes(data), view=SentView(frame, "image/mif"))


def test_the_same_replies_are_identical(tmp_path: Path) -> None:
    view = a_view_reply(a_frame(1))
    said = [(b"ACTION UP", MOVE), (b"GET_VIEW CAMERA_TOP", view), (b"DONE", BYE)]
    session = Parrot([READY, MOVE, a_view_reply(a_frame(1)), BYE])
    report = compare(_recorded(tmp_path, said), session)
    assert report.is_identical
    assert (report.lines, report.views, report.views_unproven) == (4, 1, 0)
    assert session.lines == [b"STATUS", b"ACTION UP", b"GET_VIEW CAMERA_TOP", b"DONE"]
    assert session.ends == ["replayed"]
    assert report.describe().startswith("identical: 4 replies and 1 views")


def test_a_changed_reward_names_the_step_the_line_and_both_replies(tmp_path: Path) -> None:
    recording = _recorded(tmp_path, [(b"ACTION UP", MOVE), (b"ACTION LEFT", WALL), (b"X", MOVE)])
    session = Parrot([READY, MOVE, MOVE])
    report = compare(recording, session)
    found = report.difference
    assert found is not None
    assert (found.step, found.line, found.what) == (3, b"ACTION LEFT", "reply")
    assert (found.recorded, found.replayed) == (WALL.text, MOVE.text)
    words = report.describe()
    assert words.splitlines()[0] == "different at step 3: ACTION LEFT"
    assert "recorded < REWARD -10" in words
    assert "replayed < REWARD 0" in words
    assert "    2   > ACTION UP" in words
    assert report.as_json()["identical"] is False
    assert len(session.lines) == 3, "it stops at the first difference"


def test_one_changed_byte_of_a_view_is_found(tmp_path: Path) -> None:
    frames = [a_frame(1), a_frame(2)]
    said = [(b"GET_VIEW CAMERA_TOP", a_view_reply(frame)) for frame in frames]
    session = Parrot([READY, a_view_reply(frames[0]), _changed(frames[1])])
    found = compare(_recorded(tmp_path, said), session).difference
    assert found is not None
    assert (found.step, found.what) == (3, "view")


def test_a_view_that_differs_before_a_reply_does_is_the_first_difference(tmp_path: Path) -> None:
    frame = a_frame(1)
    said = [(b"GET_VIEW CAMERA_TOP", a_view_reply(frame)), (b"ACTION UP", MOVE)]
    found = compare(_recorded(tmp_path, said), Parrot([READY, _changed(frame), WALL])).difference
    assert found is not None
    assert (found.step, found.what) == (2, "view")


@pytest.mark.parametrize(
    "other",
    [Reply(text=b"GOODBYE\n"), Reply(text=b"GOODBYE\n", data=b"x", closes=True)],
    ids=["stays open", "has data"],
)
def test_a_reply_that_differs_in_more_than_its_text_is_found(tmp_path: Path, other: Reply) -> None:
    report = compare(_recorded(tmp_path, [(b"DONE", BYE)]), Parrot([READY, other]))
    assert report.difference is not None


def test_lines_that_were_answered_busy_are_not_replayed(tmp_path: Path) -> None:
    said = [(b"INITIALIZE_TASK A B", Reply(text=b"BUSY\n")), (b"DONE", BYE)]
    session = Parrot([READY, BYE])
    report = compare(_recorded(tmp_path, said), session)
    assert report.is_identical
    assert report.lines_skipped == 1
    assert session.lines == [b"STATUS", b"DONE"]
    assert "1 lines answered BUSY" in report.describe()


def test_a_recording_cut_short_is_compared_as_far_as_it_goes(tmp_path: Path) -> None:
    bench = a_bench(tmp_path, "none")
    bench.recorder.received(b"ACTION UP")
    bench.recorder.replied(MOVE)
    bench.recorder.received(b"ACTION DOWN")
    recording = SessionRecording.open(bench.path)
    report = compare(recording, Parrot([READY, MOVE]))
    bench.recorder.close("over")
    assert report.is_identical
    assert report.is_cut_short
    assert report.lines == 2
    assert "not finished" in report.describe()


def test_progress_is_told_after_every_line(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    recording = _recorded(tmp_path, [(b"ACTION UP", MOVE)] * 3)
    compare(recording, Parrot([READY, MOVE, MOVE, MOVE]), lambda d, n: told.append((d, n)))
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
