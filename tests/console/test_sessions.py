from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from console.cli import main
from tests.sessions.recording.samples import a_bench, a_frame, a_recording


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path / "robocell" / "sessions"


def test_an_empty_folder_is_no_error(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sessions", "list"]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert "cell demo" in told.err
    assert main(["sessions", "list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_the_list_marks_what_was_not_finished(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = a_recording(folder).read_bytes()
    (folder / "20260102T030406-cut.mcap").write_bytes(whole[:-400])
    assert main(["sessions", "list", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["state"] for one in told] == ["finished", "not finished"]
    assert main(["sessions", "list"]) == 0
    assert "not finished" in capsys.readouterr().out


def test_a_session_is_shown_line_by_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a_recording(folder)
    assert main(["sessions", "show", "latest", "--events", "--wire", "arm"]) == 0
    shown = capsys.readouterr().out
    assert "> ACTION RIGHT" in shown
    assert "< REWARD 0" in shown
    assert "MotionFinished" in shown
    assert "-> arm b'1;1;EXECMVS P1\\r'" in shown
    assert "view 1" in shown


def test_a_session_is_data_for_programs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a_recording(folder)
    assert main(["sessions", "show", "2026", "--json", "--events", "--wire", "arm"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["seed"] == 42
    assert told["steps"][0] == {
        "number": 1,
        "time_ns": 0,
        "line": "STATUS",
        "reply": "READY\n",
        "view": None,
        "data_bytes": 0,
    }
    assert len(told["wire"]) == 24
    assert {event["type"] for event in told["events"]} == {"MotionFinished", "StepTaken"}


def test_lines_of_a_session_cannot_steer_the_terminal(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = a_bench(folder)
    bench.recorder.received(b"\x1b[2J\xff\x07")
    bench.recorder.close("over")
    assert main(["sessions", "show"]) == 0
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    assert "\\x1b[2J\\xff\\x07" in shown


def test_pictures_are_written_as_png(folder: Path, tmp_path: Path) -> None:
    a_recording(folder, "lossless")
    out = tmp_path / "out"
    assert main(["sessions", "views", "latest", "--out", str(out)]) == 0
    written = sorted(out.iterdir())
    assert [path.name for path in written] == ["0001-step0003-top.png", "0002-step0006-top.png"]
    picture = cv2.imread(str(written[0]))
    assert picture is not None
    assert np.array_equal(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), a_frame(1).pixels)


def test_an_ambiguous_name_is_wrong_usage(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a_recording(folder)
    bench = a_bench(folder, session_id="20260102T999999-zz")
    bench.recorder.close("over")
    assert main(["sessions", "show", "2026"]) == 2
    assert "2 sessions begin" in capsys.readouterr().err
