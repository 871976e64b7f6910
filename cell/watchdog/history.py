"""What the watchdog saw, on disk: test rounds, faults, and the reports that wait."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cell.errors import CellError
from cell.kept_database import advice

Outcome = Literal["ok", "failed", "not tested", "cannot tell"]

_SCHEMA = """
CREATE TABLE IF NOT EXISTS about (only INTEGER PRIMARY KEY CHECK (only = 1), started TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS test (
    id INTEGER PRIMARY KEY, round INTEGER NOT NULL, time TEXT NOT NULL,
    component TEXT NOT NULL, outcome TEXT NOT NULL, detail TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS fault (
    number INTEGER PRIMARY KEY AUTOINCREMENT, cause TEXT NOT NULL, component TEXT NOT NULL,
    summary TEXT NOT NULL, first TEXT NOT NULL, last TEXT NOT NULL, times INTEGER NOT NULL,
    ended TEXT
);
CREATE TABLE IF NOT EXISTS outgoing (
    fault INTEGER NOT NULL, reporter TEXT NOT NULL, report BLOB NOT NULL,
    attempts INTEGER NOT NULL DEFAULT 0, due_s REAL NOT NULL DEFAULT 0,
    reference TEXT NOT NULL DEFAULT '', attached INTEGER NOT NULL DEFAULT 0,
    problem TEXT NOT NULL DEFAULT '', is_done INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (fault, reporter)
);
"""

_IF_DAMAGED = "move the file away; reports that wait in it are then not sent"


class HistoryError(CellError):
    """The watchdog's history cannot be read or written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TestRecord:
    """The outcome of one test."""

    __test__ = False  # It is no test class, whatever its name.

    round: int
    time: str
    """When, UTC, ISO 8601."""
    component: str
    outcome: Outcome
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A cause of failed tests, from its first failure until its component works again."""

    number: int
    component: str
    summary: str
    first: str
    last: str
    times: int
    ended: str
    """When the component worked again; empty while it does not."""


class History:
    """The file that holds it; used by the watchdog's thread and by whoever looks."""

    def __init__(self, path: Path | None, *, started: str) -> None:
        """Open the history.

        Args:
            path: The SQLite file, made if missing; None keeps it in memory.
            started: When a new history starts, UTC.

        Raises:
            HistoryError: The file cannot be opened or is none.
        """
        self._name = "in memory" if path is None else str(path)
        self._lock = threading.RLock()
        self._depth = 0
        try:
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(
                ":memory:" if path is None else path, isolation_level=None, check_same_thread=False
            )
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.executescript(_SCHEMA)
            self._database.execute("INSERT OR IGNORE INTO about VALUES (1, ?)", (started,))
        except (sqlite3.Error, OSError) as error:
            raise HistoryError(
                f"the watchdog's history {self._name} cannot be opened ({error}); "
                + advice(error, if_damaged=_IF_DAMAGED)
            ) from error

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    @property
    def started(self) -> str:
        """When this history started: tells the histories of one cell apart."""
        with self.transaction() as database:
            return str(database.execute("SELECT started FROM about").fetchone()[0])

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Give the database for one transaction; everything in it happens, or nothing.

        One inside another belongs to the outer one.

        Raises:
            HistoryError: It cannot be read or written.
        """
        with self._lock:
            if self._depth:
                yield self._database
                return
            self._depth = 1
            try:
                self._database.execute("BEGIN IMMEDIATE")
                yield self._database
                self._database.execute("COMMIT")
            except sqlite3.Error as error:
                self._roll_back()
                raise HistoryError(
                    f"the watchdog's history {self._name} cannot be used ({error}); "
                    + advice(error, if_damaged=_IF_DAMAGED)
                ) from error
            except BaseException:
                self._roll_back()
                raise
            finally:
                self._depth = 0

    def next_round(self) -> int:
        """Return the number of the next round."""
        with self.transaction() as database:
            return int(database.execute("SELECT ifnull(max(round), 0) + 1 FROM test").fetchone()[0])

    def note(self, record: TestRecord, keep_rounds: int) -> None:
        """Keep the outcome of a test, and forget rounds that are too long ago."""
        with self.transaction() as database:
            database.execute(
                "INSERT INTO test (round, time, component, outcome, detail) VALUES (?, ?, ?, ?, ?)",
                (record.round, record.time, record.component, record.outcome, record.detail),
            )
            database.execute("DELETE FROM test WHERE round <= ?", (record.round - keep_rounds,))

    def tests(self, last_rounds: int = 20) -> list[TestRecord]:
        """Return the outcomes of the last rounds, oldest first."""
        with self.transaction() as database:
            rows = database.execute(
                "SELECT round, time, component, outcome, detail FROM test "
                "WHERE round > (SELECT ifnull(max(round), 0) FROM test) - ? ORDER BY id",
                (last_rounds,),
            ).fetchall()
        return [
            TestRecord(round=number, time=time, component=component, outcome=outcome, detail=detail)
            for number, time, component, outcome, detail in rows
        ]

    def faults(self) -> list[Fault]:
        """Return all faults, oldest first."""
        with self.transaction() as database:
            rows = database.execute(
                "SELECT number, component, summary, first, last, times, ifnull(ended, '') "
                "FROM fault ORDER BY number"
            ).fetchall()
        return [
            Fault(
                number=number, component=component, summary=summary,
                first=first, last=last, times=times, ended=ended,
            )
            for number, component, summary, first, last, times, ended in rows
        ]  # fmt: skip

    def failed(self, cause: str, component: str, summary: str, time: str) -> int | None:
        """Note a failure; return the number of the fault if it is a new one, else None."""
        with self.transaction() as database:
            known = database.execute(
                "SELECT number FROM fault WHERE cause = ? AND ended IS NULL", (cause,)
            ).fetchone()
            if known is not None:
                database.execute(
                    "UPDATE fault SET last = ?, times = times + 1 WHERE number = ?",
                    (time, known[0]),
                )
                return None
            cursor = database.execute(
                "INSERT INTO fault (cause, component, summary, first, last, times) "
                "VALUES (?, ?, ?, ?, ?, 1)",
                (cause, component, summary, time, time),
            )
            return cursor.lastrowid

    def works(self, component: str, time: str) -> None:
        """Note that a component works: its faults have ended."""
        with self.transaction() as database:
            database.execute(
                "UPDATE fault SET ended = ? WHERE component = ? AND ended IS NULL",
                (time, component),
            )

    def _roll_back(self) -> None:
        with suppress(sqlite3.Error):
            self._database.execute("ROLLBACK")
