"""Where something stands in a script."""

from __future__ import annotations

from typing import NamedTuple


class Span(NamedTuple):
    """A stretch of source text.

    Attributes:
        start: Offset of the first character, from 0.
        end: Offset after the last character.
        line: Line of the first character, from 1.
        column: Column of the first character, from 1.
        end_line: Line of the end.
        end_column: Column after the last character.
    """

    start: int
    end: int
    line: int
    column: int
    end_line: int
    end_column: int

    def to(self, other: Span) -> Span:
        """Return the stretch from the start of this one to the end of the other."""
        return Span(self.start, other.end, self.line, self.column, other.end_line, other.end_column)

    def after(self) -> Span:
        """Return the one column that follows, where something is missing."""
        return Span(
            self.end, self.end, self.end_line, self.end_column, self.end_line, self.end_column + 1
        )


NOWHERE = Span(0, 0, 1, 1, 1, 1)
"""The beginning of the file, for what has no better place."""
