"""How a device is wired: a serial port or a TCP address."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table


class SerialProfile(Table):
    """A serial port and its parameters."""

    port: str = ""
    """Name of the port, such as `COM9` or `/dev/ttyUSB0`."""
    usb_serial: str = ""
    """Serial number of the USB adapter; finds the port wherever it is plugged in."""
    baud: Annotated[int, Field(ge=50)]
    data_bits: Literal[7, 8] = 8
    parity: Literal["none", "even", "odd"]
    stop_bits: Literal[1, 2]
    flow_control: Literal["none", "rts-cts"] = "none"


class TcpProfile(Table):
    """A TCP address at which a device is reached."""

    host: str
    port: Annotated[int, Field(ge=1, le=65535)]
    connect_timeout_s: Positive = 3.0
