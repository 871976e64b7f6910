"""A watchdog on a twin, its time, and the tracker's settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import BugzillaProfile, Profile, load_profile
from cell.store import StorePlan, StoreSlot
from cell.twin_cell import TwinCell
from cell.watchdog import History, Outbox, Watchdog, WireLog
from cell.watchdog.reporters.base import Reporter
from cell.watchdog.reporters.bugzilla import Bugzilla
from tests.cell.watchdog.bugzilla import KEY, BugzillaStandIn

START = datetime(2026, 1, 5, 6, 0, tzinfo=UTC)
PLAN = StorePlan((StoreSlot(number=7, kind="cube", colour="red", x_mm=165.0, y_mm=150.0),))


class Rig:
    """A twin with a watchdog; wall clock and cell's clock are one."""

    def __init__(
        self,
        *reporters: Reporter,
        path: Path | None = None,
        profile: Profile | None = None,
        seed: int = 1,
    ) -> None:
        self.clock = SimulatedClock()
        self.wire = WireLog(self.clock)
        self.cell: TwinCell = assemble_twin(
            profile or load_profile("mash"), PLAN, seed=seed, clock=self.clock, tap=self.wire
        )
        self.is_free = True
        self.history = History(path, started=START.isoformat())
        self.outbox = Outbox(self.history, reporters, lambda: self.wall_clock().timestamp())
        self.watchdog = Watchdog(
            self.cell,
            self._lend,
            self.history,
            self.outbox,
            self.wall_clock,
            self.clock,
            wire=self.wire,
            versions={"robocell": "0.1"},
        )

    def wall_clock(self) -> datetime:
        return START + timedelta(seconds=self.clock.now_s())

    def pass_hours(self, hours: float, step: Callable[[], float] | None = None) -> None:
        """Let time pass as the watchdog's thread does: sleep as long as it says, and step."""
        end_s = self.clock.now_s() + 3600.0 * hours
        while self.clock.now_s() < end_s:
            wait_s = (step or self.watchdog.step)()
            self.clock.sleep(min(wait_s, end_s - self.clock.now_s()))

    def stored_reports(self) -> list[bytes]:
        with self.history.transaction() as database:
            rows = database.execute("SELECT report FROM outgoing ORDER BY fault").fetchall()
        return [bytes(row[0]) for row in rows]

    @contextmanager
    def _lend(self) -> Iterator[bool]:
        yield self.is_free


def bugzilla_at(
    stand_in: BugzillaStandIn, environment: Mapping[str, str] | None = None, **fields: str
) -> Bugzilla:
    profile = BugzillaProfile(
        url=stand_in.url,
        product=fields.get("product", "Robots"),
        component=fields.get("component", "Cell"),
        timeout_s=float(fields.get("timeout_s", 2.0)),
    )
    return Bugzilla(profile, {profile.key_variable: KEY} if environment is None else environment)
