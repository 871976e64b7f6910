"""The whole main job with every serial device behind a pseudo-terminal."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from console.cli import main


def test_the_demo_reaches_its_goal_and_verifies_over_pseudo_terminals(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert main(["demo", "--wires", "pty", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["wires"] == "pty"
    assert (told["outcome"], told["steps"], told["reward"]) == ("finished", 22, 20)
    assert told["verify"]["identical"] is True
