"""The comments of a script, which the parser passes over."""

from __future__ import annotations

import re

from dsl.nodes import Comment
from dsl.spans import Span

_TEXT_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"?|(#[^\n]*)')


def comments_of(text: str) -> tuple[Comment, ...]:
    """Return every comment of a script, in order; a `#` in a text begins none."""
    found: list[Comment] = []
    line, line_start, position = 1, 0, 0
    for match in _TEXT_OR_COMMENT.finditer(text):
        if match[1] is None:
            continue
        start, end = match.span()
        line += text.count("\n", position, start)
        line_start = text.rfind("\n", 0, start) + 1
        position = start
        column = start - line_start + 1
        span = Span(start, end, line, column, line, column + end - start)
        found.append(Comment(match[1], span))
    return tuple(found)
