"""A link that lets a tap see every byte that passes."""

from __future__ import annotations

from cell.links.base import Link, Tap


class CapturedLink:
    """Wraps a link and shows both directions to a tap."""

    def __init__(self, link: Link, tap: Tap) -> None:
        self._link = link
        self._name = link.name
        # Every byte of a cell passes here: a bound method is called without the detour
        # that calling an object takes.
        self._note = tap.__call__

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    def write(self, data: bytes) -> None:
        """Send bytes and then show them to the tap: what was not sent is not shown."""
        self._link.write(data)
        self._note(self._name, "to_device", data)

    def read(self, timeout_s: float) -> bytes:
        """Receive bytes and show them to the tap."""
        data = self._link.read(timeout_s)
        if data:
            self._note(self._name, "from_device", data)
        return data

    def close(self) -> None:
        """Close the wrapped link."""
        self._link.close()
