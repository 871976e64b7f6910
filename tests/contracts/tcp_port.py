"""A TCP port of loopback whose device end is worked by the driver's own thread."""

from __future__ import annotations

import select
import socket

from cell.errors import LinkError

_READ_BYTES = 4096
_TRANSIT_S = 2.0


class SteppedTcpPort:
    """What `SteppedWire` needs of a port, on TCP; one program is connected at a time."""

    def __init__(self) -> None:
        self._listening: socket.socket | None = None
        self._connected: socket.socket | None = None
        self.number = 0
        self.plug()

    @property
    def is_plugged(self) -> bool:
        return self._listening is not None

    def greet(self) -> None:
        assert self._listening is not None
        if self._connected is not None:
            self._connected.close()
        self._listening.settimeout(_TRANSIT_S)
        self._connected, _ = self._listening.accept()
        self._connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def await_heard(self, count: int, timeout_s: float) -> bytes:
        connected = self._required()
        data = b""
        while len(data) < count:
            if not select.select([connected], [], [], timeout_s)[0]:
                raise LinkError(f"{count - len(data)} bytes were lost on the way")
            data += connected.recv(_READ_BYTES)
        return data

    def say(self, data: bytes) -> int:
        self._required().sendall(data)
        return len(data)

    def plug(self) -> None:
        if self._listening is None:
            self._listening = socket.create_server(("127.0.0.1", self.number))
            self.number = self._listening.getsockname()[1]

    def unplug(self) -> None:
        for one in (self._connected, self._listening):
            if one is not None:
                one.close()
        self._connected = self._listening = None

    def _required(self) -> socket.socket:
        if self._connected is None:
            raise LinkError("nobody is connected")
        return self._connected
