"""`cell play`: keys drive the arm."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from console.exits import Exit
from console.output import put, say
from console.places import pictures_folder
from console.plan import DIRECTIONS, Plan

if TYPE_CHECKING:
    from console.episodes import Choices
    from sessions.client import MasClient

_ARROWS = {
    "up": "UP",
    "down": "DOWN",
    "left": "LEFT",
    "right": "RIGHT",
    "w": "UP",
    "s": "DOWN",
    "a": "LEFT",
    "d": "RIGHT",
}
_HELP = "arrows or wasd move, t follows the teacher, v saves the views, r starts over, q quits"


def play(
    address: str,
    /,
    *,
    goal: str = "ReachRedCube",
    environment: str = "STATIC_12x12",
    seed: int | None = None,
    timeout: float = 300.0,
) -> int:
    """Drive the arm with keys: arrows or wasd, t teacher, v views, r start over, q quit.

    Without a terminal, actions and commands are read line by line.

    Args:
        address: Where the server is, as HOST:PORT.
        goal: Name of the goal.
        environment: Name of the environment.
        seed: Seed of the session; the server's unless given.
        timeout: Seconds that an answer may take.
    """
    from console.episodes import Choices, ScriptedPolicy
    from console.serve import parse_address
    from sessions.client import MasClient

    host, port = parse_address(address)
    with MasClient.connect(host, port, timeout) as client:
        say("laying the blocks out ...", "dim")
        choices = Choices.begin(client, goal, environment, seed, ScriptedPolicy(()))
        game = Game(client, choices)
        if sys.stdin.isatty():
            _with_keys(game)
        else:
            _with_lines(game, sys.stdin)
        say("bringing the blocks home ...", "dim")
    return Exit.DONE


class Game:
    """A task that is driven by hand."""

    def __init__(self, client: MasClient, choices: Choices) -> None:
        self._client = client
        self._choices = choices
        self.plan = Plan(suggestion=choices.suggestion, last=_HELP)

    def press(self, key: str) -> bool:
        """Do what a key (or a word of line input) says; return whether the game goes on."""
        match key:
            case "q" | "quit":
                return False
            case "r" | "reset":
                self.plan.start_over(self._client.reset_task())
            case "v" | "views":
                self.plan.last = f"views are in {self.save_views()}"
            case "t" | "teacher" if self.plan.suggestion:
                self._act(self.plan.suggestion)
            case _:
                self._act_by(key)
        return True

    def save_views(self) -> Path:
        """Fetch every view, write it as PNG, and return the folder."""
        from sessions.views import encode_png

        folder = pictures_folder(f"play-{datetime.now(UTC):%Y%m%dT%H%M%S}")
        folder.mkdir(parents=True, exist_ok=True)
        for name in self._choices.views:
            view = self._client.get_view(name)
            path = folder / f"step{self.plan.steps:04d}-{name.lower()}.png"
            path.write_bytes(encode_png(view.pixels()))
        return folder

    def _act_by(self, key: str) -> None:
        """Find the action of a key: an arrow, a number, or the action's own name."""
        actions = self._choices.actions
        action = _ARROWS.get(key.lower(), key.upper())
        if key.isdigit() and 1 <= int(key) <= len(actions):
            action = actions[int(key) - 1]
        if action in actions:
            self._act(action)
        else:
            others = [name for name in actions if name not in DIRECTIONS]
            numbers = "".join(f", {actions.index(name) + 1} {name}" for name in others)
            self.plan.last = _HELP + numbers

    def _act(self, action: str) -> None:
        if self.plan.state != "STATE_UPDATED":
            self.plan.last = "the task is over; r starts over, q quits"
            return
        reply = self._client.action(action)
        self.plan.step(action, reply.reward, reply.event, reply.suggestion, reply.state)


def _with_keys(game: Game) -> None:
    from console.keys import raw_terminal, read_keys

    descriptor = sys.stdin.fileno()
    with raw_terminal(descriptor):
        drawn = _draw(game.plan.lines(), 0)
        for key in read_keys(descriptor):
            if not game.press(key):
                return
            drawn = _draw(game.plan.lines(), drawn)


def _draw(lines: list[str], drawn: int) -> int:
    """Draw over the lines that were drawn before; return how many there are now."""
    up = f"\x1b[{drawn}F" if drawn else ""
    body = "".join(f"{line}\x1b[K\n" for line in lines)
    sys.stderr.write(f"{up}{body}\x1b[J")
    sys.stderr.flush()
    return len(lines)


def _with_lines(game: Game, lines: Iterable[str]) -> None:
    for line in lines:
        for word in line.split():
            if not game.press(word):
                return
            put(game.plan.last)
