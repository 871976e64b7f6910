"""The protocol's reference says what the program does."""

from __future__ import annotations

import re
from pathlib import Path

from sessions.phase import diagram
from sessions.views import ENCODERS
from sessions.wire.dialects import DIALECTS

TEXT = (Path(__file__).parents[2] / "docs" / "reference" / "mas.md").read_text("utf-8")


def test_the_diagram_is_made_of_the_table_of_phases() -> None:
    assert f"```mermaid\n{diagram()}```\n" in TEXT


def test_the_table_of_commands_names_every_command_and_its_dialects() -> None:
    rows = re.findall(r"^\| `([A-Z_]+).*\| ([\d. ]+) \|$", TEXT, re.MULTILINE)

    assert {(verb, tuple(versions.split())) for verb, versions in rows} == {
        (verb, tuple(v for v, dialect in DIALECTS.items() if verb in dialect.verbs))
        for every in DIALECTS.values()
        for verb in every.verbs
    }


def test_every_format_of_a_view_is_described() -> None:
    assert set(re.findall(r"^\| `(image/\w+)`", TEXT, re.MULTILINE)) == set(ENCODERS)
