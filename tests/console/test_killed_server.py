"""`kill -9` of the server at twenty moments of laying out, playing and cleaning.

A moment is a state of the ledger or a number of replies, drawn from a seed; the server
is killed as soon as it is seen there. Afterwards the recording opens and has every
step that was answered, and `cell clean` brings every block home.
"""

from __future__ import annotations

import json
import math
import random
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from cell.profile import load_profile
from cell.store import place_of_slot, with_calibration_object
from dsl.library import library_script
from sessions.client import MasClient
from sessions.errors import SessionsError
from sessions.hosting import store_plan
from sessions.recording import SessionRecording
from sessions.script_source import served_script
from tests.console.cli import command, environment, run_cell

MOMENTS = 20
DEADLINE_S = 60.0
HOME_WITHIN_MM = 8.0
LedgerState = tuple[int, str]
"""How many blocks are out, and the phase of the open transfer ("" for none)."""


@contextmanager
def served(home: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Serve the shipped script in a process of its own on a free port."""
    server = subprocess.Popen(
        command(["serve", "mash", "--port", "0", "--seed", "11"]),
        env=environment(home),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        assert server.stdout is not None
        line = server.stdout.readline()
        yield server, int(line.split()[2].rpartition(":")[2])
    finally:
        server.kill()
        server.communicate()


def ledger_state(home: Path) -> LedgerState:
    path = home / "state" / "robocell" / "cells" / "mash" / "ledger.sqlite"
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=5)) as ledger:
            (out,) = ledger.execute("SELECT COUNT(*) FROM whereabouts").fetchone()
            row = ledger.execute("SELECT phase FROM transfer").fetchone()
    except sqlite3.OperationalError:
        return 0, ""
    return out, row[0] if row else ""


def kill_when(server: subprocess.Popen[str], home: Path, is_there: Callable[[], bool]) -> None:
    """Kill the server as soon as a moment is seen."""
    deadline_s = time.monotonic() + DEADLINE_S
    while not is_there():
        assert time.monotonic() < deadline_s, "the moment never came"
    server.send_signal(signal.SIGKILL)
    server.wait(DEADLINE_S)


def begin_in_background(port: int, lines: bytes) -> subprocess.Popen[bytes]:
    """Send lines from a process of its own, so that this one is free to watch."""
    code = (
        "import socket,sys\n"
        "s=socket.create_connection(('127.0.0.1',int(sys.argv[1])))\n"
        "s.sendall(bytes.fromhex(sys.argv[2]))\n"
        "while s.recv(65536): pass\n"
    )
    python = command([])[0]
    return subprocess.Popen([python, "-c", code, str(port), lines.hex()], stderr=subprocess.DEVNULL)


SETUP = b"INITIALIZE_TASK ReachRedCube STATIC_12x12\nBEGIN_TASK_SETUP\nEND_TASK_SETUP\n"


def kill_while_laying_out(home: Path, generator: random.Random) -> int:
    wanted = generator.choice([(n, p) for n in (0, 1, 2) for p in ("planned", "gripped")])
    with served(home) as (server, port):
        client = begin_in_background(port, SETUP)
        kill_when(server, home, lambda: ledger_state(home) >= wanted)
        client.wait(DEADLINE_S)
    return 0


def kill_while_playing(home: Path, generator: random.Random) -> int:
    steps = generator.randrange(1, 20)
    with served(home) as (server, port):
        client = MasClient.connect("127.0.0.1", port, timeout_s=DEADLINE_S)
        client.initialize_task("ReachRedCube", "STATIC_12x12")
        client.begin_setup()
        client.end_setup()
        for step in range(steps):
            client.action("RIGHT" if step % 2 else "UP")
        server.send_signal(signal.SIGKILL)
        server.wait(DEADLINE_S)
        with pytest.raises(SessionsError):
            client.action("UP")
    return steps


def kill_while_cleaning(home: Path, generator: random.Random) -> int:
    wanted = generator.choice([(2, "gripped"), (2, "planned"), (1, "gripped"), (1, "planned")])
    was_laid_out = False

    def is_there() -> bool:
        nonlocal was_laid_out
        state = ledger_state(home)
        was_laid_out = was_laid_out or state == (3, "")
        return was_laid_out and state[0] <= wanted[0]

    with served(home) as (server, port):
        client = begin_in_background(port, SETUP + b"ACTION UP\n" * 200 + b"DONE\n")
        kill_when(server, home, is_there)
        client.wait(DEADLINE_S)
    return 200


KILLS = (kill_while_laying_out, kill_while_playing, kill_while_cleaning)


@pytest.mark.parametrize("moment", range(MOMENTS))
def test_a_killed_server_loses_no_step_and_no_block(moment: int, tmp_path: Path) -> None:
    seed = 900 + moment
    print(f"seed {seed}")
    generator = random.Random(seed)
    steps = KILLS[moment % len(KILLS)](tmp_path, generator)

    (path,) = (tmp_path / "data" / "robocell" / "sessions").glob("*.mcap")
    recording = SessionRecording.open(path)
    assert not recording.is_finished
    lines = [step.line for step in recording.steps()]
    answered = sum(line.startswith(b"ACTION") for line in lines)
    assert answered >= steps, f"{steps} steps were answered, {answered} are recorded"

    cleaned = run_cell("clean", "--json", home=tmp_path)
    assert cleaned.returncode == 0, cleaned.stderr
    assert "Traceback" not in cleaned.stderr
    assert_all_home(tmp_path)
    again = run_cell("clean", "--json", home=tmp_path)
    assert json.loads(again.stdout) == {"brought_home": []}


def assert_all_home(home: Path) -> None:
    assert ledger_state(home) == (0, "")
    profile = load_profile("mash")
    scripted = store_plan(served_script(library_script("mash"), "mash.cell"))
    plan = with_calibration_object(scripted, profile.store)
    folder = home / "state" / "robocell" / "cells" / "mash"
    world = json.loads((folder / "world.json").read_text("utf-8"))
    assert world["held"] is None
    blocks = {block["block"]: block for block in world["blocks"]}
    assert len(blocks) == len(plan.slots)
    for slot in plan.slots:
        block, place = blocks[slot.block], place_of_slot(slot, profile.store)
        off = math.hypot(block["x_mm"] - place.x_mm, block["y_mm"] - place.y_mm)
        assert off < HOME_WITHIN_MM, f"{slot.block} lies {off:.1f} mm from its slot"
        assert block["z_mm"] == pytest.approx(38.5)
