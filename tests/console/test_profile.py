from __future__ import annotations

import json

import pytest

from cell.profile import profile_text
from console.cli import main


def test_a_profile_is_shown_as_it_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", "show", "mash", "--text"]) == 0
    assert capsys.readouterr().out == profile_text("mash").rstrip() + "\n"


def test_a_profile_is_data_with_its_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", "show", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["name"] == "mash"
    assert shown["server"]["max_line_bytes"] == 4096


def test_the_shipped_profiles_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", "list", "--json"]) == 0
    assert "mash" in json.loads(capsys.readouterr().out)
