from __future__ import annotations

import socket
import threading

import pytest

from sessions.journal import Reply
from sessions.sending import send_reply


class Trickle(socket.socket):
    """A socket whose `sendmsg` takes only so many bytes."""

    taken = 0
    writes = 0

    def sendmsg(self, buffers: object, *_: object) -> int:
        assert isinstance(buffers, list)
        self.writes += 1
        data = b"".join(bytes(buffer) for buffer in buffers)[: self.taken]
        self.sendall(data)
        return len(data)


@pytest.mark.parametrize("taken", [0, 3, 5, 6, 50, 105])
def test_the_rest_of_a_partial_write_follows(taken: int) -> None:
    near, far = socket.socketpair()
    with far, Trickle(near.family, near.type, near.proto, near.detach()) as trickle:
        trickle.taken = taken
        send_reply(trickle, Reply(b"VIEW\n", memoryview(bytes(range(100)))))
        trickle.shutdown(socket.SHUT_WR)

        received = b""
        while piece := far.recv(4096):
            received += piece
        assert received == b"VIEW\n" + bytes(range(100))
        assert trickle.writes == 1


def test_a_view_larger_than_every_buffer_arrives_whole() -> None:
    near, far = socket.socketpair()
    data = bytes(range(256)) * 20_000
    with near, far:
        sender = threading.Thread(target=send_reply, args=(near, Reply(b"VIEW\n", data)))
        sender.start()
        received = bytearray()
        while len(received) < 5 + len(data):
            received += far.recv(1 << 16)
        sender.join(20)

        assert received == b"VIEW\n" + data
