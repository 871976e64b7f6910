"""One process at a time has a cell."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from cell.errors import StateError, StillHeld


class CellLock:
    """A lock on a cell's state folder; the kernel frees it when the process dies."""

    def __init__(self, folder: Path) -> None:
        """Take the lock.

        Raises:
            StillHeld: Another process has it; the text names the process.
            StateError: There can be no lock in the folder.
        """
        self._path = folder / "lock"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("a+", encoding="ascii", errors="replace")
        except OSError as error:
            raise _unusable(folder, error) from error
        try:
            self._take(folder)
        except BaseException:
            self._file.close()
            raise

    def _take(self, folder: Path) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            self._file.seek(0)
            holder = self._file.read().strip() or "unknown"
            raise StillHeld(
                f"the cell is in use by process {holder}; stop that one first"
            ) from error
        except OSError as error:
            raise _unusable(folder, error) from error
        # The lock holds without its text, which only names the process.
        with suppress(OSError):
            self._file.truncate(0)
            self._file.write(f"{os.getpid()}\n")
            self._file.flush()

    def release(self) -> None:
        """Give the lock back."""
        # Closing writes what is left of the text, and frees the lock even where that fails.
        with suppress(OSError):
            self._file.close()


def _unusable(folder: Path, error: OSError) -> StateError:
    """Return what is wrong with a state folder, as a sentence that says what to do."""
    return StateError(
        f"the state folder {folder} cannot be used ({error.strerror or error}); give it to the "
        "user who runs the cell, move away a file that has its name, or set XDG_STATE_HOME to "
        "another folder"
    )
