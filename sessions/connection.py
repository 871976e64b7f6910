"""One client's connection: its socket, its session and its thread's loop."""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import struct
from typing import Protocol

from cell.clock import Clock
from sessions.journal import Reply
from sessions.sending import send_reply
from sessions.wire.lines import LineReader, Overflow

_log = logging.getLogger(__name__)

RECEIVE_BYTES = 65536
LINGER_S = 1
"""How long a closed connection is drained, so that its last reply is not lost."""
DRAINED_READS = 16

EAGER_READS = 50
"""How often the next line is looked for before the thread sleeps: about 0.1 ms."""

BUSY = Reply(b"BUSY\n", closes=True)


class Conversation(Protocol):
    """What a connection needs of a session."""

    @property
    def has_cell(self) -> bool:
        """Whether ending it means cleaning up."""

    def handle(self, line: bytes) -> Reply:
        """Carry out a line and return the reply."""

    def settle(self) -> None:
        """Do what could wait until the reply had left."""

    def end(self, reason: str) -> None:
        """End the session; its connection is gone."""


class TurnedAway:
    """The conversation with a client for whom there is no room: one `BUSY`."""

    has_cell = False

    def handle(self, line: bytes) -> Reply:
        """Answer whatever comes with `BUSY` and close."""
        return BUSY

    def settle(self) -> None:
        """Do nothing."""

    def end(self, reason: str) -> None:
        """Do nothing."""


class Connection:
    """Reads lines, has them answered, and sends the replies in order.

    `run` belongs to the connection's own thread; `hang_up`, `finish`, `waiting_s`
    and `waiting_since_s` may be used by any.
    """

    def __init__(
        self,
        connected: socket.socket,
        peer: str,
        conversation: Conversation,
        *,
        max_line_bytes: int,
        clock: Clock,
    ) -> None:
        self.peer = peer
        self._socket = connected
        self._conversation = conversation
        self._lines = LineReader(max_line_bytes)
        self._clock = clock
        self._waiting_since_s: float | None = clock.now_s()
        self._reason = ""
        self._is_finishing = False

    @property
    def waiting_since_s(self) -> float | None:
        """When the peer's turn began (it owes a line or has a reply to take), or None."""
        return self._waiting_since_s

    @property
    def waiting_s(self) -> float:
        """For how long the peer has neither completed a line nor taken a reply."""
        since_s = self._waiting_since_s
        return 0.0 if since_s is None else self._clock.now_s() - since_s

    def hang_up(self, reason: str) -> None:
        """Break the connection off now."""
        self._reason = self._reason or reason
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    def finish(self, reason: str) -> None:
        """Read no more; a reply that is under way is still sent."""
        self._reason = self._reason or reason
        self._is_finishing = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RD)

    def run(self) -> None:
        """Serve the client until it leaves or is sent away; end its session."""
        trouble = ""
        try:
            self._serve()
        except OSError as error:
            trouble = f"connection lost: {error.strerror or error}"
        self._waiting_since_s = None
        self._close()
        self._tell(trouble)
        self._conversation.end(self._reason or trouble or "connection closed")

    def _tell(self, trouble: str) -> None:
        """Write one line to the log if the connection did not end as it should."""
        if self._is_finishing:
            return
        if not self._reason and not trouble and self._lines.pending_bytes:
            trouble = "connection closed in the middle of a line"
        if self._conversation.has_cell:
            trouble = f"{self._reason or trouble or 'connection closed'}, cleaning up"
        if self._reason or trouble:
            _log.warning("%s: %s", self.peer, trouble or self._reason)

    def _serve(self) -> None:
        # Whoever drips single bytes of a line is as idle as who sends none, so the
        # wait begins with the last answer, not with the last byte.
        while not self._is_finishing:
            data = self._receive()
            if not data:
                return
            for item in self._lines.feed(data):
                if self._is_finishing or not self._answer(item):
                    return

    def _receive(self) -> bytes:
        """Return what comes next, empty when the client has left.

        A client that has the cell and answers at once is met awake: being woken by the
        system costs more than a step's whole protocol. Others are slept on.
        """
        if self._conversation.has_cell:
            for _ in range(EAGER_READS):
                with contextlib.suppress(BlockingIOError):
                    return self._socket.recv(RECEIVE_BYTES, socket.MSG_DONTWAIT)
                os.sched_yield()
        return self._socket.recv(RECEIVE_BYTES)

    def _answer(self, item: bytes | Overflow) -> bool:
        """Answer one line; return whether the connection stays open."""
        self._waiting_since_s = None
        reply = self._conversation.handle(item.head if isinstance(item, Overflow) else item)
        self._waiting_since_s = self._clock.now_s()
        send_reply(self._socket, reply)
        self._waiting_since_s = self._clock.now_s()
        self._conversation.settle()
        return not reply.closes

    def _close(self) -> None:
        """Close the socket so that the last reply arrives even when the client went on sending.

        Closing with unread input would make the system reset the connection and throw
        away what it has not delivered yet.
        """
        with self._socket, contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
            receive_timeout = struct.pack("ll", LINGER_S, 0)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, receive_timeout)
            for _ in range(DRAINED_READS):
                if not self._socket.recv(RECEIVE_BYTES):
                    break
