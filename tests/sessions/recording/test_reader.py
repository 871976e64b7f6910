from __future__ import annotations

import contextlib
import struct
from pathlib import Path

import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import McapRecord, Message
from mcap.stream_reader import StreamReader

from sessions.recording import RecordedStep, RecordingError, SessionRecording
from sessions.recording.scan import RecordScan
from tests.sessions.recording.samples import a_bench, a_recording


def test_the_librarys_readers_read_a_finished_recording(tmp_path: Path) -> None:
    path = a_recording(tmp_path)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "robocell"
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        topics = {channel.topic for channel in summary.channels.values()}
        assert topics == {
            "client/received",
            "client/replied",
            "client/view_sent",
            "events",
            "session/ended",
            "wire/arm",
            "views/top",
        }
        messages = list(reader.iter_messages(log_time_order=False))
        assert len(messages) == summary.statistics.message_count
        counts = dict(summary.statistics.channel_message_counts)
        assert sum(counts.values()) == len(messages)
        assert {a.name for a in reader.iter_attachments()} == {
            "script.cell",
            "profile.toml",
            "world.json",
        }
        assert {m.name for m in reader.iter_metadata()} == {"session", "versions", "calibration"}


def test_every_channel_has_a_schema(tmp_path: Path) -> None:
    with a_recording(tmp_path).open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        assert schema.data
        assert (schema.encoding, channel.message_encoding) in (
            ("jsonschema", "json"),
            ("text", "octets"),
        )


def test_the_librarys_indexes_point_at_the_right_bytes(tmp_path: Path) -> None:
    path = a_recording(tmp_path)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    data = path.read_bytes()
    for entry in summary.attachment_indexes:
        assert data[entry.offset] == 9
        assert entry.name.encode() in data[entry.offset : entry.offset + 80]
    for index in summary.metadata_indexes:
        assert data[index.offset] == 12
        assert index.name.encode() in data[index.offset : index.offset + 40]


def _library_messages(path: Path) -> int:
    records: list[McapRecord] = []
    # Record by record, so that what came before the cut is kept. The library's own words for
    # a short read are the end of the file or, in the middle of a number, struct's.
    with path.open("rb") as file, contextlib.suppress(EndOfFile, struct.error):
        for record in StreamReader(file).records:
            records.append(record)
    return sum(isinstance(record, Message) for record in records)


def test_every_prefix_of_a_recording_reads_up_to_its_last_complete_record(tmp_path: Path) -> None:
    path = a_recording(tmp_path / "whole")
    data = path.read_bytes()
    whole = list(SessionRecording.open(path).steps())
    body = data.index(b"script.cell")
    cuts = sorted(
        {*range(0, body, 37), *range(body, len(data), 41), *range(len(data) - 40, len(data))}
    )
    part = tmp_path / "part.mcap"
    opened = 0
    for cut in cuts:
        part.write_bytes(data[:cut])
        recording = _open(part)
        if recording is None:
            assert opened == 0, f"a longer prefix ({cut} bytes) is less readable"
            continue
        opened += 1
        assert not recording.is_finished
        steps = list(recording.steps())
        _assert_is_beginning(steps, whole)
        list(recording.events())
        list(recording.wire())
        list(recording.views())
    assert opened > 100


def _open(path: Path) -> SessionRecording | None:
    try:
        return SessionRecording.open(path)
    except RecordingError:
        return None


def _assert_is_beginning(steps: list[RecordedStep], whole: list[RecordedStep]) -> None:
    complete = [step for step in steps if step.reply is not None]
    assert complete == whole[: len(complete)]
    assert len(steps) - len(complete) <= 1


@pytest.mark.parametrize("missing", [1, 9, 30, 200, 1000])
def test_the_library_reads_as_many_messages_of_a_cut_file_as_we_do(
    tmp_path: Path, missing: int
) -> None:
    path = a_recording(tmp_path)
    cut = tmp_path / "cut.mcap"
    # The summary is cut off first, so that the cut falls among the messages.
    data = path.read_bytes()
    end_of_data = data.rindex(b'"events_lost"')
    cut.write_bytes(data[: end_of_data - missing])
    scan = RecordScan(cut)
    assert len(scan.messages) == _library_messages(cut)
    assert scan.missing_bytes > 0
    assert not SessionRecording.open(cut).is_finished


def test_a_session_that_was_not_closed_is_whole_up_to_its_last_reply(tmp_path: Path) -> None:
    bench = a_bench(tmp_path)
    for number in range(20):
        bench.step(number)
    recording = SessionRecording.open(bench.path)
    assert not recording.is_finished
    assert recording.end_reason is None
    assert recording.missing_bytes == 0
    assert len([s for s in recording.steps() if s.reply is not None]) == 21
    bench.recorder.close("over")
    assert SessionRecording.open(bench.path).is_finished


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not a recording"),
        (b"hello world, this is text", "not a recording"),
        (b"\x89MCAP0\r\n", "ends before the start"),
    ],
)
def test_other_files_are_refused_in_words(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=words):
        SessionRecording.open(path)


def test_another_format_version_is_refused_with_both_versions(tmp_path: Path) -> None:
    path = a_recording(tmp_path)
    data = path.read_bytes()
    mark = b"format\x01\x00\x00\x001"
    assert mark in data
    path.write_bytes(data.replace(mark, mark[:-1] + b"9"))
    with pytest.raises(RecordingError, match="version 9.*version 1"):
        SessionRecording.open(path)


def test_a_file_that_is_not_there_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read"):
        SessionRecording.open(tmp_path / "none.mcap")
