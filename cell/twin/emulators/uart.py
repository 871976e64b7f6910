"""The sending half of a serial line: bytes leave one after the other."""

from __future__ import annotations

from collections import deque

from cell.profile import SerialProfile


class Transmitter:
    """Queues messages and hands out the bytes that have left by a given time.

    Args:
        byte_s: Time one byte takes on the line: start, data, parity and stop bits
            divided by the baud rate.
    """

    def __init__(self, byte_s: float) -> None:
        self._byte_s = byte_s
        self._queue: deque[tuple[float, bytes]] = deque()
        self._free_s = 0.0

    def send(self, data: bytes, ready_s: float) -> None:
        """Queue a message that may start at `ready_s`, behind everything queued before."""
        self._free_s = max(self._free_s, ready_s) + len(data) * self._byte_s
        self._queue.append((self._free_s, data))

    def take(self, now_s: float) -> bytes:
        """Return, once, all bytes whose last bit has left by `now_s`."""
        queue = self._queue
        sent = b""
        while queue and queue[0][0] <= now_s:
            sent += queue.popleft()[1]
        if queue:
            end_s, data = queue[0]
            left = len(data) - int((end_s - now_s) / self._byte_s) - 1
            if left > 0:
                sent += data[:left]
                queue[0] = (end_s, data[left:])
        return sent

    def next_s(self) -> float | None:
        """Return when the message at the head of the queue will be out, or None."""
        return self._queue[0][0] if self._queue else None

    def clear(self) -> None:
        """Drop everything that has not left yet."""
        self._queue.clear()
        self._free_s = 0.0


def byte_time_s(*, baud: int, data_bits: int, parity: str, stop_bits: int) -> float:
    """Return how long one byte takes: one start bit, data, parity unless `none`, stop bits."""
    return (1 + data_bits + (parity != "none") + stop_bits) / baud


def line_byte_s(line: SerialProfile) -> float:
    """Return how long one byte takes on the line of a profile."""
    return byte_time_s(
        baud=line.baud,
        data_bits=line.data_bits,
        parity=line.parity,
        stop_bits=line.stop_bits,
    )
