"""Programs as the controller's editor takes them: numbered lines, joined for one request."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from cell.drivers.melfa_r3.codec import GarbledMessage, UnsendableRequest

LINE_SEPARATOR = "\x0b"
"""Joins the lines of one EMDAT (a vertical tab)."""
MAX_EDIT_PAYLOAD = 246
"""Most characters of lines in one EMDAT, as RoboDK's and other drivers keep to."""
MAX_PROGRAM_LINES = 2000
"""Most lines of a program here; the controller's own limit is its memory."""
LINE_STEP = 10

_NAME = re.compile(r"[A-Z0-9][A-Z0-9_]{0,11}", re.ASCII)
_LINE = re.compile(r"\s*(\d{1,5})\s+(\S.*?)\s*", re.ASCII)


class GarbledLine(GarbledMessage):
    """Text that is no line of a program."""


def is_program_name(name: str) -> bool:
    """Return whether a program may have this name: 12 letters, digits and underscores at most."""
    return _NAME.fullmatch(name) is not None


def parse_line(text: str) -> tuple[int, str]:
    """Return number and statement of `<number> <statement>`.

    Raises:
        GarbledLine: The text is no such line.
    """
    found = _LINE.fullmatch(text)
    if found is None:
        raise GarbledLine(f"{text[:80]!r} is no numbered line of a program")
    return int(found[1]), found[2]


def print_lines(statements: Sequence[str]) -> list[str]:
    """Return statements as numbered lines, in steps of ten.

    Raises:
        UnsendableRequest: One is empty, too long, or holds what cannot be sent.
    """
    lines = []
    for place, statement in enumerate(statements, 1):
        line = f"{LINE_STEP * place} {statement.strip()}"
        if not statement.strip() or len(line) > MAX_EDIT_PAYLOAD:
            raise UnsendableRequest(
                f"line {place} of the program has {len(statement)} characters; "
                f"1 to {MAX_EDIT_PAYLOAD - 6} are possible"
            )
        if not (line.isascii() and line.isprintable()):
            raise UnsendableRequest(f"line {place} of the program cannot be sent: {statement!r}")
        lines.append(line)
    return lines


def join_lines(lines: Iterable[str]) -> Iterator[str]:
    """Yield as many lines at a time as one EMDAT takes, joined."""
    packed = ""
    for line in lines:
        longer = f"{packed}{LINE_SEPARATOR}{line}" if packed else line
        if len(longer) > MAX_EDIT_PAYLOAD:
            yield packed
            longer = line
        packed = longer
    if packed:
        yield packed


def split_lines(payload: str) -> list[str]:
    """Return the lines of one EMDAT."""
    return [line for line in payload.split(LINE_SEPARATOR) if line.strip()]
