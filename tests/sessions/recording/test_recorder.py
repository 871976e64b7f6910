from __future__ import annotations

import hashlib
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from cell.devices.camera import Frame
from sessions.journal import Reply
from sessions.recording import RecordingError, SessionRecording
from sessions.recording.pictures import PictureStorage, decode_picture
from sessions.recording.view_writer import ViewWriter
from tests.sessions.recording.samples import (
    STARTED,
    a_bench,
    a_frame,
    a_recording,
    a_start,
    a_view_reply,
)


def test_everything_of_the_start_comes_back(tmp_path: Path) -> None:
    recording = SessionRecording.open(a_recording(tmp_path))
    expected = a_start()
    start = recording.start
    assert start.script_text == expected.script_text
    assert start.profile_text == expected.profile_text
    assert start.world_json == expected.world_json
    assert (start.session_id, start.script_name) == (expected.session_id, expected.script_name)
    assert (start.dialect, start.seed, start.peer) == ("1.5", 42, "127.0.0.1:50000")
    assert start.versions == expected.versions
    assert recording.started_utc == STARTED


def test_the_calibrations_of_the_profile_are_kept_by_value(tmp_path: Path) -> None:
    calibration = SessionRecording.open(a_recording(tmp_path)).calibration
    assert "0.58748" in calibration["plane_map/top"]
    assert '"step_mm":20' in calibration["lattice"].replace(" ", "")


