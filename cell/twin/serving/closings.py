"""Tells when a program closes a file, by Linux's inotify, which Python does not offer itself."""

from __future__ import annotations

import contextlib
import ctypes
import os

_IN_CLOSE = 0x18
_EVENTS_BYTES = 4096


class Closings:
    """Watches one file; becomes readable when a program closes it.

    Where the system has no inotify it watches nothing and `fileno` is negative.
    """

    def __init__(self, path: str) -> None:
        self._fd = -1
        library = ctypes.CDLL(None, use_errno=True)
        try:
            begin, watch = library.inotify_init1, library.inotify_add_watch
        except AttributeError:
            return
        fd = int(begin(os.O_NONBLOCK | os.O_CLOEXEC))
        if fd < 0:
            return
        if watch(fd, os.fsencode(path), _IN_CLOSE) < 0:
            os.close(fd)
            return
        self._fd = fd

    def fileno(self) -> int:
        """Return the descriptor to wait on, negative for none."""
        return self._fd

    def happened(self) -> bool:
        """Return whether the file was closed since this was asked last."""
        if self._fd >= 0:
            with contextlib.suppress(BlockingIOError):
                return bool(os.read(self._fd, _EVENTS_BYTES))
        return False

    def close(self) -> None:
        """Watch no more; closing twice is harmless."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
