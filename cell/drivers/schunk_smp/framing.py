"""Frames of the SCHUNK Motion Protocol: group, module, length, command, parameters, CRC.

The length byte counts the command byte and the parameters, so a frame is five
bytes longer than it says. Nothing marks a frame's start, and any byte may occur
inside one; the reader therefore looks for a place where group, module, length
and checksum all agree, and moves on by one byte when they do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from cell.drivers.schunk_smp.crc import crc16
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.tables import Code, Group

MAX_LENGTH = 255
"""Largest value of the length byte."""

_OVERHEAD = 5
FROM_MASTER = frozenset({int(Group.MASTER)})
"""Groups of frames that a module listens to."""
FROM_MODULE = frozenset({int(Group.MODULE), int(Group.REFUSAL)})
"""Groups of frames that a module sends; refusals come with either."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame with a right checksum."""

    group: int
    module: int
    command: int
    parameters: bytes = b""

    @property
    def length(self) -> int:
        """The length byte: command and parameters."""
        return 1 + len(self.parameters)


@dataclass(frozen=True, slots=True)
class DamagedFrame:
    """What looked like a frame but has a wrong checksum."""

    group: int
    module: int
    command: int


Received: TypeAlias = Frame | DamagedFrame


def encode_frame(frame: Frame) -> bytes:
    """Return a frame's bytes.

    Raises:
        MalformedMessage: The parameters are too long for the length byte.
    """
    if frame.length > MAX_LENGTH:
        raise MalformedMessage(
            f"a frame holds {MAX_LENGTH - 1} parameter bytes, not {len(frame.parameters)}",
            code=Code.MESSAGE_LENGTH,
        )
    body = bytes((frame.group, frame.module, frame.length, frame.command)) + frame.parameters
    return body + crc16(body).to_bytes(2, "little")


class FrameReader:
    """Collects bytes as they come and finds the frames in them.

    Args:
        groups: Values of the first byte that are expected, such as `FROM_MODULE`.
        module: The only module id expected, or None for all.
        max_length: Largest length byte that is believed; what claims more is garbage.

    Attributes:
        discarded: How many bytes belonged to no frame.
        damaged: How many frames had a wrong checksum.
    """

    def __init__(
        self, groups: frozenset[int], *, module: int | None = None, max_length: int = MAX_LENGTH
    ) -> None:
        self._groups = groups
        self._module = module
        self._max_length = max_length
        self._buffer = bytearray()
        self.discarded = 0
        self.damaged = 0

    @property
    def is_waiting(self) -> bool:
        """Whether the beginning of a frame is kept, waiting for its rest."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Received]:
        """Take bytes and return the frames they complete, oldest first."""
        buffer = self._buffer
        buffer += data
        found: list[Received] = []
        start = 0
        size = len(buffer)
        while start < size:
            if not self._may_start(start):
                start += 1
                self.discarded += 1
                continue
            if size - start < 3 or size - start < (total := buffer[start + 2] + _OVERHEAD):
                break
            end = start + total
            body = bytes(buffer[start : end - 2])
            if crc16(body) == buffer[end - 2] | buffer[end - 1] << 8:
                found.append(Frame(body[0], body[1], body[3], body[4:]))
                start = end
            else:
                found.append(DamagedFrame(body[0], body[1], body[3]))
                self.damaged += 1
                self.discarded += 1
                start += 1
        del buffer[:start]
        return found

    def skip_false_start(self) -> list[Received]:
        """Give up the frame that is being waited for and return what lies behind its start.

        For a line that fell silent: a stray byte can look like the start of a
        long frame and hide the real frames after it.
        """
        found: list[Received] = []
        while self._buffer:
            del self._buffer[0]
            self.discarded += 1
            found += self.feed(b"")
        return found

    def clear(self) -> None:
        """Forget everything that was not yet a frame."""
        self.discarded += len(self._buffer)
        self._buffer.clear()

    def _may_start(self, start: int) -> bool:
        """Return whether the bytes known so far agree with a frame starting here."""
        buffer = self._buffer
        if buffer[start] not in self._groups:
            return False
        known = len(buffer) - start
        if known > 1 and self._module is not None and buffer[start + 1] != self._module:
            return False
        return known < 3 or 1 <= buffer[start + 2] <= self._max_length
