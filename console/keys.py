"""Single keys from a terminal, and the terminal as it was afterwards."""

from __future__ import annotations

import os
import signal
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_SEQUENCES = {
    b"\x1b[A": "up",
    b"\x1b[B": "down",
    b"\x1b[C": "right",
    b"\x1b[D": "left",
    b"\x1bOA": "up",
    b"\x1bOB": "down",
    b"\x1bOC": "right",
    b"\x1bOD": "left",
    b"\x03": "q",
    b"\x04": "q",
    b"\x1b": "q",
}
_HIDE_CURSOR, _SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


def split_keys(data: bytes) -> list[str]:
    """Return the keys in what a terminal sent: arrows by name, others as they are."""
    keys: list[str] = []
    rest = data
    while rest:
        for size in (3, 1):
            if rest[:size] in _SEQUENCES:
                keys.append(_SEQUENCES[rest[:size]])
                rest = rest[size:]
                break
        else:
            keys.append(rest[:1].decode("latin-1").lower())
            rest = rest[1:]
    return keys


@contextmanager
def raw_terminal(descriptor: int) -> Iterator[None]:
    """Let keys come one by one and unechoed; the terminal is put back whatever happens.

    A SIGTERM ends the block like an exit, so that the terminal is put back then, too.
    """
    before = termios.tcgetattr(descriptor)
    handler = signal.signal(signal.SIGTERM, _leave)
    try:
        tty.setcbreak(descriptor)
        sys.stderr.write(_HIDE_CURSOR)
        sys.stderr.flush()
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
        signal.signal(signal.SIGTERM, handler)
        sys.stderr.write(_SHOW_CURSOR)
        sys.stderr.flush()


def read_keys(descriptor: int) -> Iterator[str]:
    """Yield keys until the terminal is gone."""
    while data := os.read(descriptor, 64):
        yield from split_keys(data)


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(128 + number)
