"""Calls something between any two lines of Python that a piece of work runs, as signals may."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from types import FrameType

_LONG_S = 20.0


def ends_although_interrupted(work: Callable[[], object], interrupt: Callable[[], object]) -> bool:
    """Run work, interrupted at every line in all it calls; return False if it hangs."""

    def trace(frame: FrameType, event: str, argument: object) -> object:
        interrupt()
        return trace

    def run() -> None:
        sys.settrace(trace)  # type: ignore[arg-type]
        try:
            work()
        finally:
            sys.settrace(None)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(_LONG_S)
    return not thread.is_alive()
