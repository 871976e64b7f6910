"""The folder of recordings: what is there, and which one is meant."""

from __future__ import annotations

import fcntl
import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Literal

import platformdirs

from sessions.recording.errors import RecordingError, RecordingNotFound
from sessions.recording.reader import SessionRecording

RecordingState = Literal["finished", "running", "not finished", "not readable"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingSummary:
    """What a list of recordings says of one.

    Attributes:
        session_id: Name of the session.
        path: Its file.
        state: `running` while a process still writes it, `not finished` when that
            process is gone without having closed it.
        started_utc: Wall time of the start, None when not readable.
        script_name: File name of the script.
        dialect: Dialect of the client.
        seed: Seed of the session.
        lines: How many lines the client sent.
        views: How many different views were kept.
        duration_s: Session time.
        size_bytes: Size of the file.
        note: Why it is not readable, or why the session ended.
    """

    session_id: str
    path: Path
    state: RecordingState
    started_utc: datetime | None = None
    script_name: str = ""
    dialect: str = ""
    seed: int = 0
    lines: int = 0
    views: int = 0
    duration_s: float = 0.0
    size_bytes: int = 0
    note: str = ""


def sessions_folder() -> Path:
    """Return the folder in which recordings are kept; `XDG_DATA_HOME` moves it."""
    return platformdirs.user_data_path("robocell") / "sessions"


def list_recordings(folder: Path) -> list[RecordingSummary]:
    """Return a summary of every recording in a folder, oldest first."""
    return [summarise(path) for path in sorted(folder.glob("*.mcap"))]


def summarise(path: Path) -> RecordingSummary:
    """Return the summary of one recording; one that cannot be read says so."""
    try:
        size = path.stat().st_size
        is_running = _is_locked(path)
        recording = SessionRecording.open(path)
    except (RecordingError, OSError) as error:
        return RecordingSummary(
            session_id=path.stem, path=path, state="not readable", note=str(error)
        )
    state: RecordingState = "finished" if recording.is_finished else "not finished"
    start = recording.start
    return RecordingSummary(
        session_id=start.session_id,
        path=path,
        state="running" if is_running else state,
        started_utc=recording.started_utc,
        script_name=start.script_name,
        dialect=start.dialect,
        seed=start.seed,
        lines=sum(1 for _ in recording.lines()),
        views=len(recording.view_hashes()),
        duration_s=recording.duration_ns / 1e9,
        size_bytes=size,
        note=recording.end_reason or "",
    )


def find_recording(folder: Path, name: str) -> Path:
    """Return the file of a session.

    Args:
        folder: Where recordings are kept.
        name: A session's name, a unique beginning of it, `latest`, or the path of a file.

    Raises:
        RecordingNotFound: There is no such recording, or several are meant.
    """
    as_path = Path(name)
    if as_path.suffix == ".mcap":
        if as_path.is_file():
            return as_path
        raise RecordingNotFound(f"there is no recording {name}")
    paths = sorted(folder.glob("*.mcap"))
    if not paths:
        raise RecordingNotFound(f"there are no recordings in {folder}; `cell demo` makes one")
    if name == "latest":
        return paths[-1]
    matching = [path for path in paths if path.stem.startswith(name)]
    if len(matching) == 1:
        return matching[0]
    exact = [path for path in matching if path.stem == name]
    if exact:
        return exact[0]
    if not matching:
        raise RecordingNotFound(f"no session begins with {name!r}; `cell sessions list` shows all")
    some = ", ".join(path.stem for path in matching[:5])
    raise RecordingNotFound(
        f"{len(matching)} sessions begin with {name!r}: {some}; give more of it"
    )


def _is_locked(path: Path) -> bool:
    """Return whether a process still has the file open for writing."""
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    else:
        return False
    finally:
        os.close(descriptor)
