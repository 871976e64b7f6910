"""The second framing of the protocol, which the maker's tool speaks over Ethernet.

A frame is STX, `HC`, a sequence number of three digits, `000000`, a letter for its type, the
payload's length as four hexadecimal digits, the payload, the exclusive or of everything from
`HC` to the payload's end as two hexadecimal digits, ETX. A request is acknowledged, answered,
and the answer is acknowledged by the host. One source only; the answer's letter is assumed.
"""

from __future__ import annotations

from functools import reduce
from operator import xor
from typing import NamedTuple

from cell.drivers.melfa_r3.codec import GarbledMessage

STX, ETX = 0x02, 0x03
REQUEST = "R"
ACKNOWLEDGE = "A"
ANSWER = "S"
"""Assumed: a reader takes every letter but the two others as an answer."""
TAKEN = "J"
"""What the host sends when it has the answer."""
NOTHING = "00"
"""Payload of both acknowledgements."""
SEQUENCES = 999
CHANGE_TO_HC = "CHGPRT=HC"

_MARK = b"HC"
_FILL = b"000000"
_HEAD_BYTES = 1 + 2 + 3 + 6 + 1 + 4
_TAIL_BYTES = 3
_MOST_PAYLOAD = 4096


class Frame(NamedTuple):
    """One frame: sequence number 0 to 998, letter of its type, payload."""

    sequence: int
    kind: str
    payload: str


def encode_frame(frame: Frame) -> bytes:
    """Return the bytes of a frame."""
    payload = frame.payload.encode("latin-1")
    body = b"%s%03d%s%s%04X%s" % (
        _MARK,
        frame.sequence % SEQUENCES,
        _FILL,
        frame.kind.encode("ascii"),
        len(payload),
        payload,
    )
    return b"\x02%s%02X\x03" % (body, reduce(xor, body))


class FrameReader:
    """Gathers bytes into frames; bytes outside frames are dropped."""

    def __init__(self) -> None:
        self._rest = bytearray()

    def clear(self) -> None:
        """Forget a frame that has begun."""
        self._rest.clear()

    def feed(self, data: bytes) -> list[Frame]:
        """Take bytes and return the frames they complete, in order.

        Raises:
            GarbledMessage: A frame is damaged; what came before it is lost too.
        """
        self._rest += data
        frames: list[Frame] = []
        while True:
            start = self._rest.find(STX)
            if start < 0:
                self._rest.clear()
                return frames
            del self._rest[:start]
            frame = self._take()
            if frame is None:
                return frames
            frames.append(frame)

    def _take(self) -> Frame | None:
        """Take the frame at the beginning, or None if it is not complete."""
        rest = self._rest
        if len(rest) < _HEAD_BYTES:
            return None
        try:
            length = int(bytes(rest[13:17]), 16)
            sequence = int(bytes(rest[3:6]))
        except ValueError:
            raise self._garbled("its head holds no numbers") from None
        if bytes(rest[1:3]) != _MARK or length > _MOST_PAYLOAD:
            raise self._garbled("its head is none")
        size = _HEAD_BYTES + length + _TAIL_BYTES
        if len(rest) < size:
            return None
        body = bytes(rest[1 : size - _TAIL_BYTES])
        told = bytes(rest[size - _TAIL_BYTES : size - 1])
        if rest[size - 1] != ETX or told != b"%02X" % reduce(xor, body):
            raise self._garbled("its check figure is wrong")
        kind = chr(rest[12])
        payload = bytes(rest[_HEAD_BYTES : _HEAD_BYTES + length]).decode("latin-1")
        del rest[:size]
        return Frame(sequence, kind, payload)

    def _garbled(self, why: str) -> GarbledMessage:
        shown = bytes(self._rest[:40])
        self._rest.clear()
        return GarbledMessage(f"the frame {shown!r} cannot be read: {why}")
