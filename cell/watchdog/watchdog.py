"""When tests are due, what they find, and what becomes of it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from datetime import datetime

from cell.clock import Clock
from cell.devices.camera import Frame
from cell.errors import CellError, ResumeRefused, Stopped
from cell.events import ComponentTested
from cell.robot_cell import RobotCell
from cell.watchdog.calibrations import CalibrationCheck, CannotTell, calibration_tests
from cell.watchdog.components import ComponentTest, component_tests
from cell.watchdog.evidence import Evidence, WireLog, gather
from cell.watchdog.history import History, Outcome, TestRecord
from cell.watchdog.outbox import Outbox
from cell.watchdog.report import Report, alias_of, cause_of

_log = logging.getLogger(__name__)

RETRY_BUSY_S = 60.0
"""When a round was due while a session had the cell, it is tried again after this long."""

Lend = Callable[[], AbstractContextManager[bool]]
"""Gives the cell for a round: true if it was free, and then nobody else has it."""


@dataclass(frozen=True, slots=True)
class Round:
    """One pass over all components; empty when a session had the cell."""

    records: tuple[TestRecord, ...]

    @property
    def failed(self) -> tuple[TestRecord, ...]:
        """The tests that failed."""
        return tuple(record for record in self.records if record.outcome == "failed")


class Watchdog:
    """Tests the cell when nobody has it, and files what fails.

    Args:
        cell: The cell.
        lend: Gives the cell for a round, or says that a session has it.
        history: Where outcomes and faults are kept.
        outbox: Where reports wait for their trackers.
        wall_clock: Tells the date, UTC.
        clock: Tells when rounds are due: real time even where the cell's own time is simulated.
        wire: The tap of the cell's links, for evidence.
        versions: Version of everything that matters, for evidence.
        calibrations: Checks whether the cell's calibrations still hold; None checks none.
        is_wanted: Says whether somebody waits for the cell; a check of calibrations, which takes
            longest, is then given up.
    """

    def __init__(
        self,
        cell: RobotCell,
        lend: Lend,
        history: History,
        outbox: Outbox,
        wall_clock: Callable[[], datetime],
        clock: Clock,
        *,
        wire: WireLog,
        versions: Mapping[str, str],
        calibrations: CalibrationCheck | None = None,
        is_wanted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._cell = cell
        self._lend = lend
        self._history = history
        self._outbox = outbox
        self._wall_clock = wall_clock
        self._clock = clock
        self._wire = wire
        self._versions = dict(versions)
        self._calibrations = calibrations
        self._is_wanted = is_wanted
        self._every_s = cell.profile.watchdog.every_s
        self._next_s = clock.now_s() + self._every_s
        self._stop_asked = False

    def stop(self) -> None:
        """Ask a round under way to end after the test that runs."""
        self._stop_asked = True

    def tests(self) -> tuple[ComponentTest, ...]:
        """Return the tests of a round, in their order."""
        tests = component_tests(self._cell)
        if self._calibrations is None:
            return tests
        return (*tests, *calibration_tests(self._cell, self._calibrations, self._go_on))

    def step(self) -> float:
        """Do what is due, tests and reports; return after how many seconds to come again."""
        clock = self._clock
        if clock.now_s() >= self._next_s:
            if self.run_round() is None:
                self._next_s = clock.now_s() + RETRY_BUSY_S
            else:
                # From one due time to the next, so that the hours of the rounds do not drift.
                self._next_s = max(self._next_s + self._every_s, clock.now_s())
        self._outbox.deliver()
        wait_s = max(self._next_s - clock.now_s(), 0.0)
        due_s = self._outbox.next_due_s()
        if due_s is None:
            return wait_s
        return min(wait_s, max(due_s - self._wall_clock().timestamp(), 1.0))

    def run_round(self, only: Collection[str] = ()) -> Round | None:
        """Test now; None if a session has the cell.

        Args:
            only: Components to test, and what they need; all unless given.
        """
        with self._lend() as is_mine:
            if not is_mine:
                return None
            number = self._history.next_round()
            records: list[TestRecord] = []
            failed: set[str] = set()
            tests = self.tests()
            wanted = set(only).union(*(test.needs for test in tests if test.component in only))
            for test in tests:
                if self._stop_asked:
                    break
                if only and test.component not in wanted:
                    continue
                record = self._test(test, number, failed)
                if record.outcome != "ok":
                    failed.add(test.component)
                records.append(record)
        return Round(tuple(records))

    def _test(self, test: ComponentTest, number: int, failed: Collection[str]) -> TestRecord:
        missing = [component for component in test.needs if component in failed]
        if missing:
            return self._note(test, number, "not tested", f"it needs the {missing[0]}")
        frames: list[Frame] = []
        self._wire.begin()
        try:
            seen = test.run(self._cell, frames)
        except Stopped as error:
            self._wire.end()
            return self._note(test, number, "not tested", f"stopped: {error}")
        except ResumeRefused as error:
            # The arm is held after an earlier fault, which was told when it happened; that it
            # may go on is for people to say.
            self._wire.end()
            return self._note(test, number, "not tested", str(error))
        except CannotTell as error:
            # Neither a fault nor a sign that an earlier one is gone.
            self._wire.end()
            return self._note(test, number, "cannot tell", str(error))
        except CellError as error:
            evidence = gather(self._wire.end(), frames, self._versions)
            self._report(test, error, evidence)
            return self._note(test, number, "failed", str(error))
        self._wire.end()
        self._history.works(test.component, self._now())
        return self._note(test, number, "ok", seen)

    def _note(self, test: ComponentTest, number: int, outcome: Outcome, detail: str) -> TestRecord:
        record = TestRecord(
            round=number,
            time=self._now(),
            component=test.component,
            outcome=outcome,
            detail=detail,
        )
        self._history.note(record, self._cell.profile.watchdog.keep)
        self._cell.events.emit(ComponentTested(test.component, outcome == "ok", detail))
        level = logging.INFO if outcome == "ok" else logging.WARNING
        _log.log(level, "watchdog: %s %s: %s", test.component, outcome, detail)
        return record

    def _report(self, test: ComponentTest, error: CellError, evidence: Evidence) -> None:
        """Note the fault and, if it is new, put its report into the outbox, both or neither."""
        time = self._now()
        name = self._cell.profile.name
        summary = " ".join(f"{name}: {test.component}: {error}".split())
        with self._history.transaction():
            number = self._history.failed(
                cause_of(test.component, error), test.component, summary, time
            )
            if number is not None:
                self._outbox.put(
                    Report(
                        number=number,
                        alias=alias_of(name, self._history.started, number),
                        cell=name,
                        component=test.component,
                        summary=summary,
                        description=_describe(name, test, error, evidence, time),
                        attachments=evidence.attachments(),
                    )
                )

    def _go_on(self) -> None:
        """Return if a long test may go on.

        Raises:
            Stopped: The round shall end, or somebody waits for the cell.
        """
        if self._stop_asked:
            raise Stopped("the watchdog shall end")
        if self._is_wanted():
            raise Stopped("a client asks for the cell")

    def _now(self) -> str:
        return self._wall_clock().isoformat(timespec="seconds")


def _describe(
    cell: str, test: ComponentTest, error: CellError, evidence: Evidence, time: str
) -> str:
    versions = "\n".join(f"  {name} {version}" for name, version in evidence.versions.items())
    last = "\n".join(evidence.wire.splitlines()[-20:])
    return (
        f"The watchdog of the cell {cell} found that {test.component} fails.\n\n"
        f"{error}\n\nFirst seen: {time} (UTC)\n\n"
        f"The last messages on the wires:\n{last or '  none'}\n\nVersions:\n{versions}\n"
    )
