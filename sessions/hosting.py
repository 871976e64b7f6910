"""Puts a script, a twin cell, a desk and a recorder together: what a server serves."""

from __future__ import annotations

import gc
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import cv2

from cell.assembly import assemble_twin
from cell.clock import Clock
from cell.events import EventBus
from cell.profile import Profile
from cell.store import StorePlan, StoreSlot
from cell.twin_cell import TwinCell
from sessions.binding import check_servable
from sessions.cell_script import CellScript
from sessions.desk import Desk
from sessions.journal import Journal, NoJournal, SessionStart
from sessions.recording import PictureStorage, RecorderFactory, SwitchedTap, new_session_id

_PACKAGES = ("robocell", "numpy", "opencv-python-headless", "mcap", "pydantic", "lark")


@dataclass(frozen=True, slots=True)
class Hosted:
    """A cell and its desk; `close` gives everything back."""

    cell: TwinCell
    desk: Desk

    def close(self) -> None:
        """Switch everything off and give back the ledger and the cell's lock."""
        self.cell.dispose()


def host_twin(
    script: CellScript,
    profile: Profile,
    profile_text: str,
    *,
    seed: int,
    clock: Clock,
    state_folder: Path | None = None,
    recordings: Path | None = None,
    views: PictureStorage = "jpeg",
) -> Hosted:
    """Put a twin cell and its desk together.

    Args:
        script: The script to serve.
        profile: The cell's profile.
        profile_text: Its TOML text, for recordings.
        seed: Seed of the first session, from which those of the others follow.
        clock: The clock of everything in the cell.
        state_folder: Where world and ledger are kept; None keeps them in memory.
        recordings: Where sessions are recorded; None records nothing.
        views: How recorded pictures are kept.

    Raises:
        ScriptUnservable: The cell lacks what the script needs.
        StillHeld: Another process has this cell.
        CellError: What is kept of the cell cannot be used.
    """
    check_servable(script, profile)
    # One thread renders and one records; a third, of OpenCV's own, is in their way.
    cv2.setNumThreads(1)
    events = EventBus(clock)
    tap = SwitchedTap()
    journals: Callable[[SessionStart], Journal] = _unrecorded
    if recordings is not None:
        journals = RecorderFactory(recordings, events, clock, views, tap=tap)
    cell = assemble_twin(
        profile,
        store_plan(script),
        seed=seed,
        clock=clock,
        state_folder=state_folder,
        tap=None if recordings is None else tap,
        events=events,
    )
    desk = Desk(
        cell,
        script,
        profile,
        events=events,
        profile_text=profile_text,
        seed=seed,
        journal_factory=journals,
        versions=versions(),
        new_session_id=new_session_id,
    )
    return Hosted(cell, desk)


def store_plan(script: CellScript) -> StorePlan:
    """Return the store of a script, as a cell knows stores."""
    return StorePlan(
        tuple(
            StoreSlot(number=s.number, kind=s.kind, colour=s.colour, x_mm=s.x_mm, y_mm=s.y_mm)
            for s in script.program.store.slots
        )
    )


def versions() -> dict[str, str]:
    """Return the version of everything that a session's outcome may depend on."""
    found = {name: version(name) for name in _PACKAGES}
    return {**found, "python": platform.python_version(), "machine": platform.machine()}


def settle_memory() -> None:
    """Let the garbage collector pass over everything made so far.

    Whatever a server is made of lives as long as it does; looking through it again and
    again costs a step a tenth of its time.
    """
    gc.collect()
    gc.freeze()


def _unrecorded(start: SessionStart) -> Journal:
    return NoJournal()
