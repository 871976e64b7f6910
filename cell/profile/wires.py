"""How a device is wired: a serial port or a TCP address."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table, Text


class SerialProfile(Table):
    """A serial port and its parameters."""

    port: str = ""
    """Name of the port, such as `COM9` or `/dev/ttyUSB0`."""
    usb_serial: str = ""
    """Serial number of the USB adapter; finds the port wherever it is plugged in."""
    baud: Annotated[int, Field(ge=50, le=4_000_000)]
    """Speed of the line in bits a second, as set at the device."""
    data_bits: Literal[7, 8] = 8
    """Data bits of a character."""
    parity: Literal["none", "even", "odd"]
    """Parity bit of a character, as set at the device."""
    stop_bits: Literal[1, 2]
    """Stop bits of a character, as set at the device."""
    flow_control: Literal["none", "rts-cts"] = "none"
    """Whether the two ends hold each other back by the RTS and CTS wires."""


class TcpProfile(Table):
    """A TCP address at which a device is reached."""

    host: Text
    """Name or address of the device."""
    port: Annotated[int, Field(ge=1, le=65535)]
    """TCP port that the device listens on."""
    connect_timeout_s: Positive = 3.0
    """How long connecting may take."""
