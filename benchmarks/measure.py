"""What a benchmark gives back, and how times are taken: beside a ceiling or a peer.

Every other module of this folder offers `run() -> list[Result]`.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """One figure beside another that was measured in the same run.

    Attributes:
        name: What was measured.
        value: Median of the measurements.
        unit: Its unit.
        peer: What the other figure is: a bare socket, the same without recording.
        peer_value: The other figure, in the same unit; None when there is nothing to compare.
        target: What the figure should reach; None when none is set.
        target_is: Whether the target is the most or the least allowed.
        of: Whether the target is for the value or for the ratio value / peer_value.
    """

    name: str
    value: float
    unit: str
    peer: str = ""
    peer_value: float | None = None
    target: float | None = None
    target_is: Literal["at most", "at least"] = "at most"
    of: Literal["value", "ratio"] = "value"

    @property
    def ratio(self) -> float | None:
        """The value as a multiple of its peer."""
        return None if not self.peer_value else self.value / self.peer_value

    @property
    def is_met(self) -> bool | None:
        """Whether the target is reached; None when there is none."""
        figure = self.value if self.of == "value" else self.ratio
        if self.target is None or figure is None:
            return None
        return figure <= self.target if self.target_is == "at most" else figure >= self.target


def median_s(job: Callable[[], object], *, repeat: int = 9, number: int = 1) -> float:
    """Return the median time of one call in seconds.

    Args:
        job: What is timed; called once before, to warm up.
        repeat: How many times are taken.
        number: Calls per time taken.
    """
    job()
    times: list[float] = []
    for _ in range(repeat):
        start = time.perf_counter()
        for _ in range(number):
            job()
        times.append((time.perf_counter() - start) / number)
    return statistics.median(times)


def interleaved_s(
    first: Callable[[], object], second: Callable[[], object], *, repeat: int, number: int
) -> tuple[float, float]:
    """Return the times of one call of each of two jobs in seconds, fit to be compared.

    The jobs run in blocks by turns and take turns in going first, so that whatever else the
    machine does burdens both alike. Lower quartiles are given back, for a neighbour can make
    a block slower and never faster.

    Args:
        first: What is timed.
        second: What it is compared with.
        repeat: How many blocks of each are timed.
        number: Calls a block. A twentieth as many come before it untimed, so that each job
            finds the processor's caches as it would alone.
    """
    times: dict[bool, list[float]] = {True: [], False: []}
    for turn in range(repeat):
        for is_first in (True, False) if turn % 2 else (False, True):
            job = first if is_first else second
            for _ in range(number // 20 + 1):
                job()
            start_s = time.perf_counter()
            for _ in range(number):
                job()
            times[is_first].append((time.perf_counter() - start_s) / number)
    return _lower_quartile(times[True]), _lower_quartile(times[False])


def _lower_quartile(values: list[float]) -> float:
    return sorted(values)[len(values) // 4]
