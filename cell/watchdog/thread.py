"""The watchdog in a thread of its own, beside the server."""

from __future__ import annotations

import logging
import threading
import traceback
from pathlib import PurePath

from cell.errors import CellError
from cell.watchdog.watchdog import Watchdog

_log = logging.getLogger(__name__)

_LONGEST_NAP_S = 3600.0
_AFTER_MISHAP_S = 60.0


class WatchdogThread:
    """Runs a watchdog until it is stopped; what goes wrong in it is logged and tried again."""

    def __init__(self, watchdog: Watchdog) -> None:
        self._watchdog = watchdog
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watchdog", daemon=True)

    def start(self) -> None:
        """Begin; the first round is due after the profile's interval."""
        self._thread.start()

    def stop(self, timeout_s: float = 30.0) -> bool:
        """Stop after the test under way; return whether the thread has ended in time."""
        self._stop.set()
        self._watchdog.stop()
        if self._thread.is_alive():
            self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        wait_s = 0.0
        while not self._stop.wait(min(wait_s, _LONGEST_NAP_S)):
            try:
                wait_s = self._watchdog.step()
            except CellError as error:
                _log.error("watchdog: %s", error)
                wait_s = _AFTER_MISHAP_S
            except Exception as error:  # The thread's edge: what nobody foresaw must not end it.
                frame = traceback.extract_tb(error.__traceback__)[-1]
                place = f"{PurePath(frame.filename).name}:{frame.lineno}"
                _log.error("watchdog: %s at %s: %s", type(error).__name__, place, error)
                wait_s = _AFTER_MISHAP_S
