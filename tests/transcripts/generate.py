"""Writes the golden transcripts anew: `python -m tests.transcripts.generate`."""

from __future__ import annotations

from cell.clock import SimulatedClock
from cell.events import EventBus
from sessions.desk import Desk
from tests.sessions.fakes import PROFILE, FakeCell
from tests.sessions.serving import RawClient, serving
from tests.transcripts.dialogue import (
    SEED,
    combinations,
    commands,
    mash_script,
    play,
    transcript_path,
)


def transcripts() -> dict[tuple[str, str, str], str]:
    """Play every dialogue over a socket, each on a fresh desk; return the transcripts."""
    script = mash_script()
    texts: dict[tuple[str, str, str], str] = {}
    for goal, environment, version in combinations(script):
        desk = Desk(FakeCell(), script, PROFILE, events=EventBus(SimulatedClock()), seed=SEED)
        with serving(desk, version) as server, RawClient(server, version) as client:
            lines = commands(script, goal, environment, version)
            texts[goal, environment, version] = play(client.socket, version, lines)
            assert client.is_closed_by_server()
    return texts


def main() -> None:
    for names, text in transcripts().items():
        path = transcript_path(*names)
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
