"""A reply onto a socket: one write, nothing concatenated."""

from __future__ import annotations

import socket

from sessions.journal import Reply


def send_reply(connection: socket.socket, reply: Reply) -> None:
    """Send a reply's text and data in one write; the rest of a partial write follows.

    Raises:
        OSError: The connection is broken.
    """
    if not reply.data:
        connection.sendall(reply.text)
        return
    sent = connection.sendmsg([reply.text, reply.data])
    if sent < len(reply.text):
        connection.sendall(reply.text[sent:])
        sent = len(reply.text)
    if sent < len(reply.text) + len(reply.data):
        connection.sendall(memoryview(reply.data)[sent - len(reply.text) :])
