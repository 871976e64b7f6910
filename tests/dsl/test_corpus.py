from __future__ import annotations

from pathlib import Path

import pytest

from dsl.codes import CODES
from dsl.compiler import compile_script
from dsl.library import library_names, library_script
from dsl.render import render_diagnostics
from tests.dsl.corpus import INVALID, RENDERED, SCRIPTS, VALID, expected, failure

MADE_BY_OTHER_TESTS = {"E107", "E109", "E701", "E702", "E703", "E704", "E705", "E706"}


@pytest.mark.parametrize("path", VALID, ids=lambda path: path.stem)
def test_a_valid_script_yields_a_program_and_no_diagnostics(path: Path) -> None:
    compiled = compile_script(path.read_text("utf-8"), path.name)
    assert compiled.diagnostics == ()
    assert compiled.program is not None


@pytest.mark.parametrize("path", INVALID, ids=lambda path: path.stem)
def test_an_invalid_script_yields_exactly_what_it_announces(path: Path) -> None:
    assert failure(path.read_text("utf-8")) is None


@pytest.mark.parametrize("path", INVALID, ids=lambda path: path.stem)
def test_a_script_has_a_program_unless_it_has_an_error(path: Path) -> None:
    compiled = compile_script(path.read_text("utf-8"), path.name)
    has_error = any(d.severity == "error" for d in compiled.diagnostics)
    assert (compiled.program is None) is has_error


@pytest.mark.parametrize("path", VALID, ids=lambda path: path.stem)
def test_the_harness_fails_on_a_script_that_is_right(path: Path) -> None:
    text = path.read_text("utf-8")
    assert failure(text) is not None
    assert failure(f"# expect: E101 @1\n{text}") is not None


def test_the_harness_fails_on_a_wrong_line_and_on_a_missing_diagnostic() -> None:
    text = "action UP { }\n"
    assert failure(f"# expect: E205 @2\n# expect: W601 @2\n{text}") is not None
    assert failure(f"# expect: E205 @3\n# expect: W601 @3\n{text}") is None
    assert failure(f"# expect: E205 @2\n{text}") is not None


def test_every_code_is_in_the_corpus() -> None:
    seen = {code for path in INVALID for code, _ in expected(path.read_text("utf-8"))}
    assert seen | MADE_BY_OTHER_TESTS == set(CODES)


@pytest.mark.parametrize("path", RENDERED, ids=lambda path: path.stem)
def test_diagnostics_are_shown_as_recorded(path: Path) -> None:
    script = SCRIPTS / "invalid" / f"{path.stem}.cell"
    text = script.read_text("utf-8")
    shown = render_diagnostics(compile_script(text, script.name).diagnostics, text, script.name)
    assert shown + "\n" == path.read_text("utf-8")


def test_some_rendered_diagnostics_are_recorded() -> None:
    assert len(RENDERED) >= 6


@pytest.mark.parametrize("name", library_names())
def test_shipped_scripts_are_free_of_diagnostics(name: str) -> None:
    assert compile_script(library_script(name), name).diagnostics == ()
