from __future__ import annotations

import json
from pathlib import Path

import pytest

from cell.profile import profile_text
from console.cli import main


def test_the_shipped_script_is_good_and_fits_its_cell(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "mash"]) == 0
    assert capsys.readouterr().out == "mash.cell is good, and fits the cell mash\n"


def test_mistakes_are_shown_on_stdout_with_place_and_hint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "bad.cell"
    script.write_text("action UP { move (0, 1) }\naction UP { move (0, 1) }\n", "utf-8")
    assert main(["check", str(script), "--no-profile"]) == 1
    shown = capsys.readouterr()
    assert "bad.cell:2:" in shown.out
    assert "^" in shown.out
    assert shown.err == ""


def test_mistakes_are_data_for_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = tmp_path / "bad.cell"
    script.write_text("goal {", "utf-8")
    assert main(["check", str(script), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["is_good"] is False
    assert {"code", "severity", "line", "column", "message", "hint"} <= set(told["diagnostics"][0])


def test_a_lattice_out_of_reach_is_found_with_the_profile_and_only_then(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = tmp_path / "far.toml"
    text = profile_text("mash")
    assert "origin_mm = [710, -265]" in text
    profile.write_text(text.replace("[710, -265]", "[711, -600]"), "utf-8")
    assert main(["check", "mash", "--profile", str(profile)]) == 1
    assert "E701" in capsys.readouterr().out
    assert main(["check", "mash", "--no-profile"]) == 0


def test_text_that_is_not_utf_8_is_said_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "odd.cell"
    script.write_bytes(b"# \xff\n")
    assert main(["check", str(script)]) == 1
    assert "not UTF-8" in capsys.readouterr().err
