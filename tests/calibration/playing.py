"""Plays a procedure on a twin whose truth is hidden, or on answers alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from calibration.catalogue import Site
from calibration.errors import AnswerRefused
from calibration.hands import CellHands
from calibration.player import Hands, play
from calibration.procedure import Procedure
from calibration.record import CalibrationRecord, Measurement
from calibration.requests import Answer, Ask, Point, Request, Value
from cell.assembly.twin import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile
from cell.stop import StopToken
from cell.store import StorePlan
from cell.twin_cell import TwinCell

Watcher = Callable[[Request], None]


class Answers:
    """Answers questions from a table, else with their defaults; notes what was asked."""

    def __init__(self, answers: Mapping[str, Value | tuple[float, float]]) -> None:
        self._answers = dict(answers)
        self.asked: list[str] = []

    def answer(self, ask: Ask) -> Answer:
        self.asked.append(ask.key)
        if ask.key in self._answers:
            return self._answers[ask.key]
        if ask.kind == "done":
            return True
        if ask.default is None:
            raise AnswerRefused(ask.key, "the test gives no answer")
        return ask.default

    def point(self, point: Point) -> Answer:
        self.asked.append(point.key)
        return self._answers[point.key]


class NoHands:
    """Hands of a procedure that may ask for nothing."""

    def perform(self, request: Request) -> Answer:
        raise AssertionError(f"asked for {type(request).__name__}")


class WatchedHands:
    """Hands that let a test meddle before and after each request."""

    def __init__(self, hands: Hands, before: Watcher | None, after: Watcher | None) -> None:
        self._hands, self._before, self._after = hands, before, after

    def perform(self, request: Request) -> Answer:
        if self._before is not None:
            self._before(request)
        answer = self._hands.perform(request)
        if self._after is not None:
            self._after(request)
        return answer


def site_of(profile: Profile, *current: CalibrationRecord) -> Site:
    return Site(profile=profile, plan=StorePlan(()), current=current)


@contextmanager
def twin_of(profile: Profile, truth: Profile | None = None, seed: int = 1) -> Iterator[TwinCell]:
    cell = assemble_twin(profile, StorePlan(()), seed=seed, clock=SimulatedClock(), truth=truth)
    try:
        yield cell
    finally:
        cell.dispose()


def played(
    procedure: Procedure,
    answers: Mapping[str, Value | tuple[float, float]],
    cell: TwinCell | None = None,
    *,
    before: Watcher | None = None,
    after: Watcher | None = None,
) -> Measurement:
    hands: Hands = NoHands()
    if cell is not None:
        made = cell
        hands = WatchedHands(CellHands(lambda: made), before, after)
    return play(procedure, hands=hands, asker=Answers(answers), stop=StopToken())


def codes(measurement: Measurement) -> list[str]:
    return [finding.code for finding in measurement.findings]


def rms(miss: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """Return the root mean square length of offsets (n, 2)."""
    return float(np.sqrt((miss**2).sum(axis=1).mean()))
