"""A file that is damaged is moved away; one that is only out of reach is kept."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from cell.errors import CellError
from cell.kept_database import advice, is_damaged
from cell.ledger import Ledger
from cell.store import TablePlace
from cell.watchdog.history import History, TestRecord

THERE = TablePlace(x_mm=600.0, y_mm=10.0, yaw_deg=0.0)
OPENERS: dict[str, Callable[[Path], object]] = {
    "ledger": Ledger,
    "history": lambda path: History(path, started="2026-11-22T07:00:00Z"),
}


def error_with(code: int, text: str) -> sqlite3.Error:
    error = sqlite3.OperationalError(text)
    error.sqlite_errorcode = code
    return error


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (sqlite3.SQLITE_FULL, "free space"),
        (sqlite3.SQLITE_IOERR, "free space"),
        (sqlite3.SQLITE_IOERR_WRITE, "free space"),
        (sqlite3.SQLITE_BUSY, "stop the other program"),
        (sqlite3.SQLITE_LOCKED, "stop the other program"),
        (sqlite3.SQLITE_READONLY, "user who runs the cell"),
        (sqlite3.SQLITE_READONLY_DIRECTORY, "user who runs the cell"),
        (sqlite3.SQLITE_CANTOPEN, "user who runs the cell"),
    ],
)
def test_a_file_out_of_reach_is_kept(code: int, words: str) -> None:
    error = error_with(code, "what SQLite says")
    told = advice(error, if_damaged="move it away")
    assert words in told
    assert "intact" in told
    assert "move it away" not in told
    assert not is_damaged(error)


@pytest.mark.parametrize("code", [sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT])
def test_a_damaged_file_is_moved_away(code: int) -> None:
    assert advice(error_with(code, "malformed"), if_damaged="move it away") == "move it away"


@pytest.mark.parametrize("kind", OPENERS)
def test_text_for_a_database_is_moved_away(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "kept.sqlite"
    path.write_bytes(b"no database, but long enough to be looked at" * 40)
    with pytest.raises(CellError, match="move the file away"):
        OPENERS[kind](path)


@pytest.mark.parametrize("kind", OPENERS)
def test_a_folder_for_a_database_is_no_reason_to_throw_it_away(kind: str, tmp_path: Path) -> None:
    with pytest.raises(CellError, match=r"cannot be opened .*keep the file") as caught:
        OPENERS[kind](tmp_path)
    assert "move" not in str(caught.value)


def test_a_full_disk_in_the_midst_of_work_asks_for_space_and_keeps_the_ledger(
    tmp_path: Path,
) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.plan(7, None, THERE)
    _fill(ledger._database)

    def go_on() -> None:
        for slot in range(10_000):
            ledger.released(slot, THERE)

    with pytest.raises(CellError, match=r"disk is full\); free space .* it is intact"):
        go_on()
    ledger.close()
    assert Ledger(tmp_path / "ledger.sqlite").blocks_out()


def test_a_full_disk_asks_for_space_and_keeps_the_history(tmp_path: Path) -> None:
    path = tmp_path / "watchdog.sqlite"
    history = History(path, started="2026-11-22T07:00:00Z")
    _fill(history._database)
    record = TestRecord(round=1, time="", component="arm", outcome="ok", detail="x" * 2000)

    def go_on() -> None:
        for _ in range(1000):
            history.note(record, 20)

    with pytest.raises(CellError, match=r"disk is full\); free space .* it is intact"):
        go_on()
    history.close()


def _fill(database: sqlite3.Connection) -> None:
    """Let the file grow no more, which SQLite tells as it tells of a full disk."""
    (pages,) = database.execute("PRAGMA page_count").fetchone()
    database.execute(f"PRAGMA max_page_count = {pages}")
