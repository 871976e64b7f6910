"""A token by which anybody can ask a long operation to stop."""

from __future__ import annotations

import threading

from cell.errors import Stopped


class StopToken:
    """Asked often by whoever works, set once by whoever wants the work to end."""

    def __init__(self) -> None:
        self._event = threading.Event()
        self._reason = ""

    @property
    def is_set(self) -> bool:
        """Whether a stop was asked for."""
        return self._event.is_set()

    def stop(self, reason: str) -> None:
        """Ask for a stop; the first reason given is kept."""
        if not self._event.is_set():
            self._reason = reason
            self._event.set()

    def clear(self) -> None:
        """Forget the stop, so that work may start again."""
        self._reason = ""
        self._event.clear()

    def check(self) -> None:
        """Return if work may go on.

        Raises:
            Stopped: A stop was asked for; the text holds the reason.
        """
        if self._event.is_set():
            raise Stopped(self._reason)
