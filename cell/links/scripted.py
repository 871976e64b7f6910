"""A link that replays a capture: it knows what must be sent and what is answered."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from cell.clock import Clock
from cell.errors import LinkError
from cell.links.base import Direction


class ScriptedLink:
    """Answers a driver from recorded traffic and insists on the same requests.

    Args:
        name: Name of the device behind the link, as in the profile.
        traffic: What was sent and received, oldest first.
        clock: Slept on by a read that gets nothing, as a real line takes its time-out;
            without one such a read returns at once.
    """

    def __init__(
        self,
        name: str,
        traffic: Iterable[tuple[Direction, bytes]],
        *,
        clock: Clock | None = None,
    ) -> None:
        self._name = name
        self._clock = clock
        self._expected = deque(traffic)
        self._is_open = True

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    @property
    def is_exhausted(self) -> bool:
        """Whether all recorded traffic was used."""
        return not self._expected

    def write(self, data: bytes) -> None:
        """Check `data` against the recording.

        Raises:
            LinkError: The recording has other bytes here, or none, or the link is closed.
        """
        self._require_open()
        rest = data
        while rest:
            if not self._expected or self._expected[0][0] != "to_device":
                raise LinkError(f"{self._name}: the capture has no request here, sent {rest!r}")
            recorded = self._expected.popleft()[1]
            common = min(len(rest), len(recorded))
            if rest[:common] != recorded[:common]:
                raise LinkError(f"{self._name}: the capture has {recorded!r}, sent {rest!r}")
            if len(recorded) > common:
                self._expected.appendleft(("to_device", recorded[common:]))
            rest = rest[common:]

    def read(self, timeout_s: float) -> bytes:
        """Return the next recorded answer, or nothing when a request is due first."""
        self._require_open()
        if self._expected and self._expected[0][0] == "from_device":
            return self._expected.popleft()[1]
        if self._clock is not None:
            self._clock.sleep(timeout_s)
        return b""

    def close(self) -> None:
        """Let the link go."""
        self._is_open = False

    def _require_open(self) -> None:
        if not self._is_open:
            raise LinkError(f"the link to {self._name} is closed")
