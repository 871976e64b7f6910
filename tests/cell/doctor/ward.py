"""A twin on the doctor's table, and everything around it that a fault may be seeded in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.doctor import Component, PageState, Patient, PortState, Report, examine
from cell.doctor.learned import LearnedPicture, learn
from cell.doctor.meeting import patient_of_twin
from cell.doctor.patient import OpenLine
from cell.profile import Profile, load_profile
from cell.store import StorePlan
from cell.twin_cell import TwinCell
from console.scripts import load_script
from sessions.hosting import store_plan

NOW = datetime(2026, 11, 22, 7, 0, tzinfo=UTC)
VIEWS = ("top", "oblique", "gripper")


@cache
def mash() -> Profile:
    return load_profile("mash")


@cache
def mash_plan() -> StorePlan:
    return store_plan(load_script("mash"))


@cache
def healthy_pictures() -> Mapping[str, LearnedPicture]:
    cell = twin(mash())
    cell.open()
    return learn(cell)


def twin(profile: Profile, *, seed: int = 0, state_folder: Path | None = None) -> TwinCell:
    return assemble_twin(
        profile, mash_plan(), seed=seed, clock=SimulatedClock(), state_folder=state_folder
    )


@dataclass(kw_only=True)
class Surroundings:
    """A computer in good order, each of whose answers can be changed."""

    state_folder: Path | None = None
    recordings_folder: Path | None = None
    wall: Callable[[], datetime] = field(default=lambda: NOW)
    steady: Callable[[], float] = field(default=lambda: 100.0)
    free: int = 10**12
    port: PortState = field(default=PortState(is_free=True))  # noqa: RUF009
    page_told: PageState | None = None
    world_trouble: str = ""
    holder: str = ""

    def now(self) -> datetime:
        return self.wall()

    def steady_s(self) -> float:
        return self.steady()

    def free_bytes(self, folder: Path) -> int:
        return self.free

    def holder_of(self, port: str) -> str:
        return self.holder

    def server_port(self, host: str, port: int) -> PortState:
        return self.port

    def page(self) -> PageState | None:
        return self.page_told

    def check_world(self) -> str:
        return self.world_trouble


class Ward:
    """One examination: a twin, its patient record, its surroundings."""

    def __init__(
        self, profile: Profile | None = None, *, folder: Path | None = None, seed: int = 0
    ) -> None:
        self.profile = profile or mash()
        self.cell = twin(self.profile, seed=seed)
        self.folder = folder
        self.surroundings = Surroundings()
        self.learned: Mapping[str, LearnedPicture] = {}
        # Pictures take most of the time: only those have cameras who ask for them.
        self._changes: dict[str, object] = {"cameras": {}}
        self.to_close: list[Callable[[], None]] = []
        self.lines: dict[str, OpenLine] = {}

    @property
    def now_s(self) -> float:
        return self.cell.clock.now_s()

    @property
    def patient(self) -> Patient:
        patient = patient_of_twin(self.cell, views=VIEWS)
        lines = {**patient.lines, **self.lines}
        return replace(patient, lines=lines, **self._changes)  # type: ignore[arg-type]

    def in_service(self) -> Ward:
        self.cell.open()
        return self

    def with_pictures(self) -> Ward:
        self.learned = healthy_pictures()
        self._changes.pop("cameras", None)
        return self

    def believing(self, **changes: object) -> Ward:
        """Have the doctor believe something of the cell that may not be so."""
        self._changes.update(changes)
        if isinstance(profile := changes.get("profile"), Profile):
            self.profile = profile
        return self

    def line(self, device: str) -> OpenLine:
        return patient_of_twin(self.cell).lines[device]

    def examine(self, only: Component | None = None) -> Report:
        try:
            return examine(
                self.profile,
                self.surroundings,
                lambda: nullcontext(self.patient),
                only=only,
                learned=self.learned,
            )
        finally:
            for close in self.to_close:
                close()
            self.cell.dispose()


def years(count: float) -> timedelta:
    return timedelta(days=365.25 * count)
