"""What is kept of the source: spans, comments, and how they are shown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from dsl.comments import comments_of
from dsl.compiler import compile_script
from dsl.diagnostics import Diagnostic
from dsl.nodes import Comment, Name
from dsl.render import render_diagnostics
from dsl.spans import Span
from tests.dsl.corpus import INVALID, VALID


def nodes_in(value: object) -> Iterator[object]:
    """Yield a node and everything below it."""
    if isinstance(value, tuple):
        for item in value:
            yield from nodes_in(item)
    elif is_dataclass(value) and not isinstance(value, Span | type):
        yield value
        for field in fields(value):
            yield from nodes_in(getattr(value, field.name))


@pytest.mark.parametrize("path", [*VALID, *INVALID], ids=lambda path: path.stem)
def test_the_span_of_every_name_is_where_the_name_stands(path: Path) -> None:
    text = path.read_bytes().decode("utf-8")
    names = [
        n for n in nodes_in(compile_script(text, "s").script.declarations) if isinstance(n, Name)
    ]
    for name in names:
        assert text[name.span.start : name.span.end] == name.text
        line = text.split("\n")[name.span.line - 1]
        assert line[name.span.column - 1 : name.span.end_column - 1] == name.text


@pytest.mark.parametrize("path", VALID, ids=lambda path: path.stem)
def test_a_declaration_spans_from_its_word_to_its_brace(path: Path) -> None:
    text = path.read_bytes().decode("utf-8")
    for declaration in compile_script(text, "s").script.declarations:
        source = text[declaration.span.start : declaration.span.end]
        assert source.split()[0] in ("store", "action", "environment", "goal")
        assert source.endswith("}")


def test_comments_are_found_and_texts_are_none() -> None:
    text = '# one\ngoal G { event "no # comment" } # two\n  #three\n"open # text'
    assert comments_of(text) == (
        Comment("# one", Span(0, 5, 1, 1, 1, 6)),
        Comment("# two", Span(38, 43, 2, 33, 2, 38)),
        Comment("#three", Span(46, 52, 3, 3, 3, 9)),
    )


def shown(text: str, span: Span, *, colour: bool = False) -> list[str]:
    diagnostic = Diagnostic("E101", "error", span, "a message", "a hint")
    return render_diagnostics([diagnostic], text, "name", colour).split("\n")


def test_the_caret_stands_under_the_span_behind_tabs_and_wide_letters() -> None:
    lines = shown("\tx 漢字 mark\n", Span(6, 10, 1, 7, 1, 11))
    assert lines[3] == " 1 |     x 漢字 mark"
    assert lines[4] == "   |            ^^^^"


def test_a_long_line_is_cut_around_the_span() -> None:
    text = "a " * 5000 + "mark " + "b " * 5000
    lines = shown(text, Span(10000, 10004, 1, 10001, 1, 10005))
    assert all(len(line) < 130 for line in lines)
    at = lines[4].index("^")
    assert lines[3][at : at + 4] == "mark"


def test_a_span_over_several_lines_is_marked_to_the_end_of_its_first() -> None:
    assert shown("one two\nthree\n", Span(4, 13, 1, 5, 2, 6))[4] == "   |     ^^^"


def test_nothing_that_moves_a_terminals_cursor_is_shown() -> None:
    lines = shown("a\x1b[2J\x07b\r\n", Span(0, 1, 1, 1, 1, 2))
    assert lines[3] == " 1 | a\N{REPLACEMENT CHARACTER}[2J\N{REPLACEMENT CHARACTER}b"


def test_colours_are_only_used_when_asked_for() -> None:
    span = Span(0, 1, 1, 1, 1, 2)
    assert "\x1b" not in "".join(shown("abc", span))
    assert "\x1b[31m" in "".join(shown("abc", span, colour=True))


def test_no_diagnostics_are_shown_as_a_count() -> None:
    assert render_diagnostics([], "", "name") == "0 errors, 0 warnings"


def test_diagnostics_come_in_the_order_of_the_source() -> None:
    for path in INVALID:
        diagnostics = compile_script(path.read_text("utf-8"), "s").diagnostics
        assert [d.span.start for d in diagnostics] == sorted(d.span.start for d in diagnostics)
