"""A blocking MAS client."""

from __future__ import annotations

import socket
import time
from dataclasses import dataclass
from types import TracebackType
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from sessions.errors import (
    ClientError,
    CommandRefused,
    ConnectionLost,
    LocalProtocolError,
    RemoteProtocolError,
    ReplyTimeout,
    ServerBusy,
)
from sessions.views import decode_mif, decode_picture
from sessions.wire import commands as c
from sessions.wire import replies as r
from sessions.wire.dialects import DIALECTS, Dialect
from sessions.wire.incoming import AnswerReader
from sessions.wire.writing import write_answer

RECEIVE_BYTES = 65536

ActionReply = r.ActionDone
"""What an action led to: reward, event, suggestion (the teacher's action) and state."""

_A = TypeVar("_A", bound=r.Answer)


@dataclass(frozen=True, slots=True)
class View:
    """A view as it came.

    Attributes:
        name: Its name.
        mime: Format of the data.
        data: The encoded picture.
        width_px: Width as the task announced it.
        height_px: Height as the task announced it.
    """

    name: str
    mime: str
    data: bytes | memoryview
    width_px: int
    height_px: int

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture: shape (height, width, 3), uint8, R G B.

        A MIF picture shares the memory of `data`.

        Raises:
            SessionsError: The data is not of the announced format.
        """
        return decode_mif(self.data) if self.mime == "image/mif" else decode_picture(self.data)


class MasClient:
    """Drives a task over one connection; commands block until they are answered.

    Every command raises `ServerBusy` when another client has the cell,
    `CommandRefused` when the server refuses it, `ReplyTimeout` when no answer
    comes in time, `ConnectionLost` when the connection breaks, and
    `RemoteProtocolError` when the answer is none. Use as a context manager:
    leaving says `DONE` unless the connection is broken.
    """

    def __init__(self, connected: socket.socket, timeout_s: float) -> None:
        """Use a connected socket; `MasClient.connect` makes one and learns the dialect."""
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connected.settimeout(timeout_s)
        self._socket = connected
        self._timeout_s = timeout_s
        self._reader = AnswerReader(DIALECTS["1.5"])
        self._sizes: dict[str, tuple[int, int]] = {}
        self._is_open = True

    @classmethod
    def connect(cls, host: str, port: int, timeout_s: float = 60.0) -> Self:
        """Connect to a server and ask which dialect it speaks.

        Args:
            host: Name or address.
            port: TCP port.
            timeout_s: How long every answer may take. Laying out takes a real cell
                some seconds a block.

        Raises:
            ConnectionLost: There is no server at that address.
            ServerBusy: It has no room for another connection.
            RemoteProtocolError: It does not speak MAS, or a dialect that we do not know.
        """
        try:
            connected = socket.create_connection((host, port), timeout=timeout_s)
        except OSError as error:
            raise ConnectionLost(
                f"no connection to {host}:{port}: {error.strerror or error}; is the server running?"
            ) from error
        client = cls(connected, timeout_s)
        try:
            client.info()
        except ClientError:
            client.close()
            raise
        return client

    @property
    def dialect(self) -> Dialect:
        """The dialect the server speaks."""
        return self._reader.dialect

    # Who are you, and are you free?

    def status(self) -> bool:
        """Return whether the server is ready for this client."""
        answer = self._ask(c.Status())
        if isinstance(answer, r.Busy):
            return False
        self._expect(c.Status(), answer, r.Ready)
        return True

    def info(self) -> r.ServerInfo:
        """Return what server this is, and from now on speak its dialect.

        Raises:
            RemoteProtocolError: It speaks a dialect that we do not know.
        """
        info = self._call(c.Info(), r.ServerInfo)
        if info.protocol not in DIALECTS:
            self.close()
            raise RemoteProtocolError(
                f"the server speaks MAS {info.protocol}; known are {', '.join(DIALECTS)}"
            )
        self._reader.use(DIALECTS[info.protocol])
        return info

    def goals(self) -> tuple[str, ...]:
        """Return the names of the goals."""
        return self._call(c.ListGoals(), r.Goals).names

    def environments(self, goal: str) -> tuple[str, ...]:
        """Return the names of the environments in which a goal can be used."""
        return self._call(c.ListEnvironments(goal), r.Environments).names

    # A task and its set-up

    def use_seed(self, seed: int) -> None:
        """Have everything random in this session follow from a seed (0 to 2**32 - 1)."""
        self._call(c.UseGlobalSeed(seed), r.Ok)

    def initialize_task(self, goal: str, environment: str) -> r.TaskOffer:
        """Take the cell for a task and return the task's actions and views."""
        offer = self._call(c.InitializeTask(goal, environment), r.TaskOffer)
        self._sizes = {view.name: (view.width_px, view.height_px) for view in offer.views}
        return offer

    def begin_setup(self) -> None:
        """Begin the task's settings."""
        self._call(c.BeginTaskSetup(), r.Ok)

    def setting(self, name: str, *values: str) -> None:
        """Make a setting of the task.

        Raises:
            LocalProtocolError: A command has this name.
        """
        if name in self.dialect.verbs:
            raise LocalProtocolError(f"a setting cannot be called {name}: that is a command")
        self._call(c.Setting(name, values), r.Ok)

    def end_setup(self) -> str:
        """Have the blocks laid out; return a suggested first action, or an empty text."""
        if self.dialect.setup_answers_state:
            return self._call(c.EndTaskSetup(), r.StateUpdated).suggestion
        self._call(c.EndTaskSetup(), r.Ok)
        return ""

    def start(self, goal: str, environment: str) -> r.TaskOffer:
        """Take the cell for a task, make no settings, and return when the task is ready."""
        offer = self.initialize_task(goal, environment)
        self.begin_setup()
        self.end_setup()
        return offer

    def teaching(self, *, is_on: bool) -> None:
        """Have actions suggested from now on, or not."""
        self._call(c.Teaching(is_on), r.Ok)

    # A task that is ready

    def action(self, name: str) -> ActionReply:
        """Carry out an action."""
        return self._call(c.Action(name), r.ActionDone)

    def get_view(self, name: str) -> View:
        """Return a view of the scene as it is now."""
        data = self._call(c.GetView(name), r.ViewData)
        width_px, height_px = self._sizes.get(name, (0, 0))
        return View(data.name, data.mime, data.data, width_px, height_px)

    def reset_task(self) -> str:
        """Go back to the task's start; return a suggested first action, or an empty text."""
        return self._call(c.ResetTask(), r.StateUpdated).suggestion

    # The session

    def logs(self) -> dict[str, str]:
        """Return the session's logs by name."""
        files = self._call(c.Logs(), r.LogFiles).files
        return {file.name: file.data.decode("utf-8", "replace") for file in files}

    def trajectories(self) -> int:
        """Return how many recorded trajectories there are."""
        return self._call(c.GetTrajectoriesCount(), r.TrajectoriesCount).count

    def trajectory_length(self, index: int) -> int:
        """Return how many steps a recorded trajectory has."""
        return self._call(c.GetTrajectoryLength(index), r.TrajectoryLength).steps

    def sleep(self) -> None:
        """Have the server turn new clients away."""
        self._call(c.Sleep(), r.Ok)

    def reset(self) -> None:
        """Give the cell back and begin a new session on this connection."""
        self._call(c.Reset(), r.Ok)

    def done(self) -> None:
        """Say goodbye and close the connection."""
        try:
            self._call(c.Done(), r.Goodbye)
        finally:
            self.close()

    def close(self) -> None:
        """Close the connection without a word; harmless when it is closed."""
        self._is_open = False
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._is_open and error is None:
            self.done()
        self.close()

    # Questions and answers

    def _call(self, command: c.Command, wanted: type[_A]) -> _A:
        return self._expect(command, self._ask(command), wanted)

    def _expect(self, command: c.Command, answer: r.Answer, wanted: type[_A]) -> _A:
        if isinstance(answer, wanted):
            return answer
        line = c.format_command(command).decode("utf-8")
        if isinstance(answer, r.Busy):
            raise ServerBusy(
                f"another client has the cell, so {line!r} was not carried out; try again later"
            )
        text, _ = write_answer(answer, self._reader.dialect)
        words = text.decode("utf-8", "backslashreplace").rstrip("\n")
        if isinstance(answer, r.REFUSALS):
            raise CommandRefused(line, words)
        self.close()
        raise RemoteProtocolError(f"the server answered {words!r} to {line!r}")

    def _ask(self, command: c.Command) -> r.Answer:
        line = c.format_command(command)
        if not self._is_open:
            raise ConnectionLost(f"{line.decode()!r} was not sent: the connection is closed")
        try:
            self._socket.sendall(line + b"\n")
            return self._next_answer()
        except TimeoutError as error:
            self.close()
            raise ReplyTimeout(line.decode("utf-8"), self._timeout_s) from error
        except OSError as error:
            self.close()
            reason = error.strerror or str(error)
            raise ConnectionLost(f"the connection broke at {line.decode()!r}: {reason}") from error
        except (RemoteProtocolError, ConnectionLost):
            self.close()
            raise

    def _next_answer(self) -> r.Answer:
        deadline_s = time.monotonic() + self._timeout_s
        while (answer := self._reader.next_answer()) is None:
            place = self._reader.wanted()
            if place is None:
                data = self._socket.recv(RECEIVE_BYTES)
                count = len(data)
                self._reader.feed(data)
            else:
                count = self._socket.recv_into(place)
                self._reader.received(count)
            if not count:
                raise ConnectionLost("the server closed the connection before it answered")
            if time.monotonic() > deadline_s:
                raise TimeoutError
        return answer
