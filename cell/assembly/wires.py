"""How the drivers of a cell reach its devices: in memory, over pseudo-terminals, over ports."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from cell.clock import Clock
from cell.drivers.melfa_r3.ethernet import FramedLink, PacketLink
from cell.errors import CellError
from cell.links.base import Link, Tap
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.links.opening import lazy_link, open_wire
from cell.links.reconnecting import ReconnectingLink
from cell.profile import Profile, SerialProfile, TcpProfile
from cell.stop import StopToken
from cell.twin.serving.pty_port import PtyPort
from cell.twin.serving.stepped import SteppedWire
from cell.twin.wire_faults import FaultyEmulator

Wires = Literal["memory", "pty", "hardware"]
TwinWires = Literal["memory", "pty"]
TcpFraming = Literal["text", "hc"]


class WireLoom:
    """The links of a cell, and whatever has to be given back when it is disposed of.

    Attributes:
        links: The link of each serial device by name: `arm`, `gripper`, `display`.
    """

    def __init__(self) -> None:
        self.links: dict[str, Link] = {}
        self._ports: list[SteppedWire] = []
        self._folder: Path | None = None

    def close(self) -> None:
        """Close every link and make the pseudo-terminals vanish; closing twice is harmless."""
        for link in self.links.values():
            link.close()
        for port in self._ports:
            port.close()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    @classmethod
    def in_memory(
        cls, emulators: Mapping[str, FaultyEmulator], clock: Clock, tap: Tap | None
    ) -> WireLoom:
        """Return links that join drivers to emulators directly."""
        loom = cls()
        for name, emulator in emulators.items():
            loom._add(name, MemoryLink(name, emulator, clock), tap)
        return loom

    @classmethod
    def over_pty(
        cls,
        profile: Profile,
        emulators: Mapping[str, FaultyEmulator],
        clock: Clock,
        tap: Tap | None,
        stop: StopToken,
    ) -> WireLoom:
        """Return links that pyserial opens, with the emulators behind pseudo-terminals.

        Raises:
            CellError: The system has no pseudo-terminals.
        """
        loom = cls()
        folder = loom._folder = Path(tempfile.mkdtemp(prefix="robocell-ports-"))
        try:
            for name, line in serial_lines(profile).items():
                port_line = line.model_copy(update={"port": str(folder / name), "usb_serial": ""})
                wire = SteppedWire(emulators[name], PtyPort(folder / name, port_line), clock)
                loom._ports.append(wire)
                loom._add(name, _stepped_link(name, wire, port_line, clock, stop), tap)
        except CellError:
            loom.close()
            raise
        return loom

    @classmethod
    def over_ports(
        cls, profile: Profile, clock: Clock, tap: Tap | None, stop: StopToken
    ) -> WireLoom:
        """Return links to the ports of a profile; none is opened before it is used."""
        loom = cls()
        for name, line in serial_lines(profile).items():
            tcp = profile.arm.tcp if name == "arm" else None
            link = (
                lazy_link(name, line, clock, token=stop)
                if tcp is None
                else network_arm_link(name, tcp, profile.arm.tcp_framing, clock, stop)
            )
            loom._add(name, link, tap)
        return loom

    def _add(self, name: str, link: Link, tap: Tap | None) -> None:
        self.links[name] = link if tap is None else CapturedLink(link, tap)


def serial_lines(profile: Profile) -> dict[str, SerialProfile]:
    """Return the serial line of each device of a cell by name."""
    return {
        "arm": profile.arm.serial,
        "gripper": profile.gripper.serial,
        "display": profile.display.serial,
    }


def network_arm_link(
    name: str, address: TcpProfile, framing: TcpFraming, clock: Clock, stop: StopToken
) -> ReconnectingLink:
    """Return a link to an arm controller on the network; each connection begins afresh."""
    return ReconnectingLink(
        name, lambda: framed(open_wire(name, address), framing, clock), clock, token=stop
    )


def framed(connection: Link, framing: TcpFraming, clock: Clock) -> Link:
    """Return a new connection to an arm controller as its driver uses it, like a serial port."""
    return FramedLink(connection, clock) if framing == "hc" else PacketLink(connection)


def _stepped_link(
    name: str, wire: SteppedWire, line: SerialProfile, clock: Clock, stop: StopToken
) -> ReconnectingLink:
    return ReconnectingLink(
        name, lambda: wire.open(lambda: open_wire(name, line)), clock, token=stop
    )
