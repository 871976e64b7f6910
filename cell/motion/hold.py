"""The arm stands still, after a fault or opening: what is known of it, who lets it go on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cell.geometry import JointPositions
from cell.motion.guard import GuardedMove


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """Why the arm was stopped, and where it may stand.

    Attributes:
        reason: What happened, for people.
        move: The motion that was under way, None if the arm stood.
        stand: Where the arm stood, if no motion was under way and that is known.
        needs_restart: Whether only a new task, or a clean-up asked for, may go on.
        is_fault: Whether a fault stopped the arm; False when it was only just opened.
    """

    reason: str
    move: GuardedMove | None = None
    stand: JointPositions | None = None
    needs_restart: bool = False
    is_fault: bool = True


class ResumeGate(Protocol):
    """Checks whether the arm may move again."""

    def check(self, hold: Hold) -> str:
        """Bring back what can be brought back, and check the rest; return what was found.

        Raises:
            ResumeRefused: Something is wrong; the text says what, and what to do.
        """
