"""Two hundred random sessions on one twin cell, checked against the twin's truth.

One cell serves all of them, so that whatever a session leaves askew the next one meets.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import pytest

from cell.clock import SimulatedClock
from cell.manipulation import Deployment
from cell.profile import parse_profile, profile_text
from cell.twin_cell import TwinCell
from dsl.library import library_script
from sessions.hosting import Hosted, host_twin
from sessions.script_source import served_script
from sessions.session import Session
from sessions.wire.dialects import dialect_named

SESSIONS = 200
PARTS = 4
GOALS = ("ReachRedCube", "ReachRedCube.Random")
WORLDS = {
    "STATIC_12x12": (12, 12),
    "STATIC_8x6": (8, 6),
    "STATIC_4x4": (4, 4),
    "RANDOM_12x12": (12, 12),
}
MOVES = {b"UP": (0, 1), b"DOWN": (0, -1), b"RIGHT": (1, 0), b"LEFT": (-1, 0)}
LAID_WITHIN_MM = 3.0
HOME_WITHIN_MM = 8.0


class Watched:
    """A served twin cell whose lay-outs are noted."""

    def __init__(self, seed: int) -> None:
        text = profile_text("mash")
        self.hosted: Hosted[TwinCell] = host_twin(
            served_script(library_script("mash"), "mash.cell"),
            parse_profile(text, "mash"),
            text,
            seed=seed,
            clock=SimulatedClock(),
        )
        self.cell: TwinCell = self.hosted.cell
        self.deployed: list[Deployment] = []
        really = self.cell.lay_out

        def lay_out(deployments: Sequence[Deployment]) -> None:
            self.deployed = list(deployments)
            really(deployments)

        self.cell.lay_out = lay_out  # type: ignore[method-assign, assignment]

    def truth(self) -> dict[int, tuple[float, float, float]]:
        """Return x, y and z of every block by slot number."""
        return {
            int(block.block.removeprefix("slot ")): (block.x_mm, block.y_mm, block.z_mm)
            for block in self.cell.world.whereabouts()
        }

    def tool(self) -> tuple[float, float]:
        pose = self.cell.read_pose()
        return pose.x_mm, pose.y_mm

    def assert_all_home(self) -> None:
        for number, (x, y, z) in self.truth().items():
            home = self.cell.manipulator.slot_place(number)
            off = math.hypot(x - home.x_mm, y - home.y_mm)
            assert off < HOME_WITHIN_MM, f"block of slot {number} lies {off:.1f} mm from home"
            assert z == pytest.approx(38.5)

    def assert_laid_out(self) -> None:
        out = {d.slot: d for d in self.deployed}
        for number, (x, y, z) in self.truth().items():
            if number in out:
                off = math.hypot(x - out[number].x_mm, y - out[number].y_mm)
                assert off < HOME_WITHIN_MM, f"slot {number}'s block is {off:.1f} mm off its place"
            assert z == pytest.approx(38.5)


def ask(session: Session, line: bytes) -> list[bytes]:
    return session.handle(line).text.rstrip(b"\n").split(b"\n")


def play(watched: Watched, generator: random.Random) -> None:
    goal, environment = generator.choice(GOALS), generator.choice(list(WORLDS))
    dialect = generator.choice(["1.2", "1.3", "1.4", "1.5"])
    session = Session(watched.hosted.desk, dialect_named(dialect), "test")
    reply = ask(session, f"INITIALIZE_TASK {goal} {environment}".encode())
    assert reply[0] == b"AVAILABLE_ACTIONS UP DOWN RIGHT LEFT"
    assert ask(session, b"BEGIN_TASK_SETUP") == [b"OK"]
    assert ask(session, b"END_TASK_SETUP")[-1] in (b"OK", b"STATE_UPDATED")
    watched.assert_laid_out()
    red = next(d for d in watched.deployed if d.slot in (7, 8))
    width, height = WORLDS[environment]
    x = y = 0
    for _ in range(generator.randrange(0, 30)):
        action = generator.choice(list(MOVES))
        dx, dy = MOVES[action]
        before = watched.tool()
        reply = ask(session, b"ACTION " + action)
        is_inside = 0 <= x + dx < width and 0 <= y + dy < height
        if not is_inside:
            assert reply[0] == b"REWARD -10"
            assert reply[-1] == b"STATE_UPDATED"
            assert watched.tool() == before, "into the wall there is no motion"
            continue
        x, y = x + dx, y + dy
        expected = watched.cell.lattice.to_robot(x, y)
        assert watched.tool() == pytest.approx(expected, abs=0.02)
        if expected == pytest.approx((red.x_mm, red.y_mm)):
            assert reply[0] == b"REWARD 20"
            assert reply[-1] == b"FINISHED"
            break
        assert reply[0] == b"REWARD 0"
        assert reply[-1] == b"STATE_UPDATED"
    if generator.random() < 0.5:
        assert ask(session, b"DONE") == [b"GOODBYE"]
    session.end("closed")
    watched.assert_all_home()


@pytest.mark.parametrize("part", range(PARTS))
def test_random_sessions_lay_out_reward_and_bring_home(part: int) -> None:
    seed = 4100 + part
    print(f"seed {seed}")
    generator = random.Random(seed)
    watched = Watched(seed)
    for _ in range(SESSIONS // PARTS):
        play(watched, generator)
    assert watched.hosted.cell.manipulator.is_table_clean()
    watched.hosted.close()
