"""How anybody asks long work to stop: a token that is asked, and a bell that wakes.

Both are fit for signal handlers. A handler runs in the main thread, between any two of its
instructions and also inside another handler: a lock that the main thread holds at that
moment would never be let go, so that nothing here takes one.
"""

from __future__ import annotations

from queue import Empty, SimpleQueue

from cell.errors import Stopped


class StopToken:
    """Asked often by whoever works, set once by whoever wants the work to end."""

    def __init__(self) -> None:
        self._reason: str | None = None

    @property
    def is_set(self) -> bool:
        """Whether a stop was asked for."""
        return self._reason is not None

    def stop(self, reason: str) -> None:
        """Ask for a stop; the first reason given is kept.

        Of two threads that ask in the same instant, either may be the first.
        """
        if self._reason is None:
            self._reason = reason

    def clear(self) -> None:
        """Forget the stop, so that work may start again."""
        self._reason = None

    def check(self) -> None:
        """Return if work may go on.

        Raises:
            Stopped: A stop was asked for; the text holds the reason.
        """
        reason = self._reason
        if reason is not None:
            raise Stopped(reason)


class Bell:
    """Wakes whoever waits; once rung it stays so.

    What `threading.Event` does, but that takes a lock which its waiter holds for moments.
    `queue.SimpleQueue` is documented to be re-entrant.
    """

    def __init__(self) -> None:
        self._rung: SimpleQueue[None] = SimpleQueue()

    def ring(self) -> None:
        """Wake everybody who waits now or later."""
        self._rung.put(None)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Return True once it has been rung, or False after `timeout_s`."""
        try:
            self._rung.get(timeout=timeout_s)
        except Empty:
            return False
        # Put back for the next one who waits.
        self._rung.put(None)
        return True
