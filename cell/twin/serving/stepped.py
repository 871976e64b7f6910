"""A pseudo-terminal whose device end is worked by the driver's own thread.

Inside one process no second thread is needed to answer: when the driver has written, the
bytes are taken from the device's end and given to the emulator; when it reads, the
emulator's bytes are written to the device's end and read from the port. Everything passes
through the kernel and pyserial, yet each byte arrives at the very time on the clock at
which it would in memory, so a run over pseudo-terminals repeats like one in memory, in
real time and as fast as it can, and nothing has to be locked.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from cell.clock import Clock
from cell.errors import LinkError
from cell.links.base import Link
from cell.links.memory import await_bytes
from cell.twin.wire_faults import FaultyEmulator

_CHUNK_BYTES = 1024
"""Less than a pseudo-terminal buffers, so that a write never waits for its own reader."""
_TRANSIT_S = 2.0
"""Bytes known to be on their way are there at once; this is for a stuck machine."""


class SteppedPort(Protocol):
    """The device's end of a port whose bytes are on their way at once: `PtyPort`, or TCP."""

    @property
    def is_plugged(self) -> bool:
        """Whether the port is there."""

    def greet(self) -> None:
        """Make ready for a program that has just opened the port."""

    def await_heard(self, count: int, timeout_s: float) -> bytes:
        """Return the next `count` bytes that the program has sent."""

    def say(self, data: bytes) -> int:
        """Send bytes to the program; return how many the port took."""

    def plug(self) -> None:
        """Make the port appear."""

    def unplug(self) -> None:
        """Make the port vanish."""


class SteppedWire:
    """An emulator at one end of a pseudo-terminal; gives out links to the other.

    Args:
        emulator: The device and its faults; a pulled cable makes the port vanish.
        port: The port.
        clock: The clock of everything in the cell.
    """

    def __init__(self, emulator: FaultyEmulator, port: SteppedPort, clock: Clock) -> None:
        self._emulator = emulator
        self._port = port
        self._clock = clock
        self._in_flight = 0
        self._was_opened = False
        emulator.on_cable(self._set_plugged)

    def open(self, open_port: Callable[[], Link]) -> Link:
        """Open the port and return a link through it.

        Raises:
            LinkError: The port cannot be opened.
        """
        link = open_port()
        self._port.greet()
        try:
            # Nobody listened: what the device said, and what nobody fetched, is lost.
            self._fetch(link)
            if self._was_opened:
                self._emulator.transmit(self._clock.now_s())
        except LinkError:
            link.close()
            raise
        self._was_opened = True
        return SteppedLink(self, link)

    def close(self) -> None:
        """Make the port vanish for good."""
        self._port.unplug()

    def send(self, link: Link, data: bytes) -> None:
        """Send bytes through the port and have the device hear them now."""
        for start in range(0, len(data), _CHUNK_BYTES):
            chunk = data[start : start + _CHUNK_BYTES]
            link.write(chunk)
            heard = self._port.await_heard(len(chunk), _TRANSIT_S)
            self._emulator.receive(heard, self._clock.now_s())

    def receive(self, link: Link, timeout_s: float) -> bytes:
        """Have the device say what is due within the time, and return it through the port."""
        if not self._in_flight:
            data = await_bytes(self._emulator, self._clock, timeout_s)
            if not data:
                return b"" if self._port.is_plugged else link.read(0.0)
            self._in_flight = self._port.say(data)
        data = link.read(_TRANSIT_S)
        self._in_flight = max(0, self._in_flight - len(data))
        return data

    def _fetch(self, link: Link) -> None:
        """Drop what an earlier opening left on the way."""
        if self._in_flight:
            link.read(0.0)
        self._in_flight = 0

    def _set_plugged(self, is_plugged: bool) -> None:
        self._in_flight = 0
        if is_plugged:
            self._port.plug()
        else:
            self._port.unplug()


class SteppedLink:
    """A link through a port, at whose other end the device is worked by the same thread."""

    def __init__(self, wire: SteppedWire, link: Link) -> None:
        self._wire = wire
        self._link = link
        self._is_open = True

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._link.name

    def write(self, data: bytes) -> None:
        """Send all bytes and have the device hear them.

        Raises:
            LinkError: The port is gone, or the link is closed.
        """
        self._require_open()
        self._wire.send(self._link, data)

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, letting at most `timeout_s` pass on the cell's clock.

        Raises:
            LinkError: The port is gone, or the link is closed.
        """
        self._require_open()
        return self._wire.receive(self._link, timeout_s)

    def close(self) -> None:
        """Let the port go; closing twice is harmless."""
        self._is_open = False
        self._link.close()

    def _require_open(self) -> None:
        if not self._is_open:
            raise LinkError(f"the link to {self.name} is closed")
