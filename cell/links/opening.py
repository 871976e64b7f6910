"""From a profile to a link; nothing is opened before it is used.

A cell can be put together while a cable is out. The error then comes from the first use
of the device, with its name.
"""

from __future__ import annotations

from cell.clock import Clock
from cell.links.base import Link
from cell.links.reconnecting import ReconnectingLink
from cell.profile import SerialProfile, TcpProfile
from cell.stop import StopToken


def open_wire(name: str, wire: SerialProfile | TcpProfile) -> Link:
    """Open a port or a connection now.

    Raises:
        LinkError: It cannot be opened; the text says why and what to do.
    """
    if isinstance(wire, TcpProfile):
        from cell.links.tcp import TcpLink

        return TcpLink(name, wire)
    from cell.links.serial import SerialLink

    return SerialLink(name, wire)


def lazy_link(
    name: str, wire: SerialProfile | TcpProfile, clock: Clock, *, token: StopToken | None = None
) -> ReconnectingLink:
    """Return a link that opens its port when first used, and again after a loss.

    Args:
        name: Name of the device, as in the profile.
        wire: Its port or address.
        clock: Waited on between two tries to open it again.
        token: Where a stop is asked for, nothing is waited for.
    """
    return ReconnectingLink(name, lambda: open_wire(name, wire), clock, token=token)
