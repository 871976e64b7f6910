"""When faults happen: at a moment of the simulated time, or at the n-th request on a wire.

An emulator is told the time only when somebody talks to it, so what happens in between
must be done by the clock that everybody sleeps on.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass

from cell.clock import SimulatedClock
from cell.links.base import Direction

Act = Callable[[float], None]
"""Something that happens; told the time."""


def _any(data: bytes) -> bool:
    return True


class EventfulClock(SimulatedClock):
    """A simulated clock on which something may happen while others sleep."""

    def __init__(self, start_s: float = 0.0) -> None:
        super().__init__(start_s)
        self._due: list[tuple[float, int, Act]] = []
        self._count = 0

    def at(self, time_s: float, act: Act) -> None:
        """Have something happen at a time, or at once if that is past."""
        self._count += 1
        heapq.heappush(self._due, (time_s, self._count, act))

    def sleep(self, duration_s: float) -> None:
        """Move the time on, stopping at what happens meanwhile."""
        end_s = self.now_s() + duration_s
        while self._due and self._due[0][0] <= end_s:
            due_s, _, act = heapq.heappop(self._due)
            super().sleep(due_s - self.now_s())
            act(self.now_s())
        super().sleep(end_s - self.now_s())


@dataclass(slots=True)
class _Awaited:
    link: str
    left: int
    counts: Callable[[bytes], bool]
    act: Act


class Timetable:
    """A tap that counts requests, and a clock: both let faults happen when they are due.

    Args:
        clock: The cell's clock; one of its own unless given.

    Attributes:
        clock: To be given to the cell as its clock.
    """

    def __init__(self, clock: EventfulClock | None = None) -> None:
        self.clock = clock or EventfulClock()
        self._awaited: list[_Awaited] = []

    def at_time(self, time_s: float, act: Act) -> None:
        """Have something happen at a moment of the simulated time."""
        self.clock.at(time_s, act)

    def at_request(
        self, link: str, number: int, act: Act, *, counts: Callable[[bytes], bool] = _any
    ) -> None:
        """Have something happen when a device has heard the n-th request from now.

        Args:
            link: Name of the device's link.
            number: 1 for the next request.
            act: What happens; the reply to that very request is not out yet.
            counts: Which requests are counted.
        """
        self._awaited.append(_Awaited(link, number, counts, act))

    def __call__(self, link: str, direction: Direction, data: bytes) -> None:
        """Take note of what is sent on a link (`cell.links.base.Tap`)."""
        if direction != "to_device" or not self._awaited:
            return
        for awaited in list(self._awaited):
            if awaited.link == link and awaited.counts(data):
                awaited.left -= 1
                if awaited.left == 0:
                    self._awaited.remove(awaited)
                    awaited.act(self.clock.now_s())
