"""Files that are whole or not there at all, and folders that one program writes at a time."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Final

from calibration.errors import ArchiveError
from cell.clock import Clock

_WAIT_S: Final = 10.0
_POLL_S: Final = 0.05


def write_once(path: Path, data: bytes) -> None:
    """Write a file whose name says what is in it, unless it is there.

    Raises:
        OSError: It cannot be written.
    """
    if not path.exists():
        replace(path, data)


def replace(path: Path, data: bytes) -> None:
    """Write a file so that at any moment it has the old content or the new.

    Raises:
        OSError: It cannot be written; the old content is still there.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with fresh.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(fresh, path)
    except OSError:
        with suppress(OSError):
            fresh.unlink()
        raise
    _settle(path.parent)


def _settle(folder: Path) -> None:
    """Have the folder's own entry written; some file systems cannot, and need not."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


@contextmanager
def only_writer(folder: Path, clock: Clock) -> Iterator[None]:
    """Be the only program that writes in a folder; the kernel frees it when the program dies.

    Args:
        folder: The folder; made if it is not there.
        clock: Tells how long the others have been waited for.

    Raises:
        ArchiveError: Another program writes for more than ten seconds.
        OSError: The folder cannot be written.
    """
    file = _opened(folder)
    try:
        until_s = clock.now_s() + _WAIT_S
        while not _taken(file):
            if clock.now_s() >= until_s:
                raise ArchiveError(
                    f"{folder} is being written by process {_holder(file)}; nothing was changed, "
                    "try again when that one has ended"
                )
            clock.sleep(_POLL_S)
        yield
    finally:
        file.close()


@contextmanager
def sole_user(folder: Path, what: str) -> Iterator[None]:
    """Have a folder to oneself for long, or not at all.

    Args:
        folder: The folder; made if it is not there.
        what: What goes on in it, for the message.

    Raises:
        ArchiveError: Another program has it, or the folder cannot be written.
    """
    try:
        file = _opened(folder)
    except OSError as error:
        raise ArchiveError(
            f"{folder} cannot be written, and so {what} cannot be noted there: "
            f"{error.strerror or error}; nothing was begun"
        ) from error
    try:
        if not _taken(file):
            raise ArchiveError(
                f"{what} is already going on, in process {_holder(file)}; stop that one first"
            )
        yield
    finally:
        file.close()


def _opened(folder: Path) -> IO[str]:
    folder.mkdir(parents=True, exist_ok=True)
    return (folder / ".lock").open("a+", encoding="ascii", errors="replace")


def _taken(file: IO[str]) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    # The lock holds without its text, which only names the process.
    with suppress(OSError):
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
    return True


def _holder(file: IO[str]) -> str:
    file.seek(0)
    return file.read().strip() or "unknown"
