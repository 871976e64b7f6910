from __future__ import annotations

import random
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dsl.compiler import compile_script
from dsl.diagnostics import MAX_PROBLEMS
from dsl.parser import MAX_CHARACTERS, grammar
from dsl.render import render_diagnostics
from tests.dsl.corpus import INVALID, VALID

CORPUS = [path.read_text("utf-8") for path in (*VALID, *INVALID)]
TERMINAL = re.compile(r"__|\bANON\b|\$END|Token\(|Traceback|\.py\b")
PATCHES = ["", "{", "}", "(", '"', "#", "\\", "goal ", "place ", "x", "9", "é", "\0", "test ", "\n"]
NAMES = {t.name for t in grammar().terminals}


def assert_fit_for_people(text: str) -> None:
    """Compile, and check that every message speaks of the script, not of the parser."""
    compiled = compile_script(text, "script")
    in_source = set(re.findall(r"[A-Za-z_]+", text))
    for diagnostic in compiled.diagnostics:
        for sentence in (diagnostic.message, diagnostic.hint):
            assert not TERMINAL.search(sentence.replace(text, "")) or TERMINAL.search(text)
            words = set(re.findall(r"\b[A-Z_]{2,}\b", sentence))
            leaked = (words & NAMES) - in_source - {word.upper() for word in in_source}
            assert not leaked, sentence
        assert 1 <= diagnostic.span.line <= text.count("\n") + 1
    render_diagnostics(compiled.diagnostics, text, "script")


@pytest.mark.parametrize("text", CORPUS, ids=[p.stem for p in (*VALID, *INVALID)])
def test_no_message_of_the_corpus_names_a_terminal(text: str) -> None:
    assert_fit_for_people(text)


@pytest.mark.parametrize("seed", range(300))
def test_no_message_of_a_mutated_script_names_a_terminal(seed: int) -> None:
    dice = random.Random(seed)
    text = dice.choice(CORPUS)
    for _ in range(dice.randint(1, 6)):
        at = dice.randrange(len(text))
        length = dice.choice((1, 1, 2, 5, 20, 80))
        patch = dice.choice(PATCHES)
        text = text[:at] + patch + text[at + length :]
    assert_fit_for_people(text)


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=200))
def test_any_text_at_all_is_answered_by_diagnostics(text: str) -> None:
    compiled = compile_script(text, "script")
    assert (compiled.program is None) == any(d.severity == "error" for d in compiled.diagnostics)
    render_diagnostics(compiled.diagnostics, text, "script", colour=True)


@pytest.mark.parametrize("seed", range(60))
def test_words_of_the_language_in_any_order_are_answered_by_diagnostics(seed: int) -> None:
    dice = random.Random(seed)
    words = [word for text in CORPUS[:6] for word in re.findall(r"\S+", text)]
    assert_fit_for_people(" ".join(dice.choices(words, k=dice.randint(1, 150))))


def test_a_grammar_without_collisions_and_conflicts() -> None:
    assert grammar(is_strict=True).parse("action UP { move (0, 1) }").data == "start"


def test_a_huge_file_is_turned_down_at_once() -> None:
    compiled = compile_script("#" * (MAX_CHARACTERS + 1), "script")
    assert [d.code for d in compiled.diagnostics] == ["E107"]


def test_the_largest_file_of_braces_is_read() -> None:
    compiled = compile_script("{" * 20_000, "script")
    assert compiled.program is None


def test_after_a_hundred_problems_the_rest_is_left_out() -> None:
    text = "action A { mve }\n" * 300
    diagnostics = compile_script(text, "script").diagnostics
    assert len(diagnostics) == MAX_PROBLEMS + 1
    assert diagnostics[-1].code == "E109"


def test_mistakes_in_one_file_are_reported_once_each() -> None:
    text = CORPUS[[p.stem for p in VALID].index("everything")]
    broken = (
        text.replace("travel 70.5 mm", "travel mm 70.5")
        .replace("place bridge red at (4, 4)", "place bridge red at 4, 4")
        .replace("target cube red at random", "target cube red at radnom")
        .replace("when hit wall", "when hits wall")
    )
    codes = [d.code for d in compile_script(broken, "script").diagnostics]
    assert codes == ["E101"] * 4


def test_a_broken_declaration_does_not_make_its_uses_wrong() -> None:
    text = "environment BROKEN 4 { }\ngoal G { in BROKEN target cube red otherwise finish }\n"
    assert [d.code for d in compile_script(text, "script").diagnostics] == ["E101"]
