"""Diagnostics as text for people: place, source line, caret, sentence, hint."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

from dsl.diagnostics import Diagnostic

_WIDTH = 100
_TAB = 4
_RED, _YELLOW, _CYAN, _BOLD, _PLAIN = "\x1b[31m", "\x1b[33m", "\x1b[36m", "\x1b[1m", "\x1b[0m"


def render_diagnostics(
    diagnostics: Sequence[Diagnostic], text: str, name: str, colour: bool = False
) -> str:
    """Show diagnostics with the source they are about, and count them at the end.

    Args:
        diagnostics: The findings.
        text: The script they were found in.
        name: Name of the script.
        colour: Whether to use the colours of a terminal.

    Returns:
        The text, without a line break at its end.
    """
    lines = text.removeprefix("\ufeff").split("\n")
    shown = [_render(diagnostic, lines, name, colour) for diagnostic in diagnostics]
    errors = sum(d.severity == "error" for d in diagnostics)
    shown.append(f"{_counted(errors, 'error')}, {_counted(len(diagnostics) - errors, 'warning')}")
    return "\n\n".join(shown)


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _render(diagnostic: Diagnostic, lines: Sequence[str], name: str, colour: bool) -> str:
    span = diagnostic.span
    source = lines[span.line - 1] if span.line <= len(lines) else ""
    end = span.end_column if span.end_line == span.line else len(source) + 1
    before, marked, after = _cut(source, span.column - 1, max(end - 1, span.column))
    number = str(span.line)
    margin = " " * len(number)
    tint = (_RED if diagnostic.severity == "error" else _YELLOW) if colour else ""
    bold, edge, plain = (_BOLD, _CYAN, _PLAIN) if colour else ("", "", "")
    caret = " " * _cells(before) + "^" * max(_cells(marked), 1)
    rows = [
        f"{tint}{diagnostic.severity}[{diagnostic.code}]{plain}{bold}: {diagnostic.message}{plain}",
        f"{margin} {edge}-->{plain} {name}:{span.line}:{span.column}",
        f"{margin}  {edge}|{plain}",
        f" {number} {edge}|{plain} {before}{marked}{after}",
        f"{margin}  {edge}|{plain} {tint}{caret}{plain}",
    ]
    if diagnostic.hint:
        rows.append(f"{margin}  {edge}={plain} hint: {diagnostic.hint}")
    return "\n".join(row.rstrip() for row in rows)


def _cut(source: str, start: int, end: int) -> tuple[str, str, str]:
    """Return what stands before, in and after a stretch of a line, cut to a screen's width."""
    before, marked, after = source[:start], source[start:end], source[end:]
    if len(source) > _WIDTH:
        before = before if len(before) <= _WIDTH // 2 else "…" + before[-_WIDTH // 2 :]
        room = max(_WIDTH - len(before), _WIDTH // 2)
        marked = marked if len(marked) <= room else marked[:room] + "…"
        room -= min(len(marked), room)
        after = after if len(after) <= room else after[:room] + "…"
    return _showable(before), _showable(marked), _showable(after)


def _showable(text: str) -> str:
    """Return text without anything that moves a terminal's cursor."""
    text = text.replace("\t", " " * _TAB).replace("\r", "")
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _cells(text: str) -> int:
    """Return how many columns of a terminal a text takes."""
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "FW" else 1
        for c in text
    )
