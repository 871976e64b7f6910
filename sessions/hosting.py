"""Puts a script, a cell, a desk and a recorder together: what a server serves."""

from __future__ import annotations

import gc
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Generic, TypeVar

import cv2

from calibration.applying import calibrated_profile
from calibration.checks import Checks
from calibration.record import CalibrationRecord
from cell.assembly import assemble_hardware, assemble_twin
from cell.assembly.wires import TwinWires
from cell.clock import Clock
from cell.devices.camera import Camera
from cell.devices.display import Screen
from cell.events import EventBus
from cell.profile import Profile
from cell.robot_cell import RobotCell
from cell.store import StorePlan, StoreSlot
from cell.twin_cell import TwinCell
from cell.watchdog import WireLog
from sessions.binding import check_servable
from sessions.cell_script import CellScript
from sessions.desk import Desk
from sessions.journal import Journal, NoJournal, SessionStart
from sessions.recording import PictureStorage, RecorderFactory, SwitchedTap, new_session_id

_PACKAGES = ("robocell", "numpy", "opencv-python-headless", "mcap", "pydantic", "lark")


CellT = TypeVar("CellT", bound=RobotCell)


@dataclass(frozen=True)
class Hosted(Generic[CellT]):
    """A cell and its desk; `close` gives everything back.

    Attributes:
        cell: The cell.
        desk: Lends it to sessions.
        wire: Shown every byte on every wire, for a watchdog's evidence.
    """

    cell: CellT
    desk: Desk
    wire: WireLog

    def close(self) -> None:
        """Switch everything off and give back the ledger, the wires and the cell's lock."""
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
    wires: TwinWires = "memory",
    calibrations: tuple[CalibrationRecord, ...] = (),
    checks: Checks | None = None,
) -> Hosted[TwinCell]:
    """Put a twin cell and its desk together.

    Args:
        script: The script to serve.
        profile: What the cell's file says, which the twin is made by.
        profile_text: Its TOML text, for recordings.
        seed: Seed of the first session, from which those of the others follow.
        clock: The clock of everything in the cell.
        state_folder: Where world and ledger are kept; None keeps them in memory.
        recordings: Where sessions are recorded; None records nothing.
        views: How recorded pictures are kept.
        wires: How drivers and emulators are joined.
        calibrations: The calibrations in force, which go before what the file says.
        checks: What is kept of the checks whether they hold.

    Raises:
        ScriptUnservable: The cell lacks what the script needs.
        CalibrationError: A calibration does not fit the profile.
        StillHeld: Another process has this cell.
        CellError: What is kept of the cell cannot be used.
    """
    known = calibrated_profile(profile, calibrations)
    check_servable(script, known)
    events = EventBus(clock)
    tap = SwitchedTap()
    wire = WireLog(clock, None if recordings is None else tap)
    cell = assemble_twin(
        known,
        store_plan(script),
        seed=seed,
        clock=clock,
        state_folder=state_folder,
        tap=wire,
        events=events,
        wires=wires,
        truth=profile,
    )
    journals = _journals(recordings, events, clock, views, tap)
    desk = _desk(cell, script, profile_text, calibrations, checks, events, seed, journals)
    return Hosted(cell, desk, wire)


def host_hardware(
    script: CellScript,
    profile: Profile,
    profile_text: str,
    *,
    seed: int,
    clock: Clock,
    state_folder: Path,
    screen: Screen,
    cameras: Mapping[str, Camera] | None = None,
    recordings: Path | None = None,
    views: PictureStorage = "jpeg",
    calibrations: tuple[CalibrationRecord, ...] = (),
    checks: Checks | None = None,
) -> Hosted[RobotCell]:
    """Put a cell on the ports of its profile and its desk together.

    Args:
        script: The script to serve.
        profile: What the cell's file says.
        profile_text: Its TOML text, for recordings.
        seed: Seed of the first session, from which those of the others follow.
        clock: Real time.
        state_folder: Where ledger and lock are kept.
        screen: What puts pictures on the display.
        cameras: The cameras by name; those of the profile unless given.
        recordings: Where sessions are recorded; None records nothing.
        views: How recorded pictures are kept.
        calibrations: The calibrations in force, which go before what the file says.
        checks: What is kept of the checks whether they hold.

    Raises:
        ScriptUnservable: The cell lacks what the script needs.
        CalibrationError: A calibration does not fit the profile.
        StillHeld: Another process has this cell.
        CellError: What is kept of the cell cannot be used.
    """
    known = calibrated_profile(profile, calibrations)
    check_servable(script, known)
    events = EventBus(clock)
    tap = SwitchedTap()
    wire = WireLog(clock, None if recordings is None else tap)
    cell = assemble_hardware(
        known,
        store_plan(script),
        clock=clock,
        state_folder=state_folder,
        screen=screen,
        cameras=cameras,
        tap=wire,
        events=events,
    )
    journals = _journals(recordings, events, clock, views, tap)
    desk = _desk(cell, script, profile_text, calibrations, checks, events, seed, journals)
    return Hosted(cell, desk, wire)


def _journals(
    recordings: Path | None,
    events: EventBus,
    clock: Clock,
    views: PictureStorage,
    tap: SwitchedTap,
) -> Callable[[SessionStart], Journal]:
    if recordings is None:
        return _unrecorded
    return RecorderFactory(recordings, events, clock, views, tap=tap)


def _desk(
    cell: RobotCell,
    script: CellScript,
    profile_text: str,
    calibrations: tuple[CalibrationRecord, ...],
    checks: Checks | None,
    events: EventBus,
    seed: int,
    journals: Callable[[SessionStart], Journal],
) -> Desk:
    # One thread renders or looks and one records; a third, of OpenCV's own, is in their way.
    cv2.setNumThreads(1)
    return Desk(
        cell,
        script,
        cell.profile,
        events=events,
        profile_text=profile_text,
        calibrations=calibrations,
        checks=checks,
        seed=seed,
        journal_factory=journals,
        versions=versions(),
        new_session_id=new_session_id,
    )


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
