"""Which serial ports this machine has, and which of them a profile means."""

from __future__ import annotations

from dataclasses import dataclass

from serial.tools import list_ports

from cell.links.errors import PortMissing
from cell.profile import SerialProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class PortInfo:
    """A serial port of this machine.

    Attributes:
        name: What the port is opened by, such as `/dev/ttyUSB0` or `COM9`.
        usb_serial: Serial number of the USB adapter, empty when it has none or is none.
        description: What the system says of it.
        vendor_id: USB vendor id, or None.
        product_id: USB product id, or None.
    """

    name: str
    usb_serial: str = ""
    description: str = ""
    vendor_id: int | None = None
    product_id: int | None = None


def present_ports() -> tuple[PortInfo, ...]:
    """Return the serial ports there are now, by name."""
    found = (
        PortInfo(
            name=port.device,
            usb_serial=port.serial_number or "",
            description="" if port.description in (None, "n/a") else port.description,
            vendor_id=port.vid,
            product_id=port.pid,
        )
        for port in list_ports.comports()
    )
    return tuple(sorted(found, key=lambda port: port.name))


def port_of(device: str, profile: SerialProfile) -> str:
    """Return the name of the port that a profile means.

    A USB serial number goes before a name: it is the same wherever the adapter is plugged in.

    Raises:
        PortMissing: No adapter with that serial number is plugged in, or neither is given.
    """
    if not profile.usb_serial:
        if not profile.port:
            raise PortMissing(device, "(the profile gives neither port nor usb_serial)", _names())
        return profile.port
    for port in present_ports():
        if port.usb_serial == profile.usb_serial:
            return port.name
    raise PortMissing(device, f"with USB serial number {profile.usb_serial}", _names())


def missing(device: str, port: str) -> PortMissing:
    """Return the error that tells that there is no such port, and which there are."""
    return PortMissing(device, port, _names())


def _names() -> tuple[str, ...]:
    return tuple(
        f"{port.name} (USB serial {port.usb_serial})" if port.usb_serial else port.name
        for port in present_ports()
    )
