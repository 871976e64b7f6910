"""The log of a session that its client may ask for: what was drawn, chosen and done."""

from __future__ import annotations

from collections import deque

from sessions.script import Outcome, TaskSpec
from sessions.wire.numbers import format_reward
from sessions.wire.replies import LogFile, LogFiles
from sessions.wire.words import bare_text

LOG_NAME = "session.log"
MAX_LINES = 100_000
"""How many lines are kept; older ones are dropped and counted."""


class SessionLog:
    """Collects lines; holds no times, addresses or paths, so that a replay writes the same."""

    def __init__(self) -> None:
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._dropped = 0

    def clear(self) -> None:
        """Forget everything: a new session begins."""
        self._lines.clear()
        self._dropped = 0

    def seed(self, seed: int, origin: str) -> None:
        """Note the seed from which everything random follows, and who chose it."""
        self._add(f"seed {seed} {origin}")

    def task(self, spec: TaskSpec, seed: int) -> None:
        """Note a task that was set up."""
        self._add(f"task {spec.goal} {spec.environment} seed {seed}")

    def step(self, action: str, outcome: Outcome) -> None:
        """Note an action and what it led to."""
        event = f" {bare_text(outcome.event)}" if outcome.event else ""
        reward = format_reward(outcome.reward)
        self._add(f"step {outcome.step} {action} reward {reward} {outcome.status}{event}")

    def reset(self) -> None:
        """Note that the task went back to its start."""
        self._add("reset")

    def ended(self, reason: str) -> None:
        """Note the end of a task."""
        self._add(f"end {reason}")

    def _add(self, line: str) -> None:
        if len(self._lines) == MAX_LINES:
            self._dropped += 1
        self._lines.append(line)

    def files(self) -> LogFiles:
        """Return the log as the reply to `LOGS`; none while there is nothing in it."""
        if not self._lines:
            return LogFiles(())
        head = [f"{self._dropped} older lines dropped"] if self._dropped else []
        text = "\n".join((*head, *self._lines)) + "\n"
        return LogFiles((LogFile(LOG_NAME, text.encode("utf-8")),))
