"""A server on a free port and a bare socket to talk to it."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from cell.clock import Clock
from cell.profile import ServerProfile
from sessions.desk import Desk
from sessions.server import Listener, MasServer

DEADLINE_S = 20.0


@contextmanager
def serving(
    desk: Desk,
    *dialects: str,
    limits: ServerProfile | None = None,
    clock: Clock | None = None,
) -> Iterator[MasServer]:
    """Serve a desk in each dialect on its own free port; leave no thread behind."""
    before = set(threading.enumerate())
    listeners = [Listener("127.0.0.1", 0, dialect) for dialect in dialects or ("1.5",)]
    with MasServer(desk, listeners, limits=limits, clock=clock) as server:
        yield server
    left = [t for t in threading.enumerate() if t not in before and t.name.startswith("mas-")]
    assert left == []


class RawClient:
    """Bytes out, bytes in."""

    def __init__(self, server: MasServer, dialect: str = "1.5") -> None:
        address = next(a for a in server.addresses if a.dialect == dialect)
        self.socket = socket.create_connection((address.host, address.port), timeout=DEADLINE_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, data: bytes) -> None:
        self.socket.sendall(data)

    def receive(self, count: int) -> bytes:
        """Return that many bytes, or fewer if the connection ends."""
        data = bytearray()
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            if not piece:
                break
            data += piece
        return bytes(data)

    def line(self) -> bytes:
        """Return one line with its LF."""
        data = bytearray()
        while not data.endswith(b"\n"):
            byte = self.socket.recv(1)
            if not byte:
                break
            data += byte
        return bytes(data)

    def ask(self, line: str, lines: int = 1) -> str:
        """Send a line and return so many lines of reply."""
        self.send(line.encode() + b"\n")
        return b"".join(self.line() for _ in range(lines)).decode().removesuffix("\n")

    def to_ready(self) -> Self:
        assert self.ask("INITIALIZE_TASK Reach LINE", 2).startswith("AVAILABLE_ACTIONS")
        assert self.ask("BEGIN_TASK_SETUP") == "OK"
        assert self.ask("END_TASK_SETUP") == "OK"
        return self

    def leave(self) -> None:
        """Say goodbye; the cell is free and the connection closed when this returns."""
        self.send(b"\nDONE\n")
        rest = self.receive(1 << 24)
        assert rest.endswith(b"GOODBYE\n"), rest[-80:]
        self.socket.close()

    def is_closed_by_server(self) -> bool:
        """Return whether the server ends the connection without another byte."""
        try:
            return self.receive(1) == b""
        except ConnectionResetError:
            return True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.socket.close()


def until_ready(server: MasServer) -> None:
    """Ask for the status until the cell is free."""
    end_s = time.monotonic() + DEADLINE_S
    with RawClient(server, server.addresses[0].dialect) as client:
        while client.ask("STATUS") != "READY":
            assert time.monotonic() < end_s, "the cell does not become free"


def until_alone(server: MasServer) -> None:
    """Wait until no connection is served."""
    end_s = time.monotonic() + DEADLINE_S
    while server.connections:
        assert time.monotonic() < end_s, "a connection does not end"
        for thread in threading.enumerate():
            if thread.name.startswith("mas-127"):
                thread.join(0.05)
