from __future__ import annotations

import json
import os
import pty
import subprocess
from pathlib import Path

import pytest

from cell.profile import load_profile, profile_text
from console.ports import OfferedPort, choose_ports
from tests.console.cli import command, environment
from tests.console.hands import Cell, caller


@pytest.fixture
def cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Cell:
    return caller(tmp_path, monkeypatch, capsys)


def test_a_profile_is_shown_as_it_is_written(cell: Cell) -> None:
    assert cell("profile", "show", "mash", "--text").out == profile_text("mash").rstrip() + "\n"


def test_a_profile_is_data_with_its_defaults(cell: Cell) -> None:
    shown = cell("profile", "show", "--json").data()
    assert shown["name"] == "mash"
    server = shown["server"]
    assert isinstance(server, dict)
    assert server["max_line_bytes"] == 4096


def test_each_value_is_shown_with_its_line_or_as_a_default(cell: Cell) -> None:
    lines = cell("profile", "show").out.splitlines()
    port = next(line for line in lines if line.startswith("server.port"))
    assert port.split() == ["server.port", "=", "10993", "#", "line", "6"]
    idle = next(line for line in lines if line.startswith("server.idle_timeout_s"))
    assert idle.split() == ["server.idle_timeout_s", "=", "600.0", "s", "#", "default"]


def test_shipped_and_own_profiles_are_listed(cell: Cell) -> None:
    assert json.loads(cell("profile", "list", "--json").out) == ["avrs", "lynx", "mash"]
    cell("profile", "new", "mine")
    said = cell("profile", "list")
    assert said.out.split() == ["avrs", "lynx", "mash", "mine"]
    assert "profiles" in said.err


def test_a_new_profile_is_good_and_can_be_used_by_name(cell: Cell) -> None:
    made = cell("profile", "new", "mine")
    assert made.code == 0
    assert Path(made.out.strip()).is_file()
    assert cell("profile", "check", "mine").code == 0
    assert cell("profile", "diff", "mash", "mine", "--json").code == 1
    assert load_profile("mine").name == "mine"
    assert cell("robot", "pose", "--profile", "mine").code == 0


