"""What a check has to say about a profile, and how it is shown: source line and caret."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from cell.errors import ProfileError
from cell.profile.toml_places import KeyPath, Place

Severity = Literal["error", "warning"]

_WIDTH = 100
_USERINFO = re.compile(r"""(://)([^/@\s"']+)(?=@)""")
_RED, _YELLOW, _CYAN, _BOLD, _PLAIN = "\x1b[31m", "\x1b[33m", "\x1b[36m", "\x1b[1m", "\x1b[0m"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One finding about a profile.

    Attributes:
        severity: Whether it keeps the profile from being used.
        field: Which field it is about, such as `arm.serial.baud`; empty for the whole file.
        place: Where it is.
        message: What is wrong and what is allowed, in a sentence.
        hint: What to do about it, or an empty string.
        other: Where the field stands that it does not go together with, if there is one.
    """

    severity: Severity
    field: str
    place: Place
    message: str
    hint: str = ""
    other: Place | None = None

    def as_json(self) -> dict[str, object]:
        """Return the finding as data."""
        return {
            "severity": self.severity,
            "field": self.field,
            "line": self.place.line,
            "column": self.place.column,
            "message": without_passwords(self.message),
            "hint": self.hint,
            "other_line": None if self.other is None else self.other.line,
        }


class InvalidProfile(ProfileError):
    """A profile has mistakes; the text shows each where it stands.

    Attributes:
        source: Name of the file.
        text: What is in it.
        findings: The mistakes, in the order of the text.
    """

    def __init__(self, source: str, text: str, findings: Sequence[Finding]) -> None:
        self.source = source
        self.text = text
        self.findings = tuple(findings)
        shown = render_findings(findings, text, source)
        super().__init__(f"the profile {source} cannot be used\n\n{shown}")


def dotted(path: KeyPath) -> str:
    """Return a path as people write it: `boxes[0].min_mm[2]`."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{_quoted(part)}" for part in path]
    return "".join(parts).removeprefix(".")


def render_findings(
    findings: Sequence[Finding], text: str, source: str, *, colour: bool = False
) -> str:
    """Show findings with the lines they are about, and count them at the end.

    Args:
        findings: The findings.
        text: The profile they were found in.
        source: Name of the file.
        colour: Whether to use the colours of a terminal.

    Returns:
        The text, without a line break at its end.
    """
    lines = without_passwords(text).split("\n")
    shown = [_render(finding, lines, source, colour=colour) for finding in findings]
    errors = sum(finding.severity == "error" for finding in findings)
    shown.append(f"{_counted(errors, 'error')}, {_counted(len(findings) - errors, 'warning')}")
    return "\n\n".join(shown)


def without_passwords(text: str) -> str:
    """Return a text whose addresses keep as many characters, but no name or password."""
    return _USERINFO.sub(lambda found: found[1] + "*" * len(found[2]), text)


def _quoted(key: str) -> str:
    is_bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if is_bare else f'"{_showable(key)}"'


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _render(finding: Finding, lines: Sequence[str], source: str, *, colour: bool) -> str:
    tint = (_RED if finding.severity == "error" else _YELLOW) if colour else ""
    bold, edge, plain = (_BOLD, _CYAN, _PLAIN) if colour else ("", "", "")
    widest = max(finding.place.line, 0 if finding.other is None else finding.other.line)
    margin = " " * len(str(widest))
    rows = [
        f"{tint}{finding.severity}{plain}{bold}: {_showable(finding.message)}{plain}",
        f"{margin} {edge}-->{plain} {source}:{finding.place.line}:{finding.place.column}",
        f"{margin}  {edge}|{plain}",
        *_marked(finding.place, lines, margin, tint, edge, plain, "^"),
    ]
    if finding.other is not None and finding.other.line != finding.place.line:
        rows += [f"{margin}  {edge}:{plain}"]
        rows += _marked(finding.other, lines, margin, edge, edge, plain, "-")
    if finding.hint:
        rows.append(f"{margin}  {edge}={plain} hint: {_showable(finding.hint)}")
    return "\n".join(row.rstrip() for row in rows)


def _marked(
    place: Place, lines: Sequence[str], margin: str, tint: str, edge: str, plain: str, mark: str
) -> list[str]:
    """Return a source line and, below it, the marks under what it is about."""
    source = lines[place.line - 1] if place.line <= len(lines) else ""
    start = place.column - 1
    end = min(start + place.end - place.start, len(source.rstrip()))
    before, marked, after = (
        source[:start],
        source[start : max(end, start)],
        source[max(end, start) :],
    )
    if len(source) > _WIDTH:
        before = before if len(before) <= _WIDTH // 2 else "…" + before[-_WIDTH // 2 :]
        marked = marked if len(marked) <= _WIDTH else marked[: _WIDTH - 1] + "…"
        after = after[: max(_WIDTH - len(before) - len(marked), 0)]
    before, marked, after = _showable(before), _showable(marked), _showable(after)
    number = str(place.line).rjust(len(margin))
    marks = f"{tint}{mark * max(_cells(marked), 1)}{plain}"
    return [
        f" {number} {edge}|{plain} {before}{marked}{after}",
        f" {margin} {edge}|{plain} {' ' * _cells(before)}{marks}",
    ]


def _showable(text: str) -> str:
    """Return text without anything that moves a terminal's cursor."""
    text = without_passwords(text).replace("\t", "    ").replace("\r", "")
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _cells(text: str) -> int:
    """Return how many columns of a terminal a text takes."""
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "FW" else 1
        for c in text
    )