def test_lines_and_replies_come_back_byte_for_byte(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    bench.recorder.received(b"\xff\xfe 'half a quote\x00")
    bench.recorder.replied(Reply(text=b"INVALID_ARGUMENTS \xff\n"))
    bench.recorder.close("over")
    steps = list(SessionRecording.open(bench.path).steps())
    assert [(s.number, s.line, s.reply) for s in steps] == [
        (1, b"STATUS", b"READY\n"),
        (2, b"\xff\xfe 'half a quote\x00", b"INVALID_ARGUMENTS \xff\n"),
    ]


def test_steps_join_their_wire_traffic_and_events(tmp_path: Path) -> None:
    recording = SessionRecording.open(a_recording(tmp_path))
    second = [step for step in recording.steps() if step.line == b"ACTION RIGHT"][1]
    traffic = [b for b in recording.wire("arm") if b.step == second.number]
    assert [(b.direction, b.data) for b in traffic[:2]] == [
        ("to_device", b"1;1;EXECMVS P1\r"),
        ("from_device", b"QoK\r"),
    ]
    assert len(traffic) == 8
    events = [e for e in recording.events() if e.step == second.number]
    assert [e.type for e in events] == ["MotionFinished", "StepTaken"]
    assert events[0].fields["pose"] == {
        "x_mm": 708.0,
        "y_mm": -265.25,
        "z_mm": 98.5,
        "a_deg": 180.0,
        "b_deg": 0.0,
        "c_deg": 180.0,
    }
    assert list(recording.wire("gripper")) == []


def test_times_are_nanoseconds_of_the_sessions_clock(tmp_path: Path) -> None:
    recording = SessionRecording.open(a_recording(tmp_path))
    answers = [b.time_ns for b in recording.wire("arm") if b.direction == "from_device"]
    assert answers[:4] == [10_000_000, 20_000_000, 30_000_000, 40_000_000]
    assert recording.duration_ns == 120_000_000


def test_a_view_names_its_record_and_the_record_has_the_hash_of_what_was_sent(
    tmp_path: Path,
) -> None:
    recording = SessionRecording.open(a_recording(tmp_path))
    sent = [step for step in recording.steps() if step.view is not None]
    hashes = recording.view_hashes()
    for step, frame in zip(sent, (a_frame(1), a_frame(1), a_frame(2)), strict=True):
        assert step.view is not None
        data = a_view_reply(frame).data
        assert hashes[step.view.view] == hashlib.sha256(data).hexdigest()
        assert step.data_size == step.view.size == len(data)
        assert (step.view.width, step.view.height) == (64, 48)


def test_an_unchanged_frame_is_kept_once(tmp_path: Path) -> None:
    recording = SessionRecording.open(a_recording(tmp_path))
    assert [step.view.view for step in recording.steps() if step.view] == [1, 1, 2]
    assert [view.view for view in recording.views()] == [1, 2]


def test_one_frame_in_two_encodings_is_two_views(tmp_path: Path) -> None:
    seen: list[int] = []
    writer = ViewWriter(lambda camera, step, message: seen.append(step), "none")
    frame = a_frame(1)
    assert writer.take(frame, "image/mif", b"long data", 1) == 1
    assert writer.take(frame, "image/png", b"png", 2) == 2
    assert writer.take(frame, "image/mif", b"long data", 3) == 1
    assert writer.take(frame, "image/mif", b"short", 4) == 3
    writer.close()
    assert seen == [1, 2, 4]


@pytest.mark.parametrize(("storage", "largest_error"), [("lossless", 0), ("jpeg", 40)])
def test_pictures_come_back(tmp_path: Path, storage: PictureStorage, largest_error: int) -> None:
    recording = SessionRecording.open(a_recording(tmp_path, storage))
    view = next(recording.views())
    picture = decode_picture(view.picture)
    difference = np.abs(picture.astype(int) - a_frame(1).pixels.astype(int))
    assert picture.shape == (48, 64, 3)
    assert difference.max() <= largest_error
    assert difference.mean() <= largest_error / 10


def test_without_pictures_the_hash_is_still_kept(tmp_path: Path) -> None:
    view = next(SessionRecording.open(a_recording(tmp_path, "none")).views())
    assert view.picture == b""
    assert view.encoding == "none"
    assert view.sha256 == hashlib.sha256(a_view_reply(a_frame(1)).data).hexdigest()
    with pytest.raises(RecordingError, match="no picture"):
        decode_picture(view.picture)


def test_a_step_is_in_the_file_when_its_reply_leaves(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    bench.step(1)
    steps = list(SessionRecording.open(bench.path).steps())
    assert steps[-1].reply == b"REWARD 0\nEVENT 'Robot move'\nSTATE_UPDATED\n"
    bench.recorder.close("over")


def test_a_step_is_written_at_once_and_its_traffic_when_it_has_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = a_bench(tmp_path)
    bench.step(1)
    bench.recorder.settled()
    writes: list[int] = []
    real_write = os.write

    def counting(descriptor: int, data: bytes) -> int:
        writes.append(len(data))
        return real_write(descriptor, data)

    monkeypatch.setattr(os, "write", counting)
    bench.step(2)
    assert len(writes) == 1
    recording = SessionRecording.open(bench.path)
    assert list(recording.steps())[-1].reply is not None
    bench.recorder.settled()
    bench.recorder.settled()
    assert len(writes) == 2
    bench.recorder.close("over")


def test_a_long_command_is_written_in_between(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    bench.recorder.received(b"END_TASK_SETUP")
    for _ in range(1000):
        bench.factory.tap("arm", "from_device", b"QoK 1234567890\r")
    recording = SessionRecording.open(bench.path)
    assert list(recording.lines())[-1] == b"END_TASK_SETUP"
    assert list(recording.steps())[-1].reply is None
    assert sum(1 for _ in recording.wire("arm")) > 500
    bench.recorder.close("over")


def test_traffic_after_the_end_is_not_noted(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    bench.recorder.close("over")
    size = bench.path.stat().st_size
    bench.factory.tap("arm", "to_device", b"x" * 100_000)
    bench.recorder.close("again")
    assert bench.path.stat().st_size == size
    assert SessionRecording.open(bench.path).end_reason == "over"


def test_a_full_queue_holds_the_session_up_and_loses_nothing() -> None:
    may_write = threading.Event()
    written: list[int] = []

    def write(camera: str, step: int, message: bytes) -> None:
        assert may_write.wait(10)
        written.append(step)

    writer = ViewWriter(write, "none", capacity=1)
    done = threading.Event()

    def session() -> None:
        for step in range(5):
            writer.take(a_frame(step), "image/mif", b"data", step)
        done.set()

    thread = threading.Thread(target=session)
    thread.start()
    assert not done.wait(0.05)
    may_write.set()
    thread.join(10)
    writer.close()
    assert written == [0, 1, 2, 3, 4]


def test_a_broken_disk_stops_the_recording_and_not_the_session(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    bench = a_bench(tmp_path)
    bench.step(1)

    def full(descriptor: int, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        bench.step(2)
    bench.step(3)
    bench.recorder.close("over")
    assert "No space left" in str(bench.recorder.failure)
    assert caplog.text.count("recording stopped") == 1
    recording = SessionRecording.open(bench.path)
    assert not recording.is_finished
    assert [s.line for s in recording.steps()] == [b"STATUS", b"ACTION RIGHT"]


def test_a_picture_that_cannot_be_encoded_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bench = a_bench(tmp_path)
    good = a_frame(1)
    bad = Frame(
        camera="top",
        number=2,
        time_s=0.0,
        pixels=np.zeros((0, 0, 3), np.uint8),
        settings=good.settings,
    )
    bench.view(bad)
    bench.recorder.close("over")
    assert "views are missing" in str(bench.recorder.failure)
    assert not SessionRecording.open(bench.path).is_finished


def test_a_recording_is_never_overwritten(tmp_path: Path) -> None:
    a_recording(tmp_path)
    with pytest.raises(RecordingError, match="cannot be created"):
        a_bench(tmp_path)


def test_devices_that_come_up_at_the_same_time_lose_no_byte(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    links = ("arm", "gripper", "display")
    pieces = {link: [f"{link} {n};".encode() for n in range(1000)] for link in links}
    now_s = bench.recorder._now_s

    def yielding_s() -> float:
        # In the middle of noting a piece the other threads have their turn.
        time.sleep(0)
        return now_s()

    bench.recorder._now_s = yielding_s
    together = threading.Barrier(len(links))

    def talk(link: str) -> None:
        together.wait()
        for number, piece in enumerate(pieces[link]):
            bench.recorder.wire(link, "from_device" if number % 2 else "to_device", piece)

    with ThreadPoolExecutor(len(links)) as pool:
        for done in [pool.submit(talk, link) for link in links]:
            done.result()
    bench.recorder.close("over")
    recording = SessionRecording.open(bench.path)
    for link in links:
        traffic = list(recording.wire(link))
        assert [piece.data for piece in traffic] == pieces[link]
        assert [piece.direction for piece in traffic[:2]] == ["to_device", "from_device"]
        times = [piece.time_ns for piece in traffic]
        assert times == sorted(times)
