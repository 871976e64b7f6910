"""One process at a time has a cell."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from cell.errors import StillHeld


class CellLock:
    """A lock on a cell's state folder; the kernel frees it when the process dies."""

    def __init__(self, folder: Path) -> None:
        """Take the lock.

        Raises:
            StillHeld: Another process has it; the text names the process.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / "lock"
        self._file = self._path.open("a+", encoding="ascii")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.seek(0)
            holder = self._file.read().strip() or "unknown"
            self._file.close()
            raise StillHeld(
                f"the cell is in use by process {holder}; stop that one first"
            ) from error
        self._file.truncate(0)
        self._file.write(f"{os.getpid()}\n")
        self._file.flush()

    def release(self) -> None:
        """Give the lock back."""
        self._file.close()
