"""The edge where failures become one log line and one short sentence.

`attempt` is the one place that catches every exception: a session must outlive
whatever a device, a script or a disk does to it.
"""

from __future__ import annotations

import re
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import TypeVar

from cell.errors import (
    CellError,
    DeviceError,
    GripFailed,
    LedgerError,
    LinkError,
    MotionRefused,
    ProfileError,
    ResumeRefused,
    SafeStop,
    StillHeld,
    Stopped,
    StoreError,
    UnreachablePose,
    VisionError,
)
from dsl.errors import DslError
from sessions.errors import SessionsError

MAX_SENTENCE = 200
"""The most characters of an error's text that a client gets."""

_R = TypeVar("_R")
_OWN_WORDS = (
    DeviceError,
    GripFailed,
    MotionRefused,
    ResumeRefused,
    StoreError,
    UnreachablePose,
    DslError,
)
_SENTENCES: tuple[tuple[type[Exception], str], ...] = (
    (LinkError, "The connection to a device failed"),
    (LedgerError, "The ledger of blocks cannot be used"),
    (ProfileError, "The profile of the cell is wrong"),
    (VisionError, "A picture of the cell cannot be used"),
    (StillHeld, "Another program has the cell"),
    (Stopped, "The cell was stopped"),
    (CellError, "The cell failed"),
)
_PATH = re.compile(r"(?<![\w.])(?:[A-Za-z]:[\\/]|\.{0,2}/|~/|\\\\)[^\s'\",;)]*")


@dataclass(frozen=True, slots=True)
class Mishap:
    """A failure, told twice.

    Attributes:
        sentence: For the client: short, without paths.
        detail: For the log, one line.
        is_expected: Whether it is a failure that the cell or script knows of, after
            which the session can go on.
        ends_task: Whether the task is over, because nothing may move before a new one.
    """

    sentence: str
    detail: str
    is_expected: bool
    ends_task: bool = False


def attempt(work: Callable[[], _R]) -> _R | Mishap:
    """Do some work and return its result, or what went wrong with it."""
    try:
        return work()
    except Exception as error:
        return _mishap(error)


def _mishap(error: Exception) -> Mishap:
    if isinstance(error, SafeStop):
        return replace(_mishap(error.cause), ends_task=True)
    words = " ".join(str(error).split())
    if isinstance(error, _OWN_WORDS):
        return Mishap(_shorten(words), words, is_expected=True)
    for kind, sentence in _SENTENCES:
        if isinstance(error, kind):
            return Mishap(sentence, words, is_expected=True)
    if isinstance(error, SessionsError):
        return Mishap("The session cannot go on", words, is_expected=False)
    return Mishap("Internal error", f"{_place(error)}: {words}", is_expected=False)


def _shorten(words: str) -> str:
    sentence = _PATH.sub("...", words)
    return sentence if len(sentence) <= MAX_SENTENCE else sentence[: MAX_SENTENCE - 3] + "..."


def _place(error: Exception) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    where = f" at {PurePath(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}{where}"
