"""Data to stdout, talk to stderr, colour only where somebody looks."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from typing import Literal, TextIO

Style = Literal["bold", "dim", "red", "green", "yellow", "cyan"]

_CODES: dict[Style, str] = {
    "bold": "1",
    "dim": "2",
    "red": "31",
    "green": "32",
    "yellow": "33",
    "cyan": "36",
}


def has_colour(stream: TextIO) -> bool:
    """Return whether a stream is a terminal that shall show colours.

    `NO_COLOR` set to anything turns them off (https://no-color.org).
    """
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def styled(text: str, style: Style, stream: TextIO | None = None) -> str:
    """Return text in a style if the stream (stdout unless given) shows colours."""
    if not has_colour(sys.stdout if stream is None else stream):
        return text
    return f"\x1b[{_CODES[style]}m{text}\x1b[0m"


def say(text: str, style: Style | None = None) -> None:
    """Tell the person something; it is not data."""
    print(text if style is None else styled(text, style, sys.stderr), file=sys.stderr, flush=True)


def put(text: str) -> None:
    """Write data."""
    print(text, flush=True)


def put_json(value: object) -> None:
    """Write data as JSON; what is neither text nor number becomes text."""
    put(json.dumps(value, indent=2, default=str))


def put_table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write data as a table; figures are set to the right."""
    widths = [max(len(row[i]) for row in (headings, *rows)) for i in range(len(headings))]
    put(styled(_table_line(headings, widths), "bold"))
    for row in rows:
        put(_table_line(row, widths))


def _table_line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = [
        cell.rjust(width) if cell[:1].isdigit() and cell[-1:].isdigit() else cell.ljust(width)
        for cell, width in zip(cells, widths, strict=True)
    ]
    return "  ".join(padded).rstrip()
