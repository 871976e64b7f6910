"""What is said in the golden transcripts, and how a dialogue is played and written down."""

from __future__ import annotations

import socket
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from dsl.host import Placement
from dsl.library import library_script
from sessions.cell_script import CellScript
from sessions.script_source import served_script
from sessions.wire.dialects import DIALECTS
from sessions.wire.incoming import AnswerReader
from sessions.wire.replies import Answer, ViewData

FOLDER = Path(__file__).parent
SEED = 20


class NowhereHost:
    """A host that does nothing."""

    def show(self, picture: str) -> None:
        return

    def lay_out(self, placements: Sequence[Placement]) -> None:
        return

    def move_to(self, x: int, y: int, travel_mm: float) -> None:
        return


def mash_script() -> CellScript:
    """Return the shipped script."""
    return served_script(library_script("mash"), "mash.cell")


def combinations(script: CellScript) -> Iterator[tuple[str, str, str]]:
    """Return every goal, environment and dialect."""
    for goal in script.goals:
        for environment in script.environments(goal):
            for version in DIALECTS:
                yield goal, environment, version


def transcript_path(goal: str, environment: str, version: str) -> Path:
    return FOLDER / "mash" / f"{goal}-{environment}-{version}.txt"


def commands(script: CellScript, goal: str, environment: str, version: str) -> list[str]:
    """Return a dialogue that visits everything a dialect has, from STATUS to DONE."""
    verbs = DIALECTS[version].verbs
    way = shortest_way(script, goal, environment)
    views = [f"GET_VIEW {view.name}" for view in script.task(goal, environment).views]
    lines = [
        "STATUS",
        "INFO",
        "LIST_GOALS",
        f"LIST_ENVIRONMENTS {goal}",
        f"USE_GLOBAL_SEED {SEED}",
        f"INITIALIZE_TASK {goal} {environment}",
        "GET_TRAJECTORIES_COUNT",
        "BEGIN_TASK_SETUP",
        "END_TASK_SETUP",
        "ACTION LEFT",
        "TEACHING ON",
        "ACTION DOWN",
        *views,
        *(f"ACTION {action}" for action in way),
        "ACTION LEFT",
        *views[:1],
        "RESET_TASK",
        f"ACTION {way[0]}",
        "LOGS",
        "RESET",
        "STATUS",
        "DONE",
    ]
    return [line for line in lines if line.partition(" ")[0] in verbs]


def shortest_way(script: CellScript, goal: str, environment: str) -> list[str]:
    """Return the teacher's actions from start to target."""
    task = script.start(goal, environment, seed=SEED, host=NowhereHost())
    task.set_up()
    way: list[str] = []
    while (action := task.suggest()) is not None:
        way.append(action)
        task.act(action)
    return way


def play(connected: socket.socket, version: str, lines: Iterable[str]) -> str:
    """Send commands one by one; return the transcript, data replaced by its length.

    The reader of our client says where a reply ends; what is written down is the
    bytes as they came.
    """
    reader = AnswerReader(DIALECTS[version])
    text = ""
    for line in lines:
        connected.sendall(line.encode() + b"\n")
        answer, raw = _next_answer(connected, reader)
        size = len(answer.data) if isinstance(answer, ViewData) else 0
        reply = raw[: len(raw) - size].decode()
        assert reply.endswith("\n")
        text += f"> {line}\n" + "".join(f"< {part}\n" for part in reply[:-1].split("\n"))
        if size:
            text += f"< ... {size} bytes ...\n"
    return text


def _next_answer(connected: socket.socket, reader: AnswerReader) -> tuple[Answer, bytes]:
    raw = bytearray()
    while (answer := reader.next_answer()) is None:
        data = connected.recv(1 << 20)
        assert data, "the server closed the connection"
        raw += data
        reader.feed(data)
    return answer, bytes(raw)
