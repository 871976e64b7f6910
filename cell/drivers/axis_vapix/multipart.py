"""A stream of parts (multipart/x-mixed-replace) to its parts, without I/O.

Cameras differ: the header may name the boundary with or without its leading dashes,
quoted or not; parts may or may not tell their length. A part whose length is told is
taken by it, any other ends at the next boundary. After nonsense the reader goes on at
the next boundary.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from email.message import Message

from cell.errors import CellError

MOST_HEADER_BYTES = 16 * 1024
MOST_PART_BYTES = 16 * 1024 * 1024


class MalformedStream(CellError):
    """What arrives is no stream of parts."""


@dataclass(frozen=True, slots=True)
class Part:
    """One part of a stream.

    Attributes:
        body: Its bytes.
        headers: Its header lines, names in small letters.
    """

    body: bytes
    headers: dict[str, str] = field(default_factory=dict)


def boundary_of(content_type: str) -> bytes:
    """Return what stands before each part, dashes included.

    Raises:
        MalformedStream: The type is not that of a stream of parts.
    """
    message = Message()
    message["Content-Type"] = content_type
    named = message.get_param("boundary")
    if message.get_content_maintype() != "multipart" or not isinstance(named, str):
        raise MalformedStream(f"no stream of pictures: its type is {content_type[:80]!r}")
    name = named.strip().strip('"').lstrip("-")
    if not name:
        raise MalformedStream(f"a stream without a boundary: {content_type[:80]!r}")
    return b"--" + name.encode("latin-1", "replace")


class MultipartReader:
    """Collects bytes and gives out whole parts.

    Args:
        boundary: What stands before each part, as `boundary_of` returns it.
    """

    def __init__(self, boundary: bytes) -> None:
        self._boundary = boundary
        self._data = bytearray()
        self._headers: dict[str, str] | None = None
        self._length: int | None = None
        self._searched = 0

    def feed(self, data: bytes) -> list[Part]:
        """Take bytes and return the parts that are whole now.

        Raises:
            MalformedStream: A part or its header is longer than any can be.
        """
        self._data += data
        parts: list[Part] = []
        while True:
            if self._headers is None and not self._read_headers():
                return parts
            body = self._read_body()
            if body is None:
                return parts
            parts.append(Part(body, self._headers or {}))
            self._headers = None

    def _read_headers(self) -> bool:
        start = self._data.find(self._boundary)
        if start < 0:
            # Only the tail can be the beginning of a boundary.
            del self._data[: max(0, len(self._data) - len(self._boundary))]
            return False
        del self._data[:start]
        end, size = _end_of_headers(self._data)
        if end < 0:
            if len(self._data) > MOST_HEADER_BYTES:
                raise MalformedStream(f"a part's header has more than {MOST_HEADER_BYTES} bytes")
            return False
        lines = self._data[:end].decode("latin-1").splitlines()[1:]
        self._headers = {
            name.strip().lower(): value.strip()
            for name, colon, value in (line.partition(":") for line in lines)
            if colon
        }
        del self._data[: end + size]
        told = self._headers.get("content-length", "")
        self._length = int(told) if told.isascii() and told.isdigit() else None
        self._searched = 0
        if self._length is not None and self._length > MOST_PART_BYTES:
            raise MalformedStream(f"a part of {self._length} bytes is announced")
        return True

    def _read_body(self) -> bytes | None:
        if self._length is None:
            return self._read_up_to_boundary()
        if len(self._data) < self._length:
            return None
        body = bytes(self._data[: self._length])
        del self._data[: self._length]
        return body

    def _read_up_to_boundary(self) -> bytes | None:
        end = self._data.find(self._boundary, self._searched)
        if end < 0:
            if len(self._data) > MOST_PART_BYTES:
                raise MalformedStream(f"a part has more than {MOST_PART_BYTES} bytes")
            self._searched = max(0, len(self._data) - len(self._boundary))
            return None
        body = bytes(self._data[:end])
        del self._data[:end]
        return body.removesuffix(b"\n").removesuffix(b"\r")


def _end_of_headers(data: bytearray) -> tuple[int, int]:
    """Return where the headers end and how long the empty line is, or (-1, 0)."""
    ends = [(data.find(end), len(end)) for end in (b"\r\n\r\n", b"\n\n")]
    found = [pair for pair in ends if pair[0] >= 0]
    return min(found) if found else (-1, 0)
