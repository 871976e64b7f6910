"""A small plan of where the arm has been, as far as a client can know.

The protocol tells no positions, so the plan counts from the start: an action
that has a direction moves one point, unless the event speaks of a wall.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

DIRECTIONS: Mapping[str, tuple[int, int]] = {
    "UP": (0, 1),
    "DOWN": (0, -1),
    "LEFT": (-1, 0),
    "RIGHT": (1, 0),
}
_MAX_WIDTH, _MAX_HEIGHT = 30, 14


@dataclass(slots=True)
class Plan:
    """Where the arm is believed to be, where it was, and what it earned."""

    x: int = 0
    y: int = 0
    steps: int = 0
    total: float = 0.0
    last: str = ""
    suggestion: str = ""
    state: str = "STATE_UPDATED"
    visited: set[tuple[int, int]] = field(default_factory=lambda: {(0, 0)})

    def step(self, action: str, reward: float, event: str, suggestion: str, state: str) -> None:
        """Take note of an action and its reply."""
        dx, dy = DIRECTIONS.get(action, (0, 0))
        if "wall" not in event.lower():
            self.x, self.y = self.x + dx, self.y + dy
            self.visited.add((self.x, self.y))
        self.steps += 1
        self.total += reward
        self.last = f"{action}: reward {reward:g}" + (f", {event}" if event else "")
        self.suggestion = suggestion
        self.state = state

    def start_over(self, suggestion: str) -> None:
        """Go back to the start."""
        self.x = self.y = self.steps = 0
        self.total = 0.0
        self.visited = {(0, 0)}
        self.last = "back at the start"
        self.suggestion = suggestion
        self.state = "STATE_UPDATED"

    def lines(self) -> list[str]:
        """Return the plan and the figures as lines of text."""
        status = {"FINISHED": "finished, r starts over", "FAILED": "failed, r starts over"}
        return [
            *self._drawing(),
            "",
            f"step {self.steps}, {self.x:+d} {self.y:+d} from the start, reward {self.total:g}",
            self.last + (f"  (teacher: {self.suggestion})" if self.suggestion else ""),
            status.get(self.state, ""),
        ]

    def _drawing(self) -> list[str]:
        """Draw what was visited, the present point always in the picture."""
        left = min(min(x for x, _ in self.visited), self.x)
        bottom = min(min(y for _, y in self.visited), self.y)
        left = max(left, self.x - _MAX_WIDTH + 1)
        bottom = max(bottom, self.y - _MAX_HEIGHT + 1)
        right = min(max(x for x, _ in self.visited), left + _MAX_WIDTH - 1)
        top = min(max(y for _, y in self.visited), bottom + _MAX_HEIGHT - 1)
        return [
            " ".join(self._mark(x, y) for x in range(left - 1, right + 2))
            for y in range(top + 1, bottom - 2, -1)
        ]

    def _mark(self, x: int, y: int) -> str:
        if (x, y) == (self.x, self.y):
            return "@"
        if (x, y) == (0, 0):
            return "o"
        return "#" if (x, y) in self.visited else "."
