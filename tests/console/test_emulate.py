"""`cell emulate` as programs meet it: ports that answer, and vanish when it ends."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cell.assembly.models import MODELS
from cell.clock import SystemClock
from cell.links.base import Link
from cell.links.opening import open_wire
from cell.profile import SerialProfile, TcpProfile, load_cell_profile, load_profile
from console.cli import main
from tests.console.cli import command

DEADLINE_S = 60.0
QUESTIONS = {
    "melfa-rv6sdl": (b"1;1;STATE\r", b"\r"),
    "sharp-lc40le705": (b"POWR?   \r", b"\r"),
    "lynx-al5d": (b"VER\r", b"\r"),
}


@contextmanager
def emulating(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], list[dict[str, str]]]]:
    """Run the command and yield its process and the ports it tells."""
    process = subprocess.Popen(
        command(["emulate", *arguments, "--json"]),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    try:
        told = ""
        while not told.endswith("]\n"):
            line = process.stdout.readline()
            assert line, process.stderr.read()
            told += line
        yield process, json.loads(told)
    finally:
        process.kill()
        process.wait(DEADLINE_S)
        process.stdout.close()
        process.stderr.close()


def _ask(link: Link, question: bytes, end: bytes) -> bytes:
    clock = SystemClock()
    answer = b""
    while not answer.endswith(end) and clock.now_s() < DEADLINE_S:
        link.write(question)
        while piece := link.read(2.0):
            answer += piece
            if answer.endswith(end):
                break
    return answer


def _serial(row: dict[str, str]) -> SerialProfile:
    profile = load_cell_profile(MODELS[row["model"]].profile)
    line: SerialProfile
    if row["device"] == "arm":
        line = profile.arm.serial
    else:
        playground = load_profile(MODELS[row["model"]].profile)
        line = playground.display.serial
    return line.model_copy(update={"port": row["port"]})


@pytest.mark.parametrize("model", QUESTIONS)
def test_a_model_answers_on_its_port_and_ends_cleanly(model: str, tmp_path: Path) -> None:
    port = tmp_path / "port"
    with emulating(model, "--pty", str(port)) as (process, rows):
        assert [row["port"] for row in rows] == [str(port)]
        link = open_wire("device", _serial(rows[0]))
        assert _ask(link, *QUESTIONS[model]).endswith(b"\r")
        link.close()
        process.send_signal(signal.SIGTERM)
        assert process.wait(DEADLINE_S) == 0
        assert not os.path.lexists(port)


def test_a_model_answers_on_tcp_too_and_ctrl_c_ends_it() -> None:
    with emulating("melfa-rv6sdl", "--tcp", "127.0.0.1:0", "--pace", "--trace") as (process, rows):
        host, _, port = rows[0]["port"].rpartition(":")
        link = open_wire("arm", TcpProfile(host=host, port=int(port)))
        assert _ask(link, *QUESTIONS["melfa-rv6sdl"]).startswith(b"Q")
        link.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(DEADLINE_S) == 130
        assert process.stderr is not None
        trace = process.stderr.read()
        assert "arm -> '1;1;STATE\\r'" in trace
        assert "arm <- " in trace


def test_without_a_model_every_device_of_the_cell_has_a_port(tmp_path: Path) -> None:
    with emulating("--profile", "mash", "--pty", str(tmp_path)) as (process, rows):
        assert [(row["device"], row["model"]) for row in rows] == [
            ("arm", "melfa-rv6sdl"),
            ("gripper", "schunk-pg70"),
            ("display", "sharp-lc40le705"),
        ]
        assert [row["line"] for row in rows] == ["38400 8E2", "38400 8E2", "9600 8N2"]
        assert sorted(path.name for path in tmp_path.iterdir()) == ["arm", "display", "gripper"]
        process.send_signal(signal.SIGTERM)
        assert process.wait(DEADLINE_S) == 0
        assert list(tmp_path.iterdir()) == []


def test_the_web_camera_is_served_over_http_and_ends_cleanly(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with emulating("axis-211", "--tcp", "127.0.0.1:0") as (process, rows):
        assert [(row["device"], row["model"]) for row in rows] == [("web_camera", "axis-211")]
        still = tmp_path / "still.jpg"
        assert main(["webcam", "still", str(still), "--url", rows[0]["port"]]) == 0
        assert still.read_bytes().startswith(b"\xff\xd8")
        process.send_signal(signal.SIGTERM)
        assert process.wait(DEADLINE_S) == 0


@pytest.mark.parametrize(
    ("arguments", "words", "code"),
    [
        (["puma-560"], "there is no model puma-560", 2),
        (["melfa-rv6sdl", "--pty", "/tmp/x", "--tcp", "127.0.0.1:0"], "exclude each other", 2),
        (["--tcp", "127.0.0.1:0"], "needs a MODEL", 2),
        (["melfa-rv6sdl", "--tcp", "nowhere"], "HOST:PORT", 2),
        (["axis-211", "--pty", "/tmp/x"], "is on the network", 2),
        (["melfa-rv6sdl", "--pty", "/nowhere/arm"], "no folder /nowhere", 3),
        (["lynx-al5d", "--profile", "mash"], "has no lynx-al5d", 2),
    ],
)
def test_what_cannot_be_is_one_sentence_and_a_code(
    arguments: list[str], words: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["emulate", *arguments]) == code
    assert words in capsys.readouterr().err
