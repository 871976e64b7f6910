"""What may go wrong with a web camera, done to the emulated one on purpose."""

from __future__ import annotations

import enum
import threading
from collections import Counter


class WebCameraFault(enum.Enum):
    """One way in which a request fails."""

    UNAUTHORISED = "the user is refused (401)"
    FORBIDDEN = "the user has too few rights (403)"
    BUSY = "too many viewers (503)"
    ERROR_TEXT = "a complaint with status 200"
    SILENT = "the request is not answered"
    SLOW = "the picture stops in its middle and goes on when the fault is cleared"
    BROKEN_JPEG = "the picture's bytes are none"
    CUT_OFF = "the picture ends in its middle, and the connection with it"
    DROPPED = "the connection ends before anything is said"


LASTING = 1_000_000_000


class Faults:
    """Which faults wait to happen. Used by all threads of the server."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._left: Counter[WebCameraFault] = Counter()
        self._released = threading.Event()

    def inject(self, fault: WebCameraFault, times: int = LASTING) -> None:
        """Let a fault happen to the next `times` requests or pictures; to all unless given."""
        with self._lock:
            self._left[fault] = times
            self._released.clear()

    def clear(self) -> None:
        """End all faults; who is held goes on."""
        with self._lock:
            self._left.clear()
            self._released.set()

    def takes(self, fault: WebCameraFault) -> bool:
        """Return whether a fault shall happen now, and count it."""
        with self._lock:
            if self._left[fault] <= 0:
                return False
            self._left[fault] -= 1
            return True

    def hold(self, timeout_s: float) -> None:
        """Return when faults are cleared, at the latest after `timeout_s` of real time."""
        self._released.wait(timeout_s)
