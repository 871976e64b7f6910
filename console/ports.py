"""The serial ports of this computer, offered to whoever sits at a terminal."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import NamedTuple

from console.output import say


class OfferedPort(NamedTuple):
    """A serial port of this computer.

    Attributes:
        name: What a profile calls it.
        what: What the system knows of it.
    """

    name: str
    what: str


def ports_there_are() -> list[OfferedPort]:
    """Return the serial ports that the system has, by name."""
    from serial.tools import list_ports

    found = sorted(list_ports.comports(), key=lambda port: port.device)
    return [OfferedPort(port.device, port.description or "") for port in found]


def is_asked() -> bool:
    """Return whether somebody sits there who can be asked."""
    return sys.stdin.isatty() and sys.stderr.isatty()


def choose_ports(devices: Sequence[str], offered: Sequence[OfferedPort]) -> dict[str, str]:
    """Ask for the port of each device; whoever just presses Enter leaves it as it is."""
    chosen: dict[str, str] = {}
    for device in devices:
        left = [port for port in offered if port.name not in chosen.values()]
        if not left:
            break
        say(f"Which port has the {device}?", "bold")
        for number, port in enumerate(left, 1):
            say(f"  {number}  {port.name}  {port.what}")
        answer = _ask(f"1 to {len(left)}, or Enter for none of them: ", len(left))
        if answer is not None:
            chosen[device] = left[answer - 1].name
    return chosen


def _ask(question: str, most: int) -> int | None:
    while True:
        print(question, end="", file=sys.stderr, flush=True)
        answer = sys.stdin.readline()
        word = answer.strip()
        if not word:
            return None  # Enter, or the end of the input.
        if word.isascii() and word.isdigit() and 1 <= int(word) <= most:
            return int(word)
        say(f"{word!r} is none of them")
