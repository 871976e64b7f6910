"""The ledger: where every block is, on disk, so that a killed program can clean up.

Each transfer is written before the fingers touch the block (`planned`), when
they hold it (`gripped`), before they let it go over its place (`placing`), and when
it lies there (the transfer is closed and the place updated in one transaction).
After a crash there is at most one open transfer; its phase and the gripper's opening
tell where the block is. A block that fell from the fingers on the way is a stray: it
stays in the ledger until it is found.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cell.errors import LedgerError
from cell.kept_database import advice
from cell.store import TablePlace

Phase = Literal["planned", "gripped", "placing"]

_SCHEMA = """
CREATE TABLE IF NOT EXISTS whereabouts (
    slot INTEGER PRIMARY KEY, x_mm REAL NOT NULL, y_mm REAL NOT NULL, yaw_deg REAL NOT NULL
);
CREATE TABLE IF NOT EXISTS transfer (
    only INTEGER PRIMARY KEY CHECK (only = 1),
    slot INTEGER NOT NULL, phase TEXT NOT NULL,
    from_x_mm REAL, from_y_mm REAL, from_yaw_deg REAL,
    to_x_mm REAL, to_y_mm REAL, to_yaw_deg REAL
);
CREATE TABLE IF NOT EXISTS strays (slot INTEGER PRIMARY KEY);
"""

_IF_DAMAGED = "move the file away and put leftover blocks back by hand"


@dataclass(frozen=True, slots=True, kw_only=True)
class Transfer:
    """A transfer that was begun; `None` for a place means the block's own slot."""

    slot: int
    source: TablePlace | None
    target: TablePlace | None
    phase: Phase


class Ledger:
    """Knows which blocks are out of the store, and where."""

    def __init__(self, path: Path | None) -> None:
        """Open the ledger.

        Args:
            path: The SQLite file, made if missing; None keeps it in memory.

        Raises:
            LedgerError: The file cannot be opened or is no ledger.
        """
        self._name = "memory" if path is None else str(path)
        try:
            with ExitStack() as opened:
                self._database = sqlite3.connect(
                    ":memory:" if path is None else path,
                    isolation_level=None,
                    check_same_thread=False,
                )
                opened.callback(self._database.close)
                self._database.execute("PRAGMA journal_mode = WAL")
                self._database.execute("PRAGMA synchronous = NORMAL")
                self._database.executescript(_SCHEMA)
                opened.pop_all()
        except sqlite3.Error as error:
            raise LedgerError(
                f"the ledger {self._name} cannot be opened ({error}); "
                + advice(error, if_damaged=_IF_DAMAGED)
            ) from error

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def blocks_out(self) -> dict[int, TablePlace]:
        """Return the blocks that lie outside their slots, by slot number."""
        with self._errors():
            rows = self._database.execute(
                "SELECT slot, x_mm, y_mm, yaw_deg FROM whereabouts ORDER BY slot"
            ).fetchall()
        return {slot: TablePlace(x_mm=x, y_mm=y, yaw_deg=yaw) for slot, x, y, yaw in rows}

    def open_transfer(self) -> Transfer | None:
        """Return the transfer that was begun and not finished, if there is one."""
        with self._errors():
            row = self._database.execute(
                "SELECT slot, phase, from_x_mm, from_y_mm, from_yaw_deg, "
                "to_x_mm, to_y_mm, to_yaw_deg FROM transfer"
            ).fetchone()
        if row is None:
            return None
        slot, phase, *places = row
        return Transfer(
            slot=slot, phase=phase, source=_place(places[:3]), target=_place(places[3:])
        )

    def plan(self, slot: int, source: TablePlace | None, target: TablePlace | None) -> None:
        """Note that a transfer begins; nothing was touched yet."""
        with self._errors():
            self._database.execute(
                "INSERT OR REPLACE INTO transfer VALUES (1, ?, 'planned', ?, ?, ?, ?, ?, ?)",
                (slot, *_columns(source), *_columns(target)),
            )

    def gripped(self) -> None:
        """Note that the fingers hold the block of the open transfer."""
        with self._errors():
            self._database.execute("UPDATE transfer SET phase = 'gripped'")

    def placing(self) -> None:
        """Note that the fingers stand at the target and are about to let the block go."""
        with self._errors():
            self._database.execute("UPDATE transfer SET phase = 'placing'")

    def lost(self, slot: int) -> None:
        """Note that a block is neither where it was nor between the fingers."""
        with self._errors():
            self._database.execute("BEGIN IMMEDIATE")
            self._database.execute("DELETE FROM transfer")
            self._database.execute("DELETE FROM whereabouts WHERE slot = ?", (slot,))
            self._database.execute("INSERT OR REPLACE INTO strays VALUES (?)", (slot,))
            self._database.execute("COMMIT")

    def strays(self) -> tuple[int, ...]:
        """Return the slot numbers of the blocks that were lost and not found yet."""
        with self._errors():
            rows = self._database.execute("SELECT slot FROM strays ORDER BY slot").fetchall()
        return tuple(slot for (slot,) in rows)

    def released(self, slot: int, place: TablePlace | None) -> None:
        """Note that a block lies at a place (None: its slot); closes the transfer."""
        with self._errors():
            self._database.execute("BEGIN IMMEDIATE")
            self._database.execute("DELETE FROM transfer")
            self._database.execute("DELETE FROM whereabouts WHERE slot = ?", (slot,))
            self._database.execute("DELETE FROM strays WHERE slot = ?", (slot,))
            if place is not None:
                self._database.execute(
                    "INSERT INTO whereabouts VALUES (?, ?, ?, ?)", (slot, *_columns(place))
                )
            self._database.execute("COMMIT")

    def abandon(self) -> None:
        """Note that the open transfer never touched its block."""
        with self._errors():
            self._database.execute("DELETE FROM transfer")

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            self._roll_back()
            raise LedgerError(
                f"the ledger {self._name} cannot be used ({error}); "
                + advice(error, if_damaged=_IF_DAMAGED)
            ) from error

    def _roll_back(self) -> None:
        """Leave no transaction half open, where there still is a database."""
        with suppress(sqlite3.Error):
            self._database.execute("ROLLBACK")


def _columns(place: TablePlace | None) -> tuple[float | None, float | None, float | None]:
    return (None, None, None) if place is None else (place.x_mm, place.y_mm, place.yaw_deg)


def _place(columns: list[float | None]) -> TablePlace | None:
    x_mm, y_mm, yaw_deg = columns
    if x_mm is None or y_mm is None or yaw_deg is None:
        return None
    return TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg)
