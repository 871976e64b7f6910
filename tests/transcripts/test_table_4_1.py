from __future__ import annotations

from cell.clock import SimulatedClock
from cell.profile import profile_text
from sessions.hosting import host_twin
from sessions.script_source import served_script
from tests.sessions.fakes import PROFILE
from tests.sessions.serving import RawClient, serving
from tests.transcripts.dialogue import FOLDER, play


def test_table_4_1_is_spoken_word_for_word_on_the_twin() -> None:
    wanted = (FOLDER / "table_4_1.txt").read_text("utf-8")
    script = served_script((FOLDER / "table_4_1.cell").read_text("utf-8"), "table_4_1.cell")
    hosted = host_twin(script, PROFILE, profile_text("mash"), seed=1, clock=SimulatedClock())
    lines = [line[2:] for line in wanted.splitlines() if line.startswith("> ")]

    with serving(hosted.desk, "1.2") as server, RawClient(server, "1.2") as client:
        assert play(client.socket, "1.2", lines) == wanted
        client.leave()
    hosted.close()
