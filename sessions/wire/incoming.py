"""A client's buffer: bytes in, replies out."""

from __future__ import annotations

from sessions.errors import RemoteProtocolError
from sessions.wire.dialects import Dialect
from sessions.wire.reading import LINE, Reading, read_answer
from sessions.wire.replies import Answer

MAX_LINE_BYTES = 1 << 20
"""The longest line of a server that is taken for a line."""


class AnswerReader:
    """Buffers bytes and returns replies, in order.

    Binary data is received straight into its own buffer: ask `wanted` where the
    next bytes should go, put them there, and tell `received` how many came.
    """

    def __init__(self, dialect: Dialect) -> None:
        self._dialect = dialect
        self._buffer = bytearray()
        self._reading: Reading | None = None
        self._need: int = LINE
        self._data = bytearray()
        self._filled = 0

    @property
    def dialect(self) -> Dialect:
        """The dialect in which replies are read."""
        return self._dialect

    def use(self, dialect: Dialect) -> None:
        """Read the replies that follow in another dialect."""
        self._dialect = dialect

    def wanted(self) -> memoryview | None:
        """Return where the next bytes of a long stretch of data belong, or None for `feed`."""
        return memoryview(self._data)[self._filled :] if self._need else None

    def received(self, count: int) -> None:
        """Take note that `count` bytes were put where `wanted` said."""
        self._filled += count

    def feed(self, data: bytes) -> None:
        """Take bytes that arrived."""
        taken = min(self._need - self._filled, len(data))
        if taken:
            self._data[self._filled : self._filled + taken] = data[:taken]
            self._filled += taken
        self._buffer += data[taken:]

    def next_answer(self) -> Answer | None:
        """Return the next whole reply, or None if more bytes are needed.

        Raises:
            RemoteProtocolError: The server sent what the protocol does not allow.
        """
        if self._reading is None:
            self._reading = read_answer(self._dialect)
            next(self._reading)
        while (piece := self._next_piece()) is not None:
            try:
                self._want(self._reading.send(piece))
            except StopIteration as stop:
                self._reading = None
                self._want(LINE)
                answer: Answer = stop.value
                return answer
        return None

    def _want(self, need: int) -> None:
        self._need = need
        self._filled = min(need, len(self._buffer))
        if need:
            self._data = bytearray(need)
            self._data[: self._filled] = self._buffer[: self._filled]
            del self._buffer[: self._filled]
        else:
            self._filled = 0

    def _next_piece(self) -> bytes | bytearray | None:
        if self._need:
            return self._data if self._filled == self._need else None
        end = self._buffer.find(b"\n")
        if end < 0:
            if len(self._buffer) > MAX_LINE_BYTES:
                raise RemoteProtocolError(f"a line of more than {MAX_LINE_BYTES} bytes")
            return None
        line = bytes(self._buffer[:end])
        del self._buffer[: end + 1]
        return line[:-1] if line.endswith(b"\r") else line
