"""Puts a cell's watchdog together: its history, its trackers, its evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from cell.clock import Clock
from cell.robot_cell import RobotCell
from cell.watchdog import CalibrationCheck, History, Outbox, Watchdog, WireLog
from cell.watchdog.reporters import reporters_of
from cell.watchdog.watchdog import Lend
from sessions.desk import Desk

HISTORY_FILE = "watchdog.sqlite"


@dataclass(frozen=True, slots=True)
class Watch:
    """A watchdog and what it keeps; `close` gives the files back."""

    watchdog: Watchdog
    history: History
    outbox: Outbox

    def close(self) -> None:
        """Close the history."""
        self.history.close()


def watch(
    cell: RobotCell,
    lend: Lend,
    folder: Path | None,
    clock: Clock,
    *,
    wire: WireLog,
    versions: Mapping[str, str],
    calibrations: CalibrationCheck | None = None,
    is_wanted: Callable[[], bool] = lambda: False,
    wall_clock: Callable[[], datetime] = lambda: datetime.now(UTC),
) -> Watch:
    """Return the watchdog of a cell.

    Args:
        cell: The cell.
        lend: Gives the cell for a round, or says that a session has it.
        folder: The cell's state folder; None keeps the history in memory.
        clock: Tells when rounds are due.
        wire: The tap that the cell was assembled with.
        versions: Version of everything that matters.
        calibrations: Checks whether the cell's calibrations still hold; None checks none.
        is_wanted: Says whether somebody waits for the cell.
        wall_clock: Tells the date.

    Raises:
        HistoryError: The history cannot be opened.
    """
    history = open_history(folder, wall_clock())
    outbox = Outbox(history, reporters_of(cell.profile.reports), lambda: wall_clock().timestamp())
    watchdog = Watchdog(
        cell,
        lend,
        history,
        outbox,
        wall_clock,
        clock,
        wire=wire,
        versions=versions,
        calibrations=calibrations,
        is_wanted=is_wanted,
    )
    return Watch(watchdog, history, outbox)


def open_history(folder: Path | None, now: datetime) -> History:
    """Return the history that a state folder holds, a new one if there is none.

    Raises:
        HistoryError: It cannot be opened.
    """
    path = None if folder is None else folder / HISTORY_FILE
    return History(path, started=now.isoformat(timespec="microseconds"))


def lend_from(desk: Desk) -> Lend:
    """Return what lends the cell of a desk: never while a session has it."""

    @contextmanager
    def lend() -> Iterator[bool]:
        who = object()
        is_mine = desk.take(who)
        try:
            yield is_mine
        finally:
            if is_mine:
                desk.give_back(who)

    return lend
