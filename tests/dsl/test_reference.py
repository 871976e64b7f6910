"""The pages of the reference are checked against the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dsl.codes import CODES, reference_page
from dsl.compiler import compile_script
from dsl.parser import grammar
from dsl.render import render_diagnostics
from dsl.words import DECLARATIONS, LATER_WORDS, STATEMENTS, WORDS
from tests.dsl.scripts import ACTIONS, RULES

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"
PAGE = (REFERENCE / "language.md").read_text("utf-8")
EXAMPLES = re.findall(r"```(cell[^\n]*)\n(.*?)```", PAGE, re.S)

_STORE = """store toys {
  slot 1 cube red at (0, 0)  slot 2 cube red at (100, 0)  slot 3 cylinder green at (200, 0)
  slot 4 bridge red at (400, 0)  slot 5 cube blue at (600, 0)  slot 6 cube yellow at (700, 0)
  slot 7 cube blue at (800, 0)  slot 8 cylinder yellow at (900, 0)
}
"""
_GOAL = "goal G { in E target cube yellow at (9, 0)" + RULES + "}\n"


def whole(sort: str, text: str) -> str:
    """Put an example where it belongs."""
    if sort == "cell in environment":
        world = "environment E { world 12 x 12 actions UP, DOWN, LEFT, RIGHT\n"
        return f"{_STORE}{ACTIONS}{world}{text}\n}}\n{_GOAL}"
    return text


@pytest.mark.parametrize(("sort", "text"), EXAMPLES)
def test_an_example_of_the_reference_is_right(sort: str, text: str) -> None:
    compiled = compile_script(whole(sort, text), "example.cell")
    codes = {d.code for d in compiled.diagnostics}
    if sort.startswith("cell-error "):
        assert codes == set(sort.split()[1:])
    else:
        assert codes <= ({"W601"} if sort == "cell in script" else set())


def test_the_reference_has_examples_of_every_sort() -> None:
    sorts = {sort for sort, _ in EXAMPLES}
    assert sorts == {"cell", "cell in script", "cell in environment", "cell-error E402"}


def test_the_shown_diagnostic_is_what_the_example_yields() -> None:
    text = next(text for sort, text in EXAMPLES if sort == "cell-error E402")
    shown = re.findall(r"```text\n(.*?)```", PAGE, re.S)[0]
    diagnostics = compile_script(text, "example.cell").diagnostics
    assert render_diagnostics(diagnostics, text, "example.cell") + "\n" == shown


def test_the_table_of_codes_is_that_of_the_code() -> None:
    table = re.findall(r"^\| ([EW]\d{3}) \| (.*) \|$", PAGE, re.M)
    assert table == [(code.code, code.title) for code in CODES.values()]


def test_the_page_of_diagnostics_is_made_from_the_code() -> None:
    assert (REFERENCE / "diagnostics.md").read_text("utf-8") == reference_page()


def test_the_reserved_words_are_those_of_the_grammar() -> None:
    keywords = {
        t.pattern.value for t in grammar().terminals if re.fullmatch("[a-z]+", t.pattern.value)
    }
    assert keywords == WORDS
    assert not WORDS & LATER_WORDS
    listed = PAGE[PAGE.index("are **reserved**") : PAGE.index("- A **number**")]
    assert set(re.findall(r"`([a-z]+)`", listed)) == WORDS | LATER_WORDS


def test_words_that_begin_something_are_words_of_the_language() -> None:
    assert set(DECLARATIONS) == set(STATEMENTS)
    assert {word for words in STATEMENTS.values() for word in words} <= WORDS


def test_the_grammar_of_the_reference_has_every_word() -> None:
    ebnf = re.findall(r"```ebnf\n(.*?)```", PAGE, re.S)[0]
    assert set(re.findall(r'"([a-z]+)"', ebnf)) == WORDS
