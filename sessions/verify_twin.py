"""A fresh twin that begins where a recorded session began."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from cell.clock import SimulatedClock
from cell.profile import parse_profile
from sessions.hosting import host_twin
from sessions.journal import SessionStart
from sessions.script_source import served_script
from sessions.session import Session
from sessions.wire.dialects import dialect_named


@contextmanager
def fresh_session(start: SessionStart, script_text: str | None = None) -> Iterator[Session]:
    """Yield a session on a fresh twin, in the state in which the recorded one began.

    Args:
        start: The start of the recorded session.
        script_text: Use this script instead of the recorded one.

    Raises:
        ScriptUnservable: The script has mistakes, or needs what the cell lacks.
        CellError: The recorded profile or world cannot be used.
    """
    profile = parse_profile(start.profile_text, f"the profile of session {start.session_id}")
    text = start.script_text if script_text is None else script_text
    hosted = host_twin(
        served_script(text, start.script_name),
        profile,
        start.profile_text,
        seed=start.seed,
        clock=SimulatedClock(),
        calibrations=start.calibrations,
    )
    try:
        if start.world_json:
            hosted.cell.restore_world(start.world_json)
        yield Session(hosted.desk, dialect_named(start.dialect), start.peer)
    finally:
        hosted.close()
