"""Reports on their way: kept on disk until their tracker has them, each sent once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cell.watchdog.history import History
from cell.watchdog.report import Report, ReportUndelivered
from cell.watchdog.reporters.base import Reporter
from cell.watchdog.stored import UnreadableReport, read_report, write_report

FIRST_PAUSE_S = 60.0
LONGEST_PAUSE_S = 3600.0
PAUSE_AFTER_REFUSAL_S = 6 * 3600.0
"""A tracker that refuses a report waits for somebody to change the settings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outgoing:
    """A report and how far it is on its way to one tracker.

    Attributes:
        fault: Number of the fault.
        reporter: Name of the tracker.
        attempts: How often it was tried.
        reference: What the tracker calls it, empty until it has it.
        problem: Why the last attempt failed, empty if it did not.
        is_done: Whether the tracker has all of it.
    """

    fault: int
    reporter: str
    attempts: int
    reference: str
    problem: str
    is_done: bool


class Outbox:
    """Sends what waits, with pauses that grow while a tracker is down.

    Args:
        history: Where the reports are kept.
        reporters: The trackers.
        now_s: Seconds of the wall clock, so that pauses outlive a restart.
    """

    def __init__(
        self, history: History, reporters: Sequence[Reporter], now_s: Callable[[], float]
    ) -> None:
        self._history = history
        self._reporters = {reporter.name: reporter for reporter in reporters}
        self._now_s = now_s

    def put(self, report: Report) -> None:
        """Keep a report for every tracker; it is sent by `deliver`."""
        stored = write_report(report)
        with self._history.transaction() as database:
            for name in self._reporters:
                database.execute(
                    "INSERT OR IGNORE INTO outgoing (fault, reporter, report) VALUES (?, ?, ?)",
                    (report.number, name, stored),
                )

    def hurry(self) -> None:
        """Let everything that waits be due now."""
        with self._history.transaction() as database:
            database.execute("UPDATE outgoing SET due_s = 0 WHERE is_done = 0")

    def deliver(self) -> int:
        """Try to send whatever is due; return how many reports arrived.

        Never raises for a tracker that is down or refuses: the report waits.
        """
        return sum(self._deliver_to(name, tracker) for name, tracker in self._reporters.items())

    def next_due_s(self) -> float | None:
        """Return when, on the wall clock, the next report is due; None if none waits."""
        with self._history.transaction() as database:
            row = database.execute(
                "SELECT reporter, min(due_s) FROM outgoing WHERE is_done = 0 "
                f"AND reporter IN ({','.join('?' * len(self._reporters))})",
                tuple(self._reporters),
            ).fetchone()
        return None if row[1] is None else float(row[1])

    def waiting(self) -> list[Outgoing]:
        """Return all reports and how far they are, oldest first."""
        with self._history.transaction() as database:
            rows = database.execute(
                "SELECT fault, reporter, attempts, reference, problem, is_done "
                "FROM outgoing ORDER BY fault, reporter"
            ).fetchall()
        return [
            Outgoing(
                fault=fault, reporter=reporter, attempts=attempts, reference=reference,
                problem=problem, is_done=bool(is_done),
            )
            for fault, reporter, attempts, reference, problem, is_done in rows
        ]  # fmt: skip

    def _deliver_to(self, name: str, tracker: Reporter) -> int:
        with self._history.transaction() as database:
            due = database.execute(
                "SELECT fault, report, attempts, reference, attached FROM outgoing "
                "WHERE reporter = ? AND is_done = 0 AND due_s <= ? ORDER BY fault",
                (name, self._now_s()),
            ).fetchall()
        arrived = 0
        for fault, stored, attempts, reference, attached in due:
            if not self._claim(name, fault, attempts):
                continue  # Another process sends it.
            try:
                self._send(tracker, fault, read_report(stored), attempts, reference, attached)
            except UnreadableReport as error:
                self._postpone(name, fault, attempts, ReportUndelivered(str(error), is_final=True))
            except ReportUndelivered as error:
                self._postpone(name, fault, attempts, error)
                if not error.is_final:
                    break  # It is down: the others would only wait for the same time-out.
            else:
                arrived += 1
        return arrived

    def _claim(self, name: str, fault: int, attempts: int) -> bool:
        """Take a report for sending; return whether no other process has taken it first.

        A claim is an attempt counted and a pause, so that a process that dies leaves it due.
        """
        with self._history.transaction() as database:
            taken = database.execute(
                "UPDATE outgoing SET attempts = ?, due_s = ? "
                "WHERE reporter = ? AND fault = ? AND attempts = ? AND is_done = 0 AND due_s <= ?",
                (
                    attempts + 1, self._now_s() + FIRST_PAUSE_S,
                    name, fault, attempts, self._now_s(),
                ),
            )  # fmt: skip
        return taken.rowcount == 1

    def _send(
        self,
        tracker: Reporter,
        fault: int,
        report: Report,
        attempts: int,
        reference: str,
        attached: int,
    ) -> None:
        if not reference:
            reference = tracker.file(report, may_be_known=attempts > 0)
            self._set(tracker.name, fault, "reference = ?", reference)
        if tracker.attaches:
            for index, attachment in enumerate(report.attachments):
                if index >= attached:
                    tracker.attach(reference, attachment, may_be_known=attempts > 0)
                    self._set(tracker.name, fault, "attached = ?", index + 1)
        self._set(tracker.name, fault, "is_done = 1, problem = ?", "")

    def _postpone(self, name: str, fault: int, attempts: int, error: ReportUndelivered) -> None:
        pause_s = min(FIRST_PAUSE_S * 2.0 ** min(attempts, 12), LONGEST_PAUSE_S)
        if error.is_final:
            pause_s = PAUSE_AFTER_REFUSAL_S
        with self._history.transaction() as database:
            database.execute(
                "UPDATE outgoing SET problem = ?, attempts = ?, due_s = ? "
                "WHERE reporter = ? AND fault = ?",
                (str(error), attempts + 1, self._now_s() + pause_s, name, fault),
            )
            if not error.is_final:
                # A tracker that is down gets nothing at all until the pause is over.
                database.execute(
                    "UPDATE outgoing SET due_s = max(due_s, ?) WHERE reporter = ? AND is_done = 0",
                    (self._now_s() + pause_s, name),
                )

    def _set(self, name: str, fault: int, what: str, value: object) -> None:
        with self._history.transaction() as database:
            database.execute(
                f"UPDATE outgoing SET {what} WHERE reporter = ? AND fault = ?", (value, name, fault)
            )
