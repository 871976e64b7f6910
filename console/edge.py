"""Where every error of a command ends: one sentence on stderr and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from console.exits import ConsoleError, Exit


def guarded(run: Callable[[], int]) -> int:
    """Run a command and return its exit code; no error gets past.

    What nobody foresaw is written with its traceback into a file of the state
    folder, and the sentence names the file.
    """
    try:
        code = run()
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        _say("interrupted")
        return Exit.INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output is gone; the interpreter must not complain again at its exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return Exit.BROKEN_PIPE
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else Exit.USAGE
    except Exception as error:  # The one place that catches everything: no traceback is shown.
        known = _known(error)
        if known is not None:
            _say(str(error))
            return known
        _say(f"unexpected {type(error).__name__}; details are in {_write_log(error)}")
        return Exit.ENVIRONMENT


def _known(error: Exception) -> Exit | None:
    """Return the exit code of an error that has a sentence of its own."""
    from calibration.errors import (
        AnswerRefused,
        ArchiveError,
        CalibrationError,
        JournalError,
    )
    from cell.errors import CellError, ProfileError
    from dsl.errors import DslError
    from sessions.errors import CommandRefused, ScriptUnservable, SessionsError

    if isinstance(error, ConsoleError):
        return error.exit
    if isinstance(error, CommandRefused) and error.answer.startswith("UNKNOWN_"):
        return Exit.USAGE  # A goal, environment or action that the server does not have.
    codes: tuple[tuple[type[Exception], Exit], ...] = (
        (ProfileError, Exit.USAGE),
        (ScriptUnservable, Exit.FAILED),
        (DslError, Exit.FAILED),
        (CellError, Exit.ENVIRONMENT),
        (AnswerRefused, Exit.USAGE),
        (ArchiveError, Exit.ENVIRONMENT),
        (JournalError, Exit.ENVIRONMENT),
        (CalibrationError, Exit.FAILED),
        (SessionsError, Exit.ENVIRONMENT),
        (OSError, Exit.ENVIRONMENT),
    )
    return next((code for kind, code in codes if isinstance(error, kind)), None)


def _say(sentence: str) -> None:
    print(f"cell: {sentence}", file=sys.stderr)


def _write_log(error: Exception) -> str:
    from console.places import log_folder

    now = datetime.now(UTC)
    path = log_folder() / f"error-{now:%Y%m%dT%H%M%S}-{os.getpid()}.log"
    text = "".join(traceback.format_exception(error))
    return _write(path, f"{now.isoformat()} {sys.argv}\n{text}")


def _write(path: Path, text: str) -> str:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    except OSError as problem:
        return f"no file ({problem})"
    return str(path)