def test_a_profile_that_is_there_is_written_over_only_by_force(cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text("my work", "utf-8")
    refused = cell("profile", "new", "own", "--out", "own.toml")
    assert refused.code == 2
    assert "--force" in refused.err
    assert path.read_text("utf-8") == "my work"
    assert cell("profile", "new", "own", "--out", "own.toml", "--force", "--from", "lynx").code == 0
    assert cell("profile", "check", "own.toml").code == 0


def test_the_check_shows_all_mistakes_and_fails(cell: Cell, tmp_path: Path) -> None:
    text = (
        profile_text("mash").replace("magnet = 10", "magnet = 8").replace("baud = 9600", "baud=1")
    )
    (tmp_path / "bad.toml").write_text(text, "utf-8")
    said = cell("profile", "check", "bad.toml")
    assert said.code == 1
    assert "2 errors, 0 warnings" in said.out
    assert "bad.toml:" in said.out
    assert "^" in said.out
    data = cell("profile", "check", "bad.toml", "--json").data()
    assert data["is_good"] is False
    findings = data["findings"]
    assert isinstance(findings, list)
    assert [one["field"] for one in findings] == ["display.serial.baud", "outputs.magnet"]


def test_a_warning_fails_only_the_strict_check(cell: Cell, tmp_path: Path) -> None:
    text = profile_text("mash").replace('port = "COM7", ', "")
    (tmp_path / "own.toml").write_text(text, "utf-8")
    said = cell("profile", "check", "own.toml")
    assert (said.code, "1 warning" in said.out) == (0, True)
    assert "have their default" in said.err
    assert cell("profile", "check", "own.toml", "--strict").code == 1


def test_two_profiles_are_compared_field_by_field(cell: Cell, tmp_path: Path) -> None:
    text = profile_text("mash").replace("step_mm = 20", "step_mm = 25")
    (tmp_path / "own.toml").write_text(text, "utf-8")
    said = cell("profile", "diff", "mash", "own.toml", "--json")
    assert said.code == 1
    assert json.loads(said.out) == [
        {"field": "lattice.step_mm", "unit": "mm", "first": 20.0, "second": 25.0}
    ]
    assert "lattice.step_mm" in cell("profile", "diff", "mash", "own.toml").out
    assert cell("profile", "diff", "mash", "mash").code == 0


def test_a_cell_without_a_playground_is_shown_and_checked_all_the_same(cell: Cell) -> None:
    assert cell("profile", "check", "avrs").code == 0
    assert "arm.model" in cell("profile", "show", "lynx").out


def test_ports_are_offered_until_there_are_none(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = iter(["9\n", "2\n", "\n", "1\n"])

    class Keyboard:
        def readline(self) -> str:
            return next(answers)

    monkeypatch.setattr("sys.stdin", Keyboard())
    offered = [OfferedPort("/dev/ttyUSB0", "one"), OfferedPort("/dev/ttyUSB1", "two")]
    chosen = choose_ports(["arm", "gripper", "display"], offered)
    assert chosen == {"arm": "/dev/ttyUSB1", "display": "/dev/ttyUSB0"}
    assert "'9' is none of them" in capsys.readouterr().err


def test_on_a_terminal_whoever_ends_the_input_gets_the_ports_of_the_base(tmp_path: Path) -> None:
    master, terminal = pty.openpty()
    try:
        process = subprocess.Popen(
            command(["profile", "new", "mine", "--out", str(tmp_path / "mine.toml")]),
            env=environment(tmp_path), stdin=terminal, stdout=subprocess.PIPE, stderr=terminal,
        )  # fmt: skip
        os.write(master, b"\n\n\n\n")
        process.communicate(timeout=60)
    finally:
        os.close(terminal)
        os.close(master)
    assert process.returncode == 0
    assert load_profile(str(tmp_path / "mine.toml")).arm.serial.port == "COM9"


@pytest.mark.parametrize("verb", ["check", "show"])
def test_a_pipe_is_no_profile_and_is_not_waited_for(verb: str, cell: Cell, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    said = cell("profile", verb, "pipe.toml")
    assert said.code == 2
    assert "pipe.toml cannot be read: it is a pipe or a device" in said.err


@pytest.mark.parametrize("verb", ["check", "show"])
def test_a_device_is_no_profile(verb: str, cell: Cell) -> None:
    said = cell("profile", verb, "/dev/zero")
    assert said.code == 2
    assert "/dev/zero cannot be read: it is a pipe or a device" in said.err


@pytest.mark.parametrize(
    "words",
    [("check",), ("check", "--json"), ("show",), ("diff", "mash")],
    ids=["check", "check --json", "show", "diff"],
)
@pytest.mark.parametrize("userinfo", ["anna:hunter2", "hunter2"])
def test_a_password_in_an_address_is_not_repeated(
    words: tuple[str, ...], userinfo: str, cell: Cell, tmp_path: Path
) -> None:
    written = f'[reports.webhook]\nurl = "https://{userinfo}@example.org/hook"\n'
    (tmp_path / "told.toml").write_text(profile_text("mash") + "\n" + written, "utf-8")
    said = cell("profile", words[0], "told.toml", *words[1:])
    assert said.code in (0, 1)
    assert "hunter2" not in said.out + said.err
    if words != ("check", "--json") and (words != ("check",) or ":" in userinfo):
        assert "*@example.org/hook" in said.out


def test_a_password_is_not_repeated_beside_a_mistake_either(cell: Cell, tmp_path: Path) -> None:
    (tmp_path / "told.toml").write_text('nmae = "https://anna:hunter2@example.org"\n', "utf-8")
    for verb in ("check", "show"):
        said = cell("profile", verb, "told.toml")
        assert said.code in (1, 2)
        assert "hunter2" not in said.out + said.err
        assert "************@example.org" in said.out + said.err
