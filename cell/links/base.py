"""What a driver needs of the wire, and what an emulator offers behind it."""

from __future__ import annotations

from typing import Literal, Protocol

Direction = Literal["to_device", "from_device"]


class Link(Protocol):
    """A byte stream to one device. Used by one thread at a time."""

    @property
    def name(self) -> str:
        """Name of the device behind the link, as in the profile."""

    def write(self, data: bytes) -> None:
        """Send all bytes.

        Raises:
            LinkError: The link is closed or broken.
        """

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting for at least one byte.

        Returns:
            The bytes, possibly a part of a message or several messages; empty
            when `timeout_s` passed without any.

        Raises:
            LinkError: The link is closed or broken.
        """

    def close(self) -> None:
        """Let the link go; closing twice is harmless."""


class Emulator(Protocol):
    """The far end of a wire: bytes in, bytes out, on somebody else's clock.

    An emulator never sleeps. Time is told to it with every call, and it says
    when it will next have something to send.
    """

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that arrive at `now_s`."""

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""


class Tap(Protocol):
    """Sees every byte on a link; must return quickly and never raise."""

    def __call__(self, link: str, direction: Direction, data: bytes) -> None:
        """Take note of `data` on the link of that name."""
