"""Who has the cell: one session at a time."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from calibration.checks import Checks
from calibration.record import CalibrationRecord
from cell.devices.camera import Frame
from cell.events import EventBus
from cell.manipulation import Deployment
from cell.profile import Profile
from sessions.journal import Journal, NoJournal, SessionStart
from sessions.script import Script
from sessions.seeds import SeedSequence, random_seed
from sessions.views import ViewEncoder

_log = logging.getLogger(__name__)


class ServedCell(Protocol):
    """What a session needs of a cell. Used by one thread at a time.

    Every method raises a `cell.errors.CellError` when the cell cannot do it.
    """

    def begin_session(self, seed: int) -> None:
        """Draw everything random from `seed` from now on."""

    def world_json(self) -> str:
        """Return the twin's world, or an empty text on hardware."""

    def open(self) -> None:
        """Bring the devices up; harmless when they are."""

    def close(self) -> None:
        """Switch the devices off; harmless when they are."""

    def show(self, picture: str) -> None:
        """Show a picture on the screen under the playground."""

    def lay_out(self, deployments: Sequence[Deployment]) -> None:
        """Bring each block from its store slot to its place."""

    def move_to(self, x_mm: float, y_mm: float, z_mm: float) -> None:
        """Bring the tool point, gripper down, to a place in the robot frame."""

    def clean(self) -> object:
        """Bring every block that is out back to its slot, and stand aside."""

    def grab(self, camera: str, width_px: int, height_px: int) -> Frame:
        """Return a picture of a camera."""


def _no_journal(start: SessionStart) -> Journal:
    return NoJournal()


def _new_session_id() -> str:
    return f"{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}-{secrets.token_hex(3)}"


class Desk:
    """Keeps the cell, lends it to one session at a time, and knows what all sessions share.

    Attributes:
        cell: The cell; only the session that has it may use it.
        script: The script that is served.
        profile: The cell's profile, with the calibrations in force.
        profile_text: Its TOML text, without them.
        calibrations: The calibrations in force.
        checks: What is kept of the checks whether they hold; None where none are kept.
        events: Where sessions tell what happens.
        views: Encodes views.
        journal_factory: Opens the journal of a session that takes the cell.
        versions: Version of everything that matters, by name.
        new_session_id: Returns a name for a session, unique on this machine.
    """

    def __init__(
        self,
        cell: ServedCell,
        script: Script,
        profile: Profile,
        *,
        events: EventBus,
        profile_text: str = "",
        calibrations: tuple[CalibrationRecord, ...] = (),
        checks: Checks | None = None,
        seed: int | None = None,
        journal_factory: Callable[[SessionStart], Journal] = _no_journal,
        versions: Mapping[str, str] | None = None,
        new_session_id: Callable[[], str] = _new_session_id,
    ) -> None:
        """Open the desk; the cell is free.

        Args:
            cell: The cell to lend.
            script: The script to serve.
            profile: The cell's profile, with the calibrations in force.
            events: Where sessions tell what happens.
            profile_text: The profile's TOML text without them, for recordings.
            calibrations: The calibrations in force.
            checks: What is kept of the checks whether they hold.
            seed: Seed of the first session, from which those of the others follow; a
                random one unless given.
            journal_factory: Opens the journal of a session that takes the cell.
            versions: Version of everything that matters, by name, for recordings.
            new_session_id: Returns a name for a session, unique on this machine.
        """
        self.cell = cell
        self.script = script
        self.profile = profile
        self.profile_text = profile_text
        self.calibrations = calibrations
        self.checks = checks
        self.events = events
        self.views = ViewEncoder()
        self.journal_factory = journal_factory
        self.versions = dict(versions or {})
        self.new_session_id = new_session_id
        self._seeds = SeedSequence(random_seed() if seed is None else seed)
        self._lock = threading.Lock()
        self._holder: object | None = None
        self._is_asleep = False
        self._is_wanted = False

    @property
    def is_wanted(self) -> bool:
        """Whether somebody asked for the cell while another one has it."""
        return self._is_wanted

    @property
    def is_asleep(self) -> bool:
        """Whether new connections are turned away."""
        return self._is_asleep

    @property
    def is_taken(self) -> bool:
        """Whether a session has the cell, or it is still being cleaned up after one."""
        return self._holder is not None

    def sleep(self) -> None:
        """Turn new connections away from now on."""
        self._is_asleep = True
        _log.info("asleep: new connections are turned away")

    def is_taken_from(self, who: object) -> bool:
        """Return whether anybody else has the cell."""
        holder = self._holder
        is_others = holder is not None and holder is not who
        self._is_wanted = self._is_wanted or is_others
        return is_others

    def take(self, who: object) -> bool:
        """Give the cell to `who` if it is free, or already theirs; return whether it is theirs."""
        with self._lock:
            if self._holder is None:
                self._holder = who
                self._is_wanted = False
            is_theirs = self._holder is who
            self._is_wanted = self._is_wanted or not is_theirs
            return is_theirs

    def give_back(self, who: object) -> None:
        """Take the cell back from `who`; harmless if they do not have it."""
        with self._lock:
            if self._holder is who:
                self._holder = None

    def next_seed(self) -> int:
        """Return the seed of the next session that takes the cell."""
        return self._seeds.next_seed()
