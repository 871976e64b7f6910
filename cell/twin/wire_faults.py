"""What may happen on a wire, done to an emulator on purpose: silence, garbage, an unplugged cable.

Faults of the device itself (an alarm, an emergency stop, a latched error) are the
emulators' own; here is what any wire can do to any device.
"""

from __future__ import annotations

import enum
import random
from collections import deque
from collections.abc import Callable
from typing import Protocol, runtime_checkable

from cell.errors import LinkError
from cell.links.base import Emulator

_SLOW_S = 0.1
"""How long a slow reply takes unless told: well within the drivers' deadlines."""


class WireFault(enum.Enum):
    """One way in which a wire fails."""

    LOST = "the next reply is lost"
    GARBAGE = "the next reply is random bytes"
    CORRUPTED = "one bit of the next reply is turned over"
    HALF = "the second half of the next reply is lost"
    LATE = "the next reply is late"
    SLOW = "the next reply trickles in byte by byte"
    SILENT = "nothing is answered any more"
    POWER = "the device has no power"
    UNPLUGGED = "the cable is out"


LASTING = frozenset({WireFault.SILENT, WireFault.POWER, WireFault.UNPLUGGED})
"""Faults that stay until they are cleared; the others happen to one reply."""


_FOR_EVER_S = 1e12


@runtime_checkable
class HasMains(Protocol):
    """An emulated device that forgets when it loses its power."""

    def lose_power(self, now_s: float, *, for_s: float) -> None:
        """Be without power from `now_s` on, and have it back `for_s` seconds later."""


class FaultyEmulator:
    """An emulator behind a wire that can be made to fail.

    Without a fault it adds nothing and changes nothing. A fault of one reply waits for the
    next bytes that the device sends; several wait in line. While the cable is out, using the
    wire is a LinkError, in memory and behind a pseudo-terminal alike; a device without power
    hears and says nothing, but its port stays where it is; if it is a device that forgets
    without power, it does so as soon as somebody uses the wire, and starts anew when the power
    is back. What the device says during a
    lasting fault is lost for good.

    Args:
        emulator: The device behind the wire.
        seed: Seed of what is random in the faults.
    """

    def __init__(self, emulator: Emulator, *, seed: int = 0) -> None:
        self._emulator = emulator
        self._random = random.Random(seed)
        self._waiting: deque[tuple[WireFault, float]] = deque()
        self._lasting: set[WireFault] = set()
        self._held: deque[tuple[float, bytes]] = deque()
        self._is_trickling = False
        self._is_stale = False
        self._is_dead = False
        self._on_cable: list[Callable[[bool], None]] = []

    @property
    def has_fault(self) -> bool:
        """Whether a fault lasts or waits for a reply."""
        return bool(self._lasting or self._waiting or self._held)

    @property
    def is_plugged(self) -> bool:
        """Whether the cable is in."""
        return WireFault.UNPLUGGED not in self._lasting

    def on_cable(self, tell: Callable[[bool], None]) -> None:
        """Have `tell` called with True when the cable is put in, with False when pulled."""
        self._on_cable.append(tell)

    def inject(self, fault: WireFault, *, delay_s: float = 0.0) -> None:
        """Let a fault happen.

        Args:
            fault: What happens.
            delay_s: How late a late reply is, or how long a slow one takes (0.1 s unless given).
        """
        if fault not in LASTING:
            self._waiting.append((fault, delay_s))
            return
        was_plugged = self.is_plugged
        self._lasting.add(fault)
        if was_plugged and not self.is_plugged:
            self._tell_cable()

    def clear(self) -> None:
        """End all faults: cable and power are back, replies come as they are."""
        was_plugged = self.is_plugged
        self._is_stale = self._is_stale or bool(self._lasting)
        self._lasting.clear()
        self._waiting.clear()
        self._held.clear()
        self._is_trickling = False
        if not was_plugged:
            self._tell_cable()

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`.

        Raises:
            LinkError: The cable is out.
        """
        if self._lasting:
            self._lose_power(now_s)
            self._require_plugged()
            return
        if self._is_stale:
            self._drop_stale(now_s)
        self._emulator.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`.

        Raises:
            LinkError: The cable is out.
        """
        if self._is_stale:
            self._drop_stale(now_s)
        if self._lasting:
            self._lose_power(now_s)
        data = self._emulator.transmit(now_s)
        if not (self._lasting or self._waiting or self._held):
            return data
        if self._lasting:
            self._require_plugged()
            return b""
        if data and self._waiting:
            data = self._spoil(data, now_s)
        return self._with_held(data, now_s)

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        if self._lasting:
            return None
        next_s = self._emulator.next_output_s()
        if self._held:
            return self._held[0][0] if next_s is None else min(next_s, self._held[0][0])
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
                self._held.append((now_s + delay_s, data))
                return b""
            case WireFault.SLOW:
                step_s = (delay_s or _SLOW_S) / len(data)
                self._held.extend(
                    (now_s + step_s * (index + 1), data[index : index + 1])
                    for index in range(len(data))
                )
                self._is_trickling = True
                return b""
            case _:
                return b""

    def _with_held(self, data: bytes, now_s: float) -> bytes:
        """Return held bytes that are due, then new ones; a trickle is never overtaken."""
        held = self._held
        if self._is_trickling and data:
            held.append((max(now_s, held[-1][0]), data))
            data = b""
        due = b""
        while held and held[0][0] <= now_s:
            due += held.popleft()[1]
        if not held:
            self._is_trickling = False
        return due + data

    def _lose_power(self, now_s: float) -> None:
        """Let a device without power know it, once."""
        if WireFault.POWER in self._lasting and not self._is_dead:
            self._is_dead = True
            if isinstance(self._emulator, HasMains):
                self._emulator.lose_power(now_s, for_s=_FOR_EVER_S)

    def _drop_stale(self, now_s: float) -> None:
        """Throw away what left the device while nothing could arrive; start it, if it was off."""
        self._is_stale = False
        if self._is_dead and WireFault.POWER not in self._lasting:
            self._is_dead = False
            if isinstance(self._emulator, HasMains):
                self._emulator.lose_power(now_s, for_s=0.0)
        self._emulator.transmit(now_s)

    def _tell_cable(self) -> None:
        for tell in self._on_cable:
            tell(self.is_plugged)

    def _require_plugged(self) -> None:
        if WireFault.UNPLUGGED in self._lasting:
            raise LinkError("the cable is out")
