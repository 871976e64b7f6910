"""What a check has to say about a script, and where it is collected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dsl.codes import CODES, Severity
from dsl.spans import Span

MAX_PROBLEMS = 100
"""Diagnostics of one script; what follows is left out, and that is said."""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding about a script.

    Attributes:
        code: Its number in `dsl.codes`, such as `E402`.
        severity: Whether it keeps the script from running.
        span: Where it is.
        message: What is wrong, in a sentence.
        hint: What to do about it, or an empty string.
    """

    code: str
    severity: Severity
    span: Span
    message: str
    hint: str = ""


class Report:
    """Collects the diagnostics of one script."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, int, str], Diagnostic] = {}
        self._overflow: Span | None = None

    def add(self, code: str, span: Span, message: str, hint: str = "") -> None:
        """Note a finding; the same finding at the same place is kept once."""
        if self.is_full:
            self.leave_rest(span)
            return
        diagnostic = Diagnostic(code, CODES[code].severity, span, message, hint)
        self._found.setdefault((code, span.start, message), diagnostic)

    def leave_rest(self, span: Span) -> None:
        """Note that what follows from here on is left out."""
        self._overflow = self._overflow or span

    @property
    def is_full(self) -> bool:
        """Whether further findings would be left out."""
        return len(self._found) >= MAX_PROBLEMS

    def count(self, severity: Literal["error", "warning"] = "error") -> int:
        """Return how many findings of a severity there are."""
        return sum(d.severity == severity for d in self._found.values())

    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Return everything found, in the order of the source."""
        found = sorted(self._found.values(), key=lambda d: (d.span.start, d.span.end, d.code))
        if self._overflow is not None:
            found.append(
                Diagnostic(
                    "E109",
                    CODES["E109"].severity,
                    self._overflow,
                    f"more than {MAX_PROBLEMS} problems; the rest is left out",
                    "mend the first ones and check again",
                )
            )
        return tuple(found)
