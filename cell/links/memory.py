"""A wire in memory: the driver at one end, an emulator at the other."""

from __future__ import annotations

from cell.clock import Clock
from cell.errors import LinkError
from cell.links.base import Emulator

_CREEP_S = 1e-6


class MemoryLink:
    """Joins a driver to an emulator on a common clock.

    Waiting for bytes sleeps on the clock until the emulator has some or the
    time is up, so a simulated clock jumps straight to the answer.
    """

    def __init__(self, name: str, emulator: Emulator, clock: Clock) -> None:
        self._name = name
        self._emulator = emulator
        self._clock = clock
        self._is_open = True

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    def write(self, data: bytes) -> None:
        """Hand bytes to the emulator."""
        self._require_open()
        self._emulator.receive(data, self._clock.now_s())

    def read(self, timeout_s: float) -> bytes:
        """Return what the emulator has sent, waiting at most `timeout_s`."""
        self._require_open()
        return await_bytes(self._emulator, self._clock, timeout_s)

    def close(self) -> None:
        """Let the link go."""
        self._is_open = False

    def _require_open(self) -> None:
        if not self._is_open:
            raise LinkError(f"the link to {self._name} is closed")


def await_bytes(emulator: Emulator, clock: Clock, timeout_s: float) -> bytes:
    """Return what an emulator sends, letting at most `timeout_s` pass on the clock.

    The clock goes from one thing that is due to the next, never further than needed.
    """
    now_s = clock.now_s()
    data = emulator.transmit(now_s)
    deadline_s = now_s + timeout_s
    creep_s = _CREEP_S
    while not data and now_s < deadline_s:
        next_s = emulator.next_output_s()
        wake_s = deadline_s if next_s is None else min(next_s, deadline_s)
        if wake_s > now_s:
            clock.sleep(wake_s - now_s)
        else:
            # An emulator that is due but says nothing must not hold the time still.
            clock.sleep(creep_s)
            creep_s *= 2.0
        now_s = clock.now_s()
        data = emulator.transmit(now_s)
    return data
