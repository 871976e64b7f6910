"""Bring devices up, those that do not need each other at the same time, and report all failures.

In parallel on the system's clock only: any other clock is moved on by whoever sleeps on it,
so two threads would make the order of things, and with it a recording, a matter of chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from cell.clock import Clock, SystemClock
from cell.errors import CellError, DeviceError


@dataclass(frozen=True, slots=True)
class Step:
    """One device's part of coming up."""

    device: str
    bring_up: Callable[[], None]


Chain = Sequence[Step]
"""Steps of which each needs those before it."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A device that did not come up."""

    device: str
    error: CellError


class OpeningFailed(DeviceError):
    """Several devices did not come up.

    Attributes:
        failures: Every one of them.
    """

    def __init__(self, failures: Sequence[Failure]) -> None:
        self.failures = tuple(failures)
        told = "; ".join(f"{n}. {failure.error}" for n, failure in enumerate(failures, 1))
        super().__init__("cell", f"{len(failures)} devices did not come up: {told}")


def can_open_in_parallel(clock: Clock) -> bool:
    """Return whether two devices may wait at the same time on a clock."""
    return isinstance(clock, SystemClock)


def bring_up(chains: Sequence[Chain], clock: Clock) -> None:
    """Run every chain to its end or to its first failure, all chains whatever becomes of others.

    Raises:
        CellError: The only failure there was.
        OpeningFailed: All failures, if there were several.
    """
    if can_open_in_parallel(clock) and len(chains) > 1:
        with ThreadPoolExecutor(len(chains), "opening") as pool:
            found = list(pool.map(_run, chains))
    else:
        found = [_run(chain) for chain in chains]
    failures = [failure for failure in found if failure is not None]
    if len(failures) == 1:
        raise failures[0].error
    if failures:
        raise OpeningFailed(failures)


def _run(chain: Chain) -> Failure | None:
    for step in chain:
        try:
            step.bring_up()
        except CellError as error:
            return Failure(step.device, error)
    return None
