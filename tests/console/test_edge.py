from __future__ import annotations

from pathlib import Path

import pytest

from cell.errors import DeviceError, MotionRefused, ProfileError, StillHeld
from console.edge import guarded
from console.exits import ConsoleError, Exit
from dsl.errors import UnknownName
from sessions.errors import CommandRefused, ConnectionLost, ScriptUnservable
from sessions.recording import RecordingError

ERRORS: list[tuple[Exception, Exit]] = [
    (ConsoleError("call it otherwise"), Exit.USAGE),
    (ConsoleError("it failed", Exit.FAILED), Exit.FAILED),
    (ProfileError("a field is wrong"), Exit.USAGE),
    (ScriptUnservable("no such camera"), Exit.FAILED),
    (UnknownName("goal", "x", ()), Exit.FAILED),
    (DeviceError("arm", "is silent"), Exit.ENVIRONMENT),
    (StillHeld("another process has the cell"), Exit.ENVIRONMENT),
    (
        MotionRefused("J5", value=120, limit=100, nearest=100, unit="deg", why="is beyond"),
        Exit.ENVIRONMENT,
    ),
    (CommandRefused("INITIALIZE_TASK X Y", "UNKNOWN_GOAL X"), Exit.USAGE),
    (CommandRefused("END_TASK_SETUP", "ERROR 'The cell failed'"), Exit.ENVIRONMENT),
    (ConnectionLost("the server is gone"), Exit.ENVIRONMENT),
    (RecordingError("it cannot be written"), Exit.ENVIRONMENT),
    (PermissionError(13, "Permission denied"), Exit.ENVIRONMENT),
]


@pytest.mark.parametrize(("error", "code"), ERRORS, ids=lambda value: type(value).__name__)
def test_a_known_error_is_its_own_sentence(
    error: Exception, code: Exit, capsys: pytest.CaptureFixture[str]
) -> None:
    def run() -> int:
        raise error

    assert guarded(run) == code
    assert capsys.readouterr().err == f"cell: {error}\n"


def test_an_unexpected_error_is_a_sentence_and_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def run() -> int:
        raise ZeroDivisionError("the very cause")

    assert guarded(run) == Exit.ENVIRONMENT
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "ZeroDivisionError" in said
    (log,) = (tmp_path / "robocell" / "logs").iterdir()
    assert str(log) in said
    assert "the very cause" in log.read_text("utf-8")
    assert "Traceback" in log.read_text("utf-8")


def test_a_state_folder_that_cannot_be_written_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robocell").write_text("a file where a folder belongs", "utf-8")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    def run() -> int:
        raise ZeroDivisionError

    assert guarded(run) == Exit.ENVIRONMENT
    assert "no file" in capsys.readouterr().err


def test_interrupts_end_with_130(capsys: pytest.CaptureFixture[str]) -> None:
    def run() -> int:
        raise KeyboardInterrupt

    assert guarded(run) == 130
    assert capsys.readouterr().err == "cell: interrupted\n"
