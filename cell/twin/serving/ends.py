"""The device's end of a port, as a serving thread works it: a pseudo-terminal or TCP."""

from __future__ import annotations

import contextlib
import logging
import socket
from collections.abc import Callable
from typing import Protocol

from cell.errors import CellError
from cell.twin.serving.pty_port import PtyPort

_READ_BYTES = 4096
_log = logging.getLogger(__name__)


class DeviceEnd(Protocol):
    """What a serving thread needs of a port; used by that thread only, once it runs."""

    @property
    def place(self) -> str:
        """What a program opens: a path, or host and port."""

    def descriptors(self) -> tuple[int, ...]:
        """Return what to wait on for bytes or programs that come."""

    def hear(self) -> bytes:
        """Return what has come, without waiting."""

    def say(self, data: bytes) -> None:
        """Send bytes; what nobody takes is lost."""

    def plug(self) -> None:
        """Make the port appear, if it is not there."""

    def unplug(self) -> None:
        """Make the port vanish; whoever has it open loses it."""


class PtyEnd:
    """The device's end of a pseudo-terminal."""

    def __init__(self, port: PtyPort) -> None:
        self._port = port

    @property
    def place(self) -> str:
        """The path that a program opens."""
        return str(self._port.path)

    def descriptors(self) -> tuple[int, ...]:
        """Return the device's end, if the cable is in."""
        return self._port.descriptors()

    def hear(self) -> bytes:
        """Return what has come, as the device hears it."""
        return self._port.hear() if self._port.is_plugged else b""

    def say(self, data: bytes) -> None:
        """Send bytes, as the program will hear them."""
        if self._port.is_plugged and self._port.say(data) < len(data):
            _log.warning("%s: nobody reads; bytes were lost", self.place)

    def plug(self) -> None:
        """Make the port appear."""
        self._port.plug()

    def unplug(self) -> None:
        """Make the port vanish."""
        self._port.unplug()


class TcpEnd:
    """A device that listens on a TCP port and talks to one program at a time.

    Args:
        host: Address to listen on.
        port: TCP port; 0 takes a free one and keeps it.
        on_connect: Called whenever a program is taken, before its first bytes are heard.

    Raises:
        CellError: The address cannot be listened on.
    """

    def __init__(
        self, host: str, port: int, *, on_connect: Callable[[], None] | None = None
    ) -> None:
        self._host = host
        self._port = port
        self._on_connect = on_connect
        self._listening: socket.socket | None = None
        self._connected: socket.socket | None = None
        self.plug()

    @property
    def place(self) -> str:
        """Host and port that a program connects to."""
        return f"{self._host}:{self._port}"

    @property
    def port(self) -> int:
        """The TCP port listened on."""
        return self._port

    def descriptors(self) -> tuple[int, ...]:
        """Return the listening socket and the connection, as far as there are any."""
        return tuple(one.fileno() for one in (self._listening, self._connected) if one is not None)

    def hear(self) -> bytes:
        """Return what has come; drop a program that has left, take one that connects."""
        data = self._receive()
        self._accept()
        return data

    def say(self, data: bytes) -> None:
        """Send bytes to whoever is connected."""
        if self._connected is None:
            return
        try:
            if self._connected.send(data) < len(data):
                _log.warning("%s: nobody reads; bytes were lost", self.place)
        except OSError:
            _log.warning("%s: nobody takes the answer", self.place)

    def plug(self) -> None:
        """Listen."""
        if self._listening is not None:
            return
        try:
            self._listening = socket.create_server((self._host, self._port))
        except OSError as error:
            raise CellError(
                f"{self.place} cannot be listened on: {error.strerror or error}; "
                "choose another port, or end the program that has it"
            ) from error
        self._listening.setblocking(False)
        self._port = self._listening.getsockname()[1]

    def unplug(self) -> None:
        """Listen no more and break the connection off."""
        for one in (self._connected, self._listening):
            if one is not None:
                one.close()
        self._connected = self._listening = None

    def _receive(self) -> bytes:
        if self._connected is None:
            return b""
        try:
            data = self._connected.recv(_READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._connected.close()
            self._connected = None
        return data

    def _accept(self) -> None:
        if self._listening is None:
            return
        with contextlib.suppress(BlockingIOError):
            newcomer, peer = self._listening.accept()
            if self._connected is not None:
                _log.warning("%s: %s turned away, another program is connected", self.place, peer)
                newcomer.close()
                return
            newcomer.setblocking(False)
            newcomer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._connected = newcomer
            if self._on_connect is not None:
                self._on_connect()
