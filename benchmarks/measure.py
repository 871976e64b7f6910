"""What a benchmark gives back, and how times are taken: medians, beside a ceiling or a peer.

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
