"""`cell doctor` and `cell bringup` as somebody calls them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cell.drivers.kiosk import KioskScreen, KioskSettings
from cell.ledger import Ledger
from cell.lock import CellLock
from cell.profile import profile_text
from cell.store import TablePlace
from console.cli import main
from tests.cell.doctor.ward import mash, twin
from tests.cell.drivers.kiosk.pages import FakePage, silence, view


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "state" / "robocell" / "cells" / "mash"


class Person:
    """Somebody at a terminal who types these lines; ^C is the key."""

    def __init__(self, *lines: str) -> None:
        self._lines = list(lines)

    def isatty(self) -> bool:
        return True

    def readline(self) -> str:
        line = self._lines.pop(0) if self._lines else ""
        if line == "^C":
            raise KeyboardInterrupt
        return line


def profile_on_a_free_port(folder: Path, **changes: str) -> str:
    """Write the profile, its server on any free port, so that no other test is in the way."""
    text = profile_text("mash").replace("port = 10993", "port = 0")
    for old, new in changes.items():
        text = text.replace(old.replace("__", " = "), new)
    path = folder / "mash.toml"
    path.write_text(text, "utf-8")
    return str(path)


def test_a_healthy_cell_ends_with_0_and_says_what_was_not_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "--profile", profile_on_a_free_port(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "nothing is wrong" in told.out
    assert "not checked  camera top: focus and place" in told.out
    assert "looking at: arm" in told.err


def test_a_profile_that_cannot_be_read_is_a_finding(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("[arm\n")
    assert main(["doctor", "--profile", str(path), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [one["cause"] for one in told["findings"]] == ["profile-invalid"]


def test_a_profile_that_does_not_exist_is_a_wrong_use(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--profile", "nope"]) == 2
    assert "there is no profile 'nope'" in capsys.readouterr().err


def test_blocks_left_out_are_told_with_evidence_fix_and_link(
    tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    home.mkdir(parents=True)
    ledger = Ledger(home / "ledger.sqlite")
    ledger.released(7, TablePlace(x_mm=600.0, y_mm=0.0, yaw_deg=0.0))
    ledger.close()
    profile = profile_on_a_free_port(tmp_path)
    assert main(["doctor", "--profile", profile, "--component", "store"]) == 1
    told = capsys.readouterr().out
    assert "slots 7" in told
    assert "cell clean" in told
    assert "docs/reference/causes.md#block-out" in told


def test_a_damaged_ledger_is_named_and_the_devices_are_examined_all_the_same(
    tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    home.mkdir(parents=True)
    (home / "ledger.sqlite").write_bytes(b"no database" * 100)
    assert main(["doctor", "--profile", profile_on_a_free_port(tmp_path), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["findings"][0]["cause"] == "ledger-unreadable"
    assert any(one["component"] == "arm" for one in told["fine"])
    assert (home / "ledger.sqlite").read_bytes() == b"no database" * 100


def test_pictures_that_were_learned_are_compared_later(
    tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = profile_on_a_free_port(tmp_path)
    assert main(["doctor", "--profile", profile, "--learn", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["learned"] == ["gripper", "oblique", "top"]
    arguments = ["doctor", "--profile", profile, "--component", "cameras", "--json"]
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    assert any("in its place" in one["what"] for one in told["fine"])
    (home / "learned" / "top.npz").write_bytes(b"PK no picture")
    assert main(arguments) == 0
    assert "learn anew" in capsys.readouterr().err


def test_ports_that_are_not_there_are_the_findings_on_hardware(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = profile_on_a_free_port(
        tmp_path, COM9="/dev/no-such-1", COM8="/dev/no-such-2", COM7="/dev/no-such-3"
    )
    arguments = ["doctor", "--profile", profile, "--wires", "hardware", "--component", "display"]
    assert main([*arguments, "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [one["cause"] for one in told["findings"]] == ["port-missing"]
    assert "/dev/no-such-3" in told["findings"][0]["problem"]


def test_a_twin_is_brought_up_without_a_question(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bringup", "--profile", profile_on_a_free_port(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "the cell mash is ready: `cell serve mash`" in told.out
    assert "READY" in told.err


def test_a_bring_up_of_a_held_cell_says_so_and_ends_with_its_report(
    tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lock = CellLock(home)
    try:
        assert main(["bringup", "--yes", "--profile", profile_on_a_free_port(tmp_path)]) == 1
    finally:
        lock.release()
    told = capsys.readouterr()
    assert "board       not done: computer: another program has this cell" in told.out
    assert "connect     not done: no device can be opened" in told.out
    assert "is not ready; missing: board" in told.out
    assert "feeds, answers" not in told.err


def test_an_interrupted_bring_up_goes_on_where_it_was(
    tmp_path: Path,
    home: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    home.mkdir(parents=True)
    ledger = Ledger(home / "ledger.sqlite")
    ledger.released(7, TablePlace(x_mm=600.0, y_mm=0.0, yaw_deg=0.0))
    ledger.close()
    arguments = ["bringup", "--profile", profile_on_a_free_port(tmp_path)]

    # Asked about the left blocks: the word alone is no reason, then one is given.
    monkeypatch.setattr("sys.stdin", Person("s\n", "s they are glued\n"))
    assert main(arguments) == 1
    assert "they are glued" in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", Person("^C"))
    assert main([*arguments, "--restart"]) == 130
    capsys.readouterr()
    assert main([*arguments, "--yes", "--json"]) == 1
    steps = {one["step"]: one for one in json.loads(capsys.readouterr().out)["steps"]}
    assert steps["leftovers"]["outcome"] == "failed"
    assert steps["controller"]["outcome"] == "done"


def test_a_killed_server_leaves_a_gripper_that_knows_its_zero_and_files_that_stay(
    tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = twin(mash(), state_folder=home)
    cell.open()
    killed = (home / "world.json").read_bytes()
    cell.dispose()
    (home / "world.json").write_bytes(killed)
    assert main(["doctor", "--profile", profile_on_a_free_port(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {"component": "gripper", "what": "it knows its zero"} in told["fine"]
    assert (home / "world.json").read_bytes() == killed


def test_the_page_that_another_program_serves_is_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with KioskScreen(KioskSettings(port=0)) as screen:
        port = screen.url.rstrip("/").rpartition(":")[2]
        path = profile_on_a_free_port(tmp_path, input__1=f"input = 1\npage_port = {port}")
        words = ["doctor", "--profile", path, "--wires", "hardware", "--component", "screen"]
        assert main([*words, "--verbose"]) == 1
        assert "#page-not-connected" in capsys.readouterr().out
        with FakePage(screen, silence, view()):
            assert main([*words, "--verbose"]) == 0
        assert "covers 1920 x 1080 pixels" in capsys.readouterr().out
        with FakePage(screen, silence, view(1536, 864)):
            assert main(words) == 1
        assert "#page-wrong-size" in capsys.readouterr().out
    assert main(words) == 0
    assert f"nobody serves it on port {port}" in capsys.readouterr().out
