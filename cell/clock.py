"""Time as an argument: the same cell in real time or as fast as it can."""

from __future__ import annotations

import threading
import time
from typing import Protocol


class Clock(Protocol):
    """A source of time that can also be waited on."""

    def now_s(self) -> float:
        """Return seconds since the clock's own start; never runs backwards."""

    def sleep(self, duration_s: float) -> None:
        """Let `duration_s` seconds pass; zero or less returns at once."""


class SystemClock:
    """Real time: `sleep` really waits."""

    def __init__(self) -> None:
        self._start_s = time.monotonic()

    def now_s(self) -> float:
        """Return seconds since the clock was made."""
        return time.monotonic() - self._start_s

    def sleep(self, duration_s: float) -> None:
        """Wait for `duration_s` seconds."""
        if duration_s > 0:
            time.sleep(duration_s)


class SimulatedClock:
    """Simulated time: `sleep` moves the time on and returns at once.

    Time passes only where somebody sleeps, so a run is the same every time and
    takes no longer than its arithmetic.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._now_s = start_s
        self._lock = threading.Lock()

    def now_s(self) -> float:
        """Return the simulated seconds passed so far."""
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Move the time on by `duration_s` seconds."""
        if duration_s > 0:
            with self._lock:
                self._now_s += duration_s
