"""What goes wrong with a link, each cause an error of its own.

LinkError (in `cell.errors`)
├── NotOpened            it cannot be opened
│   ├── PortMissing      there is no such port now
│   ├── PortTaken        another program has it
│   ├── PortForbidden    this user may not open it
│   ├── SettingsRefused  the port does not take the parameters
│   └── NotReached       nobody listens at the network address
├── DeviceVanished       it was there, and is gone while the link is open
└── WriteStuck           what is sent does not leave
"""

from __future__ import annotations

from cell.errors import CellError, LinkError


class NotOpened(LinkError):
    """A port or a connection cannot be opened.

    Attributes:
        is_lasting: Whether opening it again at once is in vain: it was never open, or has
            been tried for long enough since it was lost.
    """

    is_lasting = True


def is_lasting(error: CellError) -> bool:
    """Return whether doing again at once what failed is in vain, because no port can be opened."""
    return isinstance(error, NotOpened) and error.is_lasting


class PortMissing(NotOpened):
    """There is no such port.

    Attributes:
        device: Name of the device in the profile.
        port: The port, or the USB serial number that was looked for.
        present: Names of the ports there are.
    """

    def __init__(self, device: str, port: str, present: tuple[str, ...]) -> None:
        self.device = device
        self.port = port
        self.present = present
        there = f"there are {', '.join(present)}" if present else "there is none at all"
        super().__init__(
            f"{device}: no port {port}; {there}; check the cable and the profile's table"
        )


class PortTaken(NotOpened):
    """Another program has the port.

    Attributes:
        device: Name of the device in the profile.
        port: The port.
    """

    def __init__(self, device: str, port: str) -> None:
        self.device = device
        self.port = port
        super().__init__(
            f"{device}: another program has port {port}; close it (a terminal, another `cell`)"
        )


class PortForbidden(NotOpened):
    """The user may not open the port.

    Attributes:
        device: Name of the device in the profile.
        port: The port.
    """

    def __init__(self, device: str, port: str) -> None:
        self.device = device
        self.port = port
        super().__init__(
            f"{device}: no permission to open port {port}; "
            "let an administrator add you to the group that owns it (often dialout)"
        )


class SettingsRefused(NotOpened):
    """The port does not take the parameters of the profile.

    Attributes:
        device: Name of the device in the profile.
        port: The port.
        settings: The parameters, such as `38400 8E2`.
    """

    def __init__(self, device: str, port: str, settings: str, reason: str) -> None:
        self.device = device
        self.port = port
        self.settings = settings
        super().__init__(
            f"{device}: port {port} does not take {settings}: {reason}; "
            "check that it is a serial port, and the profile's parameters"
        )


class NotReached(NotOpened):
    """Nobody answers at a network address.

    Attributes:
        device: Name of the device in the profile.
        address: Host and port.
    """

    def __init__(self, device: str, address: str, reason: str) -> None:
        self.device = device
        self.address = address
        super().__init__(
            f"{device}: no connection to {address}: {reason}; "
            "check that it is on, its network cable, and the address in the profile"
        )


class DeviceVanished(LinkError):
    """The port or the connection was lost while it was open.

    Attributes:
        device: Name of the device in the profile.
        port: The port or address.
    """

    def __init__(self, device: str, port: str, reason: str) -> None:
        self.device = device
        self.port = port
        super().__init__(
            f"{device}: {port} is gone while in use: {reason}; check plug, cable and power"
        )


class WriteStuck(LinkError):
    """Bytes do not leave the port in time.

    Attributes:
        device: Name of the device in the profile.
        port: The port or address.
    """

    def __init__(self, device: str, port: str, timeout_s: float) -> None:
        self.device = device
        self.port = port
        super().__init__(
            f"{device}: {port} did not take what was sent within {timeout_s:g} s; "
            "check the cable and the flow control in the profile"
        )
