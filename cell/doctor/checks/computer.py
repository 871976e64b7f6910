"""The computer around a cell: lock, folders, disk, clock, the server's port."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from cell.doctor.environment import Environment, nearest_existing
from cell.doctor.notes import Notes
from cell.errors import StillHeld
from cell.kept_database import advice, is_damaged
from cell.lock import CellLock
from cell.profile import Profile

LEAST_FREE_BYTES = 1_000_000_000
"""Below this a disk counts as nearly full: a long session with pictures takes some 500 MB."""

_EARLIEST = datetime(2025, 1, 1, tzinfo=UTC)
_LATEST_YEARS = 30
_LOCKED_S = 0.5
"""How long a database that another program writes is waited for."""

_AHEAD_S = 120.0
"""A record this far ahead of the clock may still be a file system's rounding."""


def check_lock(environment: Environment, notes: Notes) -> None:
    """Look whether another process has the cell."""
    folder = environment.state_folder
    if folder is None or not folder.is_dir() or not os.access(folder, os.W_OK):
        return
    try:
        CellLock(folder).release()
    except StillHeld as error:
        notes.find("cell-in-use", "computer", "another program has this cell", str(error))
    else:
        notes.fine("computer", "no other program has the cell")


def check_folders(environment: Environment, notes: Notes) -> None:
    """Look whether state and recordings can be written, and how much space is left."""
    named = (
        ("state-folder-unwritable", "state folder", environment.state_folder),
        ("recordings-unwritable", "recordings folder", environment.recordings_folder),
    )
    least = ("", LEAST_FREE_BYTES)
    for cause, words, folder in named:
        if folder is None:
            notes.skip("computer", words, "nothing is kept there")
            continue
        trouble = _why_unwritable(folder)
        if trouble:
            notes.find(cause, "computer", f"the {words} {folder} cannot be written", trouble)
            continue
        notes.fine("computer", f"the {words} can be written")
        free = environment.free_bytes(folder)
        if free < least[1]:
            least = (str(folder), free)
    if least[0]:
        problem = f"only {least[1] / 1e6:.0f} MB are free where {least[0]} lies"
        wanted = f"{least[1]} bytes free, at least {LEAST_FREE_BYTES} wanted"
        notes.find("disk-nearly-full", "computer", problem, wanted)


def check_kept(environment: Environment, notes: Notes) -> None:
    """Look whether ledger, history and world file can be read; none is written or made."""
    folder = environment.state_folder
    if folder is None:
        return
    ledger = folder / "ledger.sqlite"
    if ledger.exists():
        queries = (
            "SELECT slot, x_mm, y_mm, yaw_deg FROM whereabouts",
            "SELECT slot, phase FROM transfer",
        )
        fault = _database_fault(ledger, queries)
        if fault is None:
            notes.fine("store", "the ledger can be read")
        else:
            cause = "ledger-unreadable" if fault.is_damaged else "ledger-out-of-reach"
            fix = "" if fault.is_damaged else fault.fix
            notes.find(cause, "store", f"{ledger} cannot be read", fault.seen, fix=fix)
    _check_history(folder / "watchdog.sqlite", notes)
    trouble = environment.check_world()
    if trouble:
        notes.find("world-file-broken", "computer", "the twin's kept world is broken", trouble)


def check_clock(environment: Environment, notes: Notes) -> None:
    """Hold the date against what is possible and against the newest record."""
    now = environment.now()
    if now < _EARLIEST or now.year > _EARLIEST.year + _LATEST_YEARS:
        problem = f"the computer's date is {now:%Y-%m-%d}, which cannot be"
        notes.find("clock-implausible", "computer", problem, f"wall clock {now.isoformat()}")
        return
    newest = _newest_record(environment)
    if newest is not None and newest[0] > now.timestamp() + _AHEAD_S:
        record = datetime.fromtimestamp(newest[0], UTC)
        notes.find(
            "clock-behind-records",
            "computer",
            f"the clock says {now:%Y-%m-%d %H:%M}, and {newest[1].name} was written later",
            f"{newest[1]} is of {record.isoformat()}",
        )
    else:
        notes.fine("computer", f"the date is {now:%Y-%m-%d}")


