"""What may happen on a wire, done to an emulator on purpose: silence, garbage, an unplugged cable.

Faults of the device itself (an alarm, an emergency stop, a latched error) are the
emulators' own; here is what any wire can do to any device.
"""

from __future__ import annotations

import enum
import random
from collections import deque

from cell.errors import LinkError
from cell.links.base import Emulator


class WireFault(enum.Enum):
    """One way in which a wire fails."""

    LOST = "the next reply is lost"
    GARBAGE = "the next reply is random bytes"
    CORRUPTED = "one bit of the next reply is turned over"
    HALF = "the second half of the next reply is lost"
    LATE = "the next reply is late"
    SILENT = "nothing is answered any more"
    UNPLUGGED = "the cable is out"


LASTING = frozenset({WireFault.SILENT, WireFault.UNPLUGGED})
"""Faults that stay until they are cleared; the others happen to one reply."""


class FaultyEmulator:
    """An emulator behind a wire that can be made to fail.

    Without a fault it adds nothing and changes nothing. A fault of one reply waits for the
    next bytes that the device sends; several wait in line.

    Args:
        emulator: The device behind the wire.
        seed: Seed of what is random in the faults.
    """

    def __init__(self, emulator: Emulator, *, seed: int = 0) -> None:
        self._emulator = emulator
        self._random = random.Random(seed)
        self._waiting: deque[tuple[WireFault, float]] = deque()
        self._lasting: set[WireFault] = set()
        self._late: tuple[float, bytes] | None = None

    @property
    def has_fault(self) -> bool:
        """Whether a fault lasts or waits for a reply."""
        return bool(self._lasting or self._waiting or self._late)

    def inject(self, fault: WireFault, *, delay_s: float = 0.0) -> None:
        """Let a fault happen; `delay_s` is for a late reply."""
        if fault in LASTING:
            self._lasting.add(fault)
        else:
            self._waiting.append((fault, delay_s))

    def clear(self) -> None:
        """End all faults: the cable is in, replies come as they are."""
        self._lasting.clear()
        self._waiting.clear()
        self._late = None

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`.

        Raises:
            LinkError: The cable is out.
        """
        self._require_plugged()
        if WireFault.SILENT not in self._lasting:
            self._emulator.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`.

        Raises:
            LinkError: The cable is out.
        """
        self._require_plugged()
        data = self._emulator.transmit(now_s)
        if not (self._lasting or self._waiting or self._late):
            return data
        if WireFault.SILENT in self._lasting:
            return b""
        if data and self._waiting:
            data = self._spoil(data, now_s)
        return self._with_late(data, now_s)

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        if self._lasting:
            return None
        next_s = self._emulator.next_output_s()
        if self._late is not None:
            return self._late[0] if next_s is None else min(next_s, self._late[0])
        return next_s

    def _spoil(self, data: bytes, now_s: float) -> bytes:
        fault, delay_s = self._waiting.popleft()
        match fault:
            case WireFault.GARBAGE:
                return self._random.randbytes(len(data))
            case WireFault.CORRUPTED:
                at = self._random.randrange(len(data))
                turned = data[at] ^ (1 << self._random.randrange(8))
                return data[:at] + bytes((turned,)) + data[at + 1 :]
            case WireFault.HALF:
                return data[: len(data) // 2]
            case WireFault.LATE:
                self._late = (now_s + delay_s, data)
                return b""
            case _:
                return b""

    def _with_late(self, data: bytes, now_s: float) -> bytes:
        late = self._late
        if late is None or late[0] > now_s:
            return data
        self._late = None
        return late[1] + data

    def _require_plugged(self) -> None:
        if WireFault.UNPLUGGED in self._lasting:
            raise LinkError("the cable is out")
