"""Where a session stands, and which commands bring it elsewhere.

This table is the only place that decides on a session's phase; the diagram in
the reference of the protocol is made of it.
"""

from __future__ import annotations

from enum import Enum


class Phase(Enum):
    """How far a session's task is."""

    NO_TASK = "no task"
    SELECTED = "task selected"
    IN_SETUP = "in task setup"
    READY = "task ready"


class Turn(Enum):
    """What can bring a session into another phase."""

    INITIALIZED = "INITIALIZE_TASK"
    SETUP_BEGUN = "BEGIN_TASK_SETUP"
    SETUP_ENDED = "END_TASK_SETUP"
    SETUP_FAILED = "END_TASK_SETUP, ERROR"
    TASK_DROPPED = "internal error"
    SESSION_ENDED = "RESET"


TURNS: dict[tuple[Phase, Turn], Phase] = {
    **{(phase, Turn.INITIALIZED): Phase.SELECTED for phase in Phase},
    **{(phase, Turn.TASK_DROPPED): Phase.NO_TASK for phase in Phase},
    **{(phase, Turn.SESSION_ENDED): Phase.NO_TASK for phase in Phase},
    (Phase.SELECTED, Turn.SETUP_BEGUN): Phase.IN_SETUP,
    (Phase.READY, Turn.SETUP_BEGUN): Phase.IN_SETUP,
    (Phase.IN_SETUP, Turn.SETUP_ENDED): Phase.READY,
    (Phase.IN_SETUP, Turn.SETUP_FAILED): Phase.SELECTED,
}
"""The phase that follows; what is not here cannot happen."""


def diagram() -> str:
    """Return the table as a Mermaid state diagram."""
    lines = ["stateDiagram-v2", "    [*] --> NO_TASK"]
    lines += [
        f"    {phase.name} --> {target.name}: {turn.value}"
        for (phase, turn), target in TURNS.items()
        if not (phase is target is Phase.NO_TASK)
    ]
    return "\n".join(lines) + "\n"