class ClockWatch:
    """Notices that the wall clock jumped while the doctor worked."""

    TOLERANCE_S = 2.0
    """How far both clocks may part in an examination of a few minutes."""

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._wall = environment.now()
        self._steady_s = environment.steady_s()

    def judge(self, notes: Notes) -> None:
        """Write down a jump since the watch began."""
        passed_s = (self._environment.now() - self._wall).total_seconds()
        steady_s = self._environment.steady_s() - self._steady_s
        if abs(passed_s - steady_s) > self.TOLERANCE_S:
            problem = f"the clock jumped by {passed_s - steady_s:+.1f} s during the examination"
            facts = f"wall clock {passed_s:+.1f} s, steady clock {steady_s:+.1f} s"
            notes.find("clock-jumped", "computer", problem, facts)


def check_server_port(profile: Profile, environment: Environment, notes: Notes) -> None:
    """Look whether the server could listen at its address."""
    host, port = profile.server.host, profile.server.port
    if port == 0:
        notes.skip("computer", "server port", "the server takes any free one")
        return
    state = environment.server_port(host, port)
    if state.is_free:
        notes.fine("computer", f"the server's port {port} is free")
    else:
        problem = f"the server cannot listen at {host}:{port}"
        notes.find("server-port-taken", "computer", problem, state.seen)


def _why_unwritable(folder: Path) -> str:
    """Return why a folder cannot be written, empty if it can or can be made."""
    existing = nearest_existing(folder)
    if not existing.is_dir():
        return f"{existing} is a file"
    if not os.access(existing, os.W_OK | os.X_OK):
        return f"{existing} may not be written by user {os.getuid()}"
    return ""


def _check_history(path: Path, notes: Notes) -> None:
    """Look whether the watchdog's history can be read, if there is one."""
    if not path.exists():
        return
    fault = _database_fault(path, ("SELECT started FROM about", "SELECT fault FROM outgoing"))
    if fault is None:
        notes.fine("computer", "the watchdog's history can be read")
        return
    problem = f"{path} cannot be read; the reports that wait to be sent are in it"
    fix = "" if fault.is_damaged else fault.fix
    notes.find("watchdog-history-unreadable", "computer", problem, fault.seen, fix=fix)


@dataclass(frozen=True, slots=True, kw_only=True)
class _DatabaseFault:
    """Why a kept database cannot be read."""

    seen: str
    is_damaged: bool
    fix: str = ""


def _database_fault(path: Path, queries: Sequence[str]) -> _DatabaseFault | None:
    """Return why a database cannot be read, None if it can; nothing is written."""
    try:
        database = sqlite3.connect(
            f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=_LOCKED_S
        )
        try:
            for query in queries:
                database.execute(query).fetchall()
            (verdict,) = database.execute("PRAGMA quick_check(1)").fetchone()
        finally:
            database.close()
    except sqlite3.Error as error:
        return _DatabaseFault(
            seen=f"SQLite says: {error}",
            is_damaged=is_damaged(error),
            fix=advice(error, if_damaged=""),
        )
    if verdict == "ok":
        return None
    return _DatabaseFault(seen=f"SQLite's check says: {verdict}", is_damaged=True)


def _newest_record(environment: Environment) -> tuple[float, Path] | None:
    """Return time and path of the newest file of state and recordings; None without any."""
    newest: tuple[float, Path] | None = None
    for folder in (environment.state_folder, environment.recordings_folder):
        if folder is None or not folder.is_dir() or not os.access(folder, os.R_OK | os.X_OK):
            continue
        for path in folder.iterdir():
            # The doctor itself has just touched the lock.
            if path.name != "lock" and path.is_file():
                written_s = path.stat().st_mtime
                if newest is None or written_s > newest[0]:
                    newest = (written_s, path)
    return newest
