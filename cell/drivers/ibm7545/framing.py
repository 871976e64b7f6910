"""Bytes between the computer and the bridge to the registers.

The original master sat on the same bus as the dual-port memory. A computer of today has
no such bus; between it and the memory we assume a small bridge on a serial line. Its
framing is ours and was never tried on hardware:

    request   A5  number  length(2)  steps…                crc(2)
    reply     5A  number  length(2)  status  flags  words…  crc(2)

Numbers are little-endian. `length` counts what lies between it and the checksum
(CRC-16/CCITT, start FFFF, over everything before it). A request is a list of steps which
the bridge takes one after the other, and answers once with all words read:

    01 offset(2) count(1)                         read words
    02 offset(2) count(1) words…                  write words
    03 offset(2) mask(2) value(2) unless(2) ms(2) wait until word & mask is value, or the
                                                  register `unless` is not zero
    04                                            take note that motor power was off

So the handshake of a sample period, which is fast, stays between bridge and slave, and
each period costs one request and one reply. A wait that fails ends the list. The bridge
has an input wired to the motors' contactor, whose state is in the flags of each reply.
"""

from __future__ import annotations

import struct
from binascii import crc_hqx
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import TypeAlias

from cell.errors import CellError

REQUEST = 0xA5
REPLY = 0x5A
MAX_LENGTH = 1024
"""Largest length that is believed; what claims more is garbage."""
_HEAD = struct.Struct("<BBH")
_CRC = struct.Struct("<H")
_READ = struct.Struct("<BHB")
_AWAIT = struct.Struct("<BHHHHH")
OVERHEAD = _HEAD.size + _CRC.size


class MalformedFrame(CellError):
    """Bytes that cannot be a message of the bridge, though their checksum is right."""


class Status(IntEnum):
    """How the bridge got on with a request."""

    DONE = 0
    WAIT_FAILED = 1
    NOT_UNDERSTOOD = 2
    NO_SUCH_REGISTER = 3


class Flags(IntFlag):
    """What the bridge sees of the motors' power."""

    POWER_OFF = 0x01
    POWER_WAS_OFF = 0x02


class _Code(IntEnum):
    READ = 1
    WRITE = 2
    AWAIT = 3
    ACKNOWLEDGE = 4


@dataclass(frozen=True, slots=True)
class Read:
    """Read `count` words from an offset on."""

    offset: int
    count: int = 1


@dataclass(frozen=True, slots=True)
class Write:
    """Write words from an offset on."""

    offset: int
    words: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Await:
    """Wait until a register's masked bits have a value, or another is not zero."""

    offset: int
    mask: int
    value: int
    unless: int
    timeout_ms: int


@dataclass(frozen=True, slots=True)
class Acknowledge:
    """Take note that motor power was off; the flag `POWER_WAS_OFF` falls."""


Step: TypeAlias = Read | Write | Await | Acknowledge


@dataclass(frozen=True, slots=True)
class Reply:
    """What the bridge answers to one request."""

    number: int
    status: int
    flags: int
    words: tuple[int, ...]


def encode_steps(steps: Sequence[Step]) -> bytes:
    """Return the bytes of steps, without a frame."""
    parts: list[bytes] = []
    for step in steps:
        if isinstance(step, Read):
            parts.append(_READ.pack(_Code.READ, step.offset, step.count))
        elif isinstance(step, Write):
            parts.append(_READ.pack(_Code.WRITE, step.offset, len(step.words)))
            parts.append(struct.pack(f"<{len(step.words)}H", *step.words))
        elif isinstance(step, Await):
            parts.append(
                _AWAIT.pack(
                    _Code.AWAIT, step.offset, step.mask, step.value, step.unless, step.timeout_ms
                )
            )
        else:
            parts.append(bytes((_Code.ACKNOWLEDGE,)))
    return b"".join(parts)


def decode_steps(data: bytes) -> tuple[Step, ...]:
    """Return the steps in a request.

    Raises:
        MalformedFrame: They are cut off, or one is unknown.
    """
    steps: list[Step] = []
    at = 0
    try:
        while at < len(data):
            code = data[at]
            if code == _Code.READ:
                _, offset, count = _READ.unpack_from(data, at)
                at += _READ.size
                steps.append(Read(offset, count))
            elif code == _Code.WRITE:
                _, offset, count = _READ.unpack_from(data, at)
                at += _READ.size
                steps.append(Write(offset, struct.unpack_from(f"<{count}H", data, at)))
                at += 2 * count
            elif code == _Code.AWAIT:
                _, offset, mask, value, unless, timeout_ms = _AWAIT.unpack_from(data, at)
                at += _AWAIT.size
                steps.append(Await(offset, mask, value, unless, timeout_ms))
            elif code == _Code.ACKNOWLEDGE:
                at += 1
                steps.append(Acknowledge())
            else:
                raise MalformedFrame(f"the bridge knows no step {code:#04x}")
    except struct.error as error:
        raise MalformedFrame("the last step of a request is cut off") from error
    return tuple(steps)


def encode_request(number: int, steps: Sequence[Step]) -> bytes:
    """Return the bytes of a request."""
    return _framed(REQUEST, number, encode_steps(steps))


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply."""
    words = struct.pack(f"<BB{len(reply.words)}H", reply.status, reply.flags, *reply.words)
    return _framed(REPLY, reply.number, words)


def decode_reply(number: int, body: bytes) -> Reply:
    """Return the reply in a frame's body.

    Raises:
        MalformedFrame: It is too short, or a word is cut off.
    """
    if len(body) < 2 or len(body) % 2:
        raise MalformedFrame(f"a reply of {len(body)} bytes is cut off")
    status, flags, *words = struct.unpack(f"<BB{(len(body) - 2) // 2}H", body)
    return Reply(number, status, flags, tuple(words))


def _framed(start: int, number: int, body: bytes) -> bytes:
    data = _HEAD.pack(start, number, len(body)) + body
    return data + _CRC.pack(crc_hqx(data, 0xFFFF))


class FrameReader:
    """Collects bytes as they come and finds the frames in them.

    Args:
        start: First byte of the frames, `REQUEST` or `REPLY`.

    Attributes:
        discarded: How many bytes belonged to no frame.
    """

    def __init__(self, start: int) -> None:
        self._start = start
        self._buffer = bytearray()
        self.discarded = 0

    def feed(self, data: bytes) -> list[tuple[int, bytes]]:
        """Take bytes; return number and body of each frame they complete."""
        buffer = self._buffer
        buffer += data
        found: list[tuple[int, bytes]] = []
        at = 0
        while len(buffer) - at >= OVERHEAD:
            start, number, length = _HEAD.unpack_from(buffer, at)
            if start != self._start or length > MAX_LENGTH:
                at += 1
                self.discarded += 1
                continue
            end = at + length + OVERHEAD
            if len(buffer) < end:
                break
            body = bytes(buffer[at : end - _CRC.size])
            if crc_hqx(body, 0xFFFF) == _CRC.unpack_from(buffer, end - _CRC.size)[0]:
                found.append((number, body[_HEAD.size :]))
                at = end
            else:
                at += 1
                self.discarded += 1
        del buffer[:at]
        return found

    def clear(self) -> None:
        """Forget everything that was not yet a frame."""
        self.discarded += len(self._buffer)
        self._buffer.clear()
