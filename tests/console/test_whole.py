"""The command line on the whole twin: served, played, recorded, replayed, stopped."""

from __future__ import annotations

import json
import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from console.cli import main
from dsl.library import library_script
from tests.console.cli import command, environment, run_cell


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path


@contextmanager
def serving(home: Path, *options: str) -> Iterator[tuple[subprocess.Popen[str], list[str]]]:
    """Serve the shipped script in a child; yield it and its addresses by line."""
    words = ["serve", "mash", "--port", "0", "--seed", "5", *options]
    listeners = 1 + options.count("--listen")
    with subprocess.Popen(
        command(words),
        env=environment(home),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None
        try:
            yield child, [child.stdout.readline().strip() for _ in range(listeners)]
        finally:
            child.kill()


def test_the_demo_reaches_its_goal_and_proves_it(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["outcome"], told["steps"], told["reward"]) == ("finished", 22, 20)
    assert told["verify"]["identical"] is True
    assert told["verify"]["views"] == 66
    assert len(told["pictures"]) == 3
    for picture in told["pictures"]:
        assert Path(picture).read_bytes().startswith(b"\x89PNG")
    assert Path(told["session"]).is_relative_to(home)

    changed = home / "changed.cell"
    changed.write_text(re.sub(r"reward +20\b", "reward 21", library_script("mash")), "utf-8")
    assert main(["sessions", "verify", "latest", "--script", str(changed)]) == 1
    said = capsys.readouterr().out
    assert said.startswith("different at step ")
    assert "recorded < REWARD 20" in said
    assert "replayed < REWARD 21" in said


def test_serve_announces_each_listener_and_ends_cleanly_on_sigterm(home: Path) -> None:
    with serving(home, "--listen", "127.0.0.1:0/1.4") as (child, lines):
        assert [line.rpartition(" ")[2] for line in lines] == ["1.5", "1.4"]
        assert all(line.startswith("listening on 127.0.0.1:") for line in lines)
        address = lines[1].split()[2]
        played = run_cell("experiment", address, "-n", "2", "--json", home=home)
        assert played.returncode == 0, played.stderr
        told = json.loads(played.stdout)
        assert told["finished"] == 2
        assert told["mean_steps"] == 22
        child.send_signal(signal.SIGTERM)
        assert child.wait(60) == 0
    listed = json.loads(run_cell("sessions", "list", "--json", home=home).stdout)
    assert [one["state"] for one in listed] == ["finished"]
    assert listed[0]["dialect"] == "1.4"


def test_one_session_after_the_other_is_served_and_recorded(home: Path) -> None:
    with serving(home, "--views", "none") as (_, lines):
        for seed in ("1", "2"):
            done = run_cell("experiment", lines[0].split()[2], "--seed", seed, home=home)
            assert done.returncode == 0, done.stderr
    listed = json.loads(run_cell("sessions", "list", "--json", home=home).stdout)
    assert [one["state"] for one in listed] == ["finished", "finished"]


def test_serve_ends_cleanly_on_ctrl_c_too(home: Path) -> None:
    with serving(home) as (child, _):
        child.send_signal(signal.SIGINT)
        assert child.wait(60) == 130


def test_a_second_server_is_told_who_has_the_cell(home: Path) -> None:
    with serving(home) as (child, _):
        other = run_cell("serve", "mash", "--port", "0", home=home)
        assert other.returncode == 3
        assert str(child.pid) in other.stderr
        assert "Traceback" not in other.stderr


def test_a_port_in_use_is_a_sentence(home: Path) -> None:
    with serving(home) as (_, lines):
        port = lines[0].split()[2].rpartition(":")[2]
        other = run_cell("serve", "mash", "--port", port, home=home / "other")
        assert other.returncode == 3
        assert port in other.stderr


def test_after_kill_9_the_session_is_not_finished_and_clean_brings_blocks_home(
    home: Path,
) -> None:
    with serving(home) as (child, lines):
        address = lines[0].split()[2]
        # Playing by lines leaves the cell laid out for as long as stdin stays open.
        with subprocess.Popen(
            command(["play", address]),
            env=environment(home),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as player:
            assert player.stdin is not None
            assert player.stdout is not None
            player.stdin.write("up\nright\n")
            player.stdin.flush()
            assert player.stdout.readline().startswith("UP: reward 0")
            assert player.stdout.readline().startswith("RIGHT: reward 0")
            child.kill()
            child.wait(30)
            player.kill()
    listed = json.loads(run_cell("sessions", "list", "--json", home=home).stdout)
    assert [one["state"] for one in listed] == ["not finished"]
    shown = json.loads(run_cell("sessions", "show", "latest", "--json", home=home).stdout)
    assert [step["line"] for step in shown["steps"]][-2:] == ["ACTION UP", "ACTION RIGHT"]
    cleaned = run_cell("clean", "--json", home=home)
    assert cleaned.returncode == 0, cleaned.stderr
    assert len(json.loads(cleaned.stdout)["brought_home"]) == 3
    again = run_cell("clean", home=home)
    assert again.stdout == "the table was clean already\n"
    verified = run_cell("sessions", "verify", "latest", home=home)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert "not finished" in verified.stdout


def test_play_by_lines_moves_saves_views_and_says_what_happened(home: Path) -> None:
    with serving(home, "--no-record") as (_, lines):
        address = lines[0].split()[2]
        played = run_cell("play", address, home=home, stdin="up left nonsense t v r q\n")
    assert played.returncode == 0, played.stderr
    said = played.stdout.splitlines()
    assert said[0] == "UP: reward 0, Robot move"
    assert said[1] == "LEFT: reward -10, Robot hit the wall"
    assert "arrows or wasd" in said[2]
    assert said[5] == "back at the start"
    folder = Path(said[4].removeprefix("views are in "))
    assert len(list(folder.glob("*.png"))) == 3


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (("--goal", "Nope"), 2, "UNKNOWN_GOAL Nope"),
        (("--policy", "script:UP,UP", "--environment", "STATIC_4x4"), 1, "given up after 2"),
        (("--policy", "script:UP*3,RIGHT*3", "--environment", "STATIC_4x4"), 0, "finished"),
        (("--policy", "random", "--max-steps", "3"), 1, "given up after 3"),
    ],
    ids=["no such goal", "too short", "scripted", "random"],
)
def test_experiments_end_with_the_right_exit_code(
    options: tuple[str, ...], code: int, words: str, home: Path
) -> None:
    with serving(home, "--no-record") as (_, lines):
        done = run_cell("experiment", lines[0].split()[2], *options, home=home)
    assert done.returncode == code, done.stderr
    assert words in done.stderr


def test_the_teacher_needs_a_dialect_that_has_one(home: Path) -> None:
    with serving(home, "--no-record", "--dialect", "1.2") as (_, lines):
        done = run_cell("experiment", lines[0].split()[2], home=home)
    assert done.returncode == 2
    assert "dialect 1.2 has no teacher" in done.stderr
