"""From bytes as they arrive to whole lines, with a cap on their length."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Overflow:
    """A line is longer than the cap; the rest of it, up to its LF, is discarded.

    Attributes:
        head: The line's first bytes, one more than the cap.
    """

    head: bytes


class LineReader:
    """Buffers bytes and returns complete lines.

    A line ends with LF; one CR before it belongs to the ending. Empty lines are
    skipped. The cap counts a line's bytes without its ending. At most
    `max_line_bytes` + 1 bytes of an unfinished line are kept.
    """

    def __init__(self, max_line_bytes: int) -> None:
        self._max = max_line_bytes
        self._rest = b""
        self._is_discarding = False

    @property
    def pending_bytes(self) -> int:
        """How many bytes of an unfinished line are waiting for their LF."""
        return len(self._rest)

    def feed(self, data: bytes) -> list[bytes | Overflow]:
        """Take bytes and return the lines (without ending) that they complete, in order.

        An `Overflow` comes as soon as a line is too long, not when it ends.
        """
        if self._is_discarding:
            _, lf, data = data.partition(b"\n")
            if not lf:
                return []
            self._is_discarding = False
        *ended, rest = (self._rest + data).split(b"\n")
        items: list[bytes | Overflow] = []
        for line in ended:
            content = line[:-1] if line.endswith(b"\r") else line
            if len(content) > self._max:
                items.append(Overflow(content[: self._max + 1]))
            elif content:
                items.append(content)
        self._rest = self._keep(rest, items)
        return items

    def _keep(self, rest: bytes, items: list[bytes | Overflow]) -> bytes:
        too_long = len(rest) - self._max
        if too_long < 1 or (too_long == 1 and rest.endswith(b"\r")):
            return rest
        items.append(Overflow(rest[: self._max + 1]))
        self._is_discarding = True
        return b""
