"""The MAS server: one thread a connection, blocking sockets, one desk."""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import Self

from cell.clock import Clock, SystemClock
from cell.profile import ServerProfile
from cell.stop import Bell
from sessions.connection import Connection, Conversation, TurnedAway
from sessions.desk import Desk
from sessions.errors import ServerError
from sessions.session import Session
from sessions.wire.dialects import Dialect, dialect_named

_log = logging.getLogger(__name__)

ACCEPT_RETRY_S = 0.2
"""Pause after the system had no resources for a new connection."""

IDLE_CHECKS = 10
"""How many times within the idle time-out the connections are looked at, or more often."""

MAX_IDLE_CHECK_S = 5.0
"""The longest time between two looks at the connections."""

UNBLOCK_S = 2.0
"""How long threads may take to end once their sockets are broken off."""


@dataclass(frozen=True, slots=True)
class Listener:
    """An address to listen on, and the dialect spoken there; port 0 takes a free one."""

    host: str
    port: int
    dialect: str


class MasServer:
    """Serves a desk to experiment clients on one or more listeners.

    Use as a context manager, or `start` and `shutdown`. All methods may be used
    by any thread.
    """

    def __init__(
        self,
        desk: Desk,
        listeners: Sequence[Listener],
        *,
        limits: ServerProfile | None = None,
        clock: Clock | None = None,
        ready: Callable[[Sequence[Listener]], None] | None = None,
    ) -> None:
        """Prepare; nothing listens yet.

        Args:
            desk: Who has the cell.
            listeners: Where to listen.
            limits: Idle time-out, line length and number of connections; those of the
                desk's profile unless given.
            clock: The time by which clients are idle; real time unless given.
            ready: Called with the addresses in use as soon as connections are accepted.

        Raises:
            LocalProtocolError: There is no such dialect.
        """
        self._desk = desk
        self._wanted = [(listener, dialect_named(listener.dialect)) for listener in listeners]
        self._limits = limits or desk.profile.server
        self._clock = clock or SystemClock()
        self._ready = ready
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._bell = Bell()
        self._sockets: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._connections: dict[Connection, threading.Thread] = {}
        self._served: list[threading.Thread] = []
        self._bound: tuple[Listener, ...] = ()

    @property
    def addresses(self) -> tuple[Listener, ...]:
        """The addresses in use, with the real ports."""
        return self._bound

    @property
    def connections(self) -> int:
        """How many connections are open or being cleaned up after."""
        with self._lock:
            return len(self._connections)

    def start(self) -> None:
        """Listen and return.

        Raises:
            ServerError: An address cannot be listened on.
        """
        bound: list[Listener] = []
        try:
            for listener, _ in self._wanted:
                self._sockets.append(_listen(listener))
                host, port = self._sockets[-1].getsockname()[:2]
                bound.append(Listener(host, port, listener.dialect))
        except ServerError:
            self._close_listeners()
            raise
        self._bound = tuple(bound)
        for listening, (_, dialect) in zip(self._sockets, self._wanted, strict=True):
            self._spawn("mas-accept", partial(self._accept, listening, dialect))
        self._spawn("mas-idle", self._watch_idle)
        if self._ready is not None:
            self._ready(self._bound)

    def request_stop(self) -> None:
        """Let `wait` return; fit for a signal handler, as it takes no lock."""
        self._bell.ring()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Return True when somebody asks for a stop, or False after `timeout_s`."""
        return self._bell.wait(timeout_s)

    def close_idle(self) -> None:
        """Break off every connection that has been silent for longer than the limit."""
        with self._lock:
            connections = list(self._connections)
        for connection in connections:
            if connection.waiting_s > self._limits.idle_timeout_s:
                connection.hang_up("silent for too long")

    def shutdown(self, timeout_s: float = 120.0, *, peer_grace_s: float = 2.0) -> None:
        """Stop: send replies under way, close connections, give the cell back clean.

        Args:
            timeout_s: How long commands under way and the cleaning of the cell may take.
            peer_grace_s: How long, at least, a client may take to receive a reply.

        Raises:
            ServerError: They took longer; the cell may not be clean.
        """
        self._stopping.set()
        self._bell.ring()
        self._close_listeners()
        with self._lock:
            running = tuple(self._connections)
            served = tuple(self._served)
        for connection in running:
            connection.finish("server stopped")
        threads = [*self._threads, *served]
        if self._part(running, threads, timeout_s, peer_grace_s):
            return
        for connection in running:
            connection.hang_up("server stopped")
        if not _join(threads, UNBLOCK_S):
            raise ServerError(
                f"a connection did not end within {timeout_s:g} s; the cell may not be clean"
            )

    def _part(
        self,
        running: Iterable[Connection],
        threads: Sequence[threading.Thread],
        timeout_s: float,
        peer_grace_s: float,
    ) -> bool:
        """Wait for threads to end; break off clients that take no reply."""
        deadline_s = time.monotonic() + timeout_s
        stuck: dict[Connection, float | None] = {}
        while not _join(threads, min(peer_grace_s, deadline_s - time.monotonic())):
            if time.monotonic() >= deadline_s:
                return False
            for connection in running:
                since_s = connection.waiting_since_s
                if since_s is not None and stuck.get(connection) == since_s:
                    connection.hang_up("server stopped")
                stuck[connection] = since_s
        return True

    # Threads

    def _accept(self, listening: socket.socket, dialect: Dialect) -> None:
        while not self._stopping.is_set():
            try:
                connected, address = listening.accept()
            except OSError as error:
                if not self._stopping.is_set():
                    _log.warning("no connection accepted: %s", error.strerror or error)
                    self._stopping.wait(ACCEPT_RETRY_S)
                continue
            if not self._admit(connected, f"{address[0]}:{address[1]}", dialect):
                connected.close()

    def _admit(self, connected: socket.socket, peer: str, dialect: Dialect) -> bool:
        """Start a connection's thread; return False if there is no room for it at all."""
        with contextlib.suppress(OSError):
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        with self._lock:
            room = self._limits.max_connections - len(self._connections)
            if self._stopping.is_set() or room <= -self._limits.max_connections:
                return False
            conversation: Conversation = (
                Session(self._desk, dialect, peer) if room > 0 else TurnedAway()
            )
            connection = Connection(
                connected,
                peer,
                conversation,
                max_line_bytes=self._limits.max_line_bytes,
                clock=self._clock,
            )
            thread = threading.Thread(
                target=self._serve, args=(connection,), name=f"mas-{peer}", daemon=True
            )
            self._connections[connection] = thread
            # A thread still runs a little after its connection is no longer counted.
            self._served = [one for one in self._served if one.is_alive()] + [thread]
            if room <= 0:
                _log.warning("%s: too many connections, turned away", peer)
            thread.start()
        return True

    def _serve(self, connection: Connection) -> None:
        try:
            connection.run()
        finally:
            with self._lock:
                del self._connections[connection]

    def _watch_idle(self) -> None:
        period_s = min(MAX_IDLE_CHECK_S, self._limits.idle_timeout_s / IDLE_CHECKS)
        while not self._stopping.wait(period_s):
            self.close_idle()

    def _spawn(self, name: str, work: Callable[[], None]) -> None:
        thread = threading.Thread(target=work, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _close_listeners(self) -> None:
        for listening in self._sockets:
            # Closing alone does not wake a thread that waits in accept.
            with contextlib.suppress(OSError):
                listening.shutdown(socket.SHUT_RDWR)
            listening.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.shutdown()


def _listen(listener: Listener) -> socket.socket:
    family = socket.AF_INET6 if ":" in listener.host else socket.AF_INET
    try:
        return socket.create_server((listener.host, listener.port), family=family, backlog=128)
    except OSError as error:
        raise ServerError(
            f"cannot listen on {listener.host}:{listener.port}: {error.strerror or error}; "
            "choose another port, or 0 for a free one"
        ) from error


def _join(threads: Sequence[threading.Thread], timeout_s: float) -> bool:
    """Wait for threads to end; return whether all did."""
    deadline_s = time.monotonic() + timeout_s
    for thread in threads:
        thread.join(max(0.0, deadline_s - time.monotonic()))
    return not any(thread.is_alive() for thread in threads)
