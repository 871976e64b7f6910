"""SIGTERM and Ctrl-C handled for a while."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from types import FrameType


@contextmanager
def signals_handled(stop: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Have the first SIGTERM or SIGINT call `stop`, and be as before afterwards.

    Further ones are ignored: one may come while `stop` still runs. `stop` must take no
    lock that the main thread may hold (see `cell.stop`).
    """
    calls = count()

    def once(number: int, frame: FrameType | None) -> None:
        # One step, so that a signal inside this handler cannot come between look and note.
        if next(calls) == 0:
            stop(number, frame)

    numbers = (signal.SIGTERM, signal.SIGINT)
    before = {number: signal.signal(number, once) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
