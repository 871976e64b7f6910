"""The errors of `sessions`: one tree, each carrying the data its message is made of.

SessionsError
├── WireError               the MAS line protocol was broken
│   ├── LocalProtocolError  we were asked to send what the protocol cannot say
│   └── RemoteProtocolError the other side sent what the protocol does not allow
├── ScriptUnservable        a script needs what the cell does not have
├── ServerError             the server cannot listen or cannot stop
└── ClientError             a client did not get what it asked for
    ├── ServerBusy          another client has the cell
    ├── CommandRefused      the server answered with a refusal
    ├── ReplyTimeout        no answer in time
    └── ConnectionLost      the connection could not be made or broke
"""

from __future__ import annotations


class SessionsError(Exception):
    """Base of every error raised by `sessions`; its text is fit for a person."""


class WireError(SessionsError):
    """The MAS line protocol was broken by one side."""


class LocalProtocolError(WireError):
    """We were asked to send what the protocol cannot say; nothing was sent."""


class RemoteProtocolError(WireError):
    """The other side sent what the protocol does not allow."""


class ScriptUnservable(SessionsError):
    """A script needs what this cell does not have; the text names it."""


class ServerError(SessionsError):
    """The server cannot listen, or did not stop in time."""


class ClientError(SessionsError):
    """A client did not get what it asked for."""


class ServerBusy(ClientError):
    """Another client has the cell, or it is still being cleaned up; try again later."""


class CommandRefused(ClientError):
    """The server answered a command with a refusal.

    Attributes:
        command: The command's line as it was sent, without its LF.
        answer: The refusal's line as it came, without its LF.
    """

    def __init__(self, command: str, answer: str) -> None:
        self.command = command
        self.answer = answer
        super().__init__(f"the server refused {command!r}: {answer}")


class ReplyTimeout(ClientError):
    """The server did not answer in time; the connection is of no more use.

    Attributes:
        command: The command's line as it was sent, without its LF.
        timeout_s: How long the answer was waited for.
    """

    def __init__(self, command: str, timeout_s: float) -> None:
        self.command = command
        self.timeout_s = timeout_s
        super().__init__(f"no answer to {command!r} within {timeout_s:g} s; connect again")


class ConnectionLost(ClientError):
    """The connection could not be made, or the server closed it."""
