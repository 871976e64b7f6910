from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from sessions.recording import (
    RecordingError,
    find_recording,
    list_recordings,
    new_session_id,
    sessions_folder,
)
from tests.sessions.recording.samples import STARTED, a_bench, a_recording


def test_the_list_tells_finished_running_and_unreadable_apart(tmp_path: Path) -> None:
    a_recording(tmp_path)
    running = a_bench(tmp_path, session_id="20260102T030406-000001")
    running.step(1)
    whole = (tmp_path / "20260102T030405-abcdef.mcap").read_bytes()
    (tmp_path / "20260102T030407-000002.mcap").write_bytes(whole[:-500])
    (tmp_path / "20260102T030408-000003.mcap").write_bytes(b"nothing")
    summaries = list_recordings(tmp_path)
    assert [s.state for s in summaries] == ["finished", "running", "not finished", "not readable"]
    assert summaries[0].started_utc == STARTED
    assert (summaries[0].lines, summaries[0].views, summaries[0].seed) == (8, 2, 42)
    assert summaries[0].note == "the client said DONE"
    running.recorder.close("over")


def test_a_session_is_found_by_a_unique_beginning_or_as_the_latest(tmp_path: Path) -> None:
    for name in ("20260102T030405-aa", "20260102T030406-ab", "20260103T000000-ac"):
        (tmp_path / f"{name}.mcap").write_bytes(b"")
    assert find_recording(tmp_path, "20260103").stem == "20260103T000000-ac"
    assert find_recording(tmp_path, "latest").stem == "20260103T000000-ac"
    assert find_recording(tmp_path, str(tmp_path / "20260102T030405-aa.mcap")).is_file()
    with pytest.raises(RecordingError, match="2 sessions begin with '20260102'"):
        find_recording(tmp_path, "20260102")
    with pytest.raises(RecordingError, match="no session begins with 'x'"):
        find_recording(tmp_path, "x")
    with pytest.raises(RecordingError, match="there is no recording"):
        find_recording(tmp_path, "gone.mcap")


def test_an_empty_folder_says_how_to_fill_it(tmp_path: Path) -> None:
    assert list_recordings(tmp_path / "none") == []
    with pytest.raises(RecordingError, match="cell demo"):
        find_recording(tmp_path / "none", "latest")


def test_the_folder_follows_the_platforms_data_home(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert sessions_folder() == tmp_path / "robocell" / "sessions"


def test_session_names_sort_by_time_and_differ() -> None:
    moment = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
    names = [new_session_id(moment + timedelta(seconds=n)) for n in range(3)]
    assert names == sorted(names)
    assert names[0].startswith("20260102T030405-")
    assert new_session_id(moment) != new_session_id(moment)
