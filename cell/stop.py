"""A token by which anybody can ask a long operation to stop."""

from __future__ import annotations

import threading

from cell.errors import Stopped


class StopToken:
    """Asked often by whoever works, set once by whoever wants the work to end."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._reason: str | None = None

    @property
    def is_set(self) -> bool:
        """Whether a stop was asked for."""
        return self._reason is not None

    def stop(self, reason: str) -> None:
        """Ask for a stop; the first reason given is kept."""
        with self._lock:
            if self._reason is None:
                self._reason = reason

    def clear(self) -> None:
        """Forget the stop, so that work may start again."""
        with self._lock:
            self._reason = None

    def check(self) -> None:
        """Return if work may go on.

        Raises:
            Stopped: A stop was asked for; the text holds the reason.
        """
        reason = self._reason
        if reason is not None:
            raise Stopped(reason)
