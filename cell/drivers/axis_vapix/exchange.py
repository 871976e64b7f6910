"""One HTTP request and its answer, within a deadline and with a sentence for each failure.

Proxies of the environment are not asked: the camera is on the cell's own net.
"""

from __future__ import annotations

import http.client
import os
import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self
from urllib.parse import urlsplit

from cell.clock import Clock
from cell.drivers.axis_vapix.authorization import Credentials
from cell.errors import DeviceError, DeviceTimeout, ProfileError
from cell.profile import WebCameraProfile

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

MOST_BODY_BYTES = 32 * 1024 * 1024
_CHUNK_BYTES = 64 * 1024
_SUCCESS = (200, 204)
_LEAST_WAIT_S = 1e-3


@dataclass(frozen=True, slots=True)
class Reply:
    """A successful answer."""

    content_type: str
    body: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """Where the camera is and who asks.

    Attributes:
        host: Name or number of the camera.
        port: TCP port.
        user: User's name; empty for none.
        password_variable: Environment variable that holds the password; empty for none.
    """

    host: str
    port: int
    user: str
    password_variable: str

    @classmethod
    def from_profile(cls, profile: WebCameraProfile) -> Self:
        """Return the address of a profile's camera.

        Raises:
            ProfileError: The url is none that this driver can use. It is not repeated,
                since it may hold a password.
        """
        try:
            parts = urlsplit(profile.url)
            host, port = parts.hostname, parts.port
        except ValueError:
            host, port = None, None
        else:
            if parts.username is not None or parts.password is not None:
                raise ProfileError(
                    "web_camera.url holds a user or a password; write the user into "
                    "web_camera.user and the name of an environment variable with the "
                    "password into web_camera.password_variable"
                )
            if parts.scheme != "http" or parts.path not in ("", "/") or parts.query:
                host = None
        if not host:
            raise ProfileError(
                "web_camera.url must be http:// and the camera's address, such as "
                "http://192.168.0.90 or http://192.168.0.90:8080"
            )
        return cls(
            host=host,
            port=80 if port is None else port,
            user=profile.user,
            password_variable=profile.password_variable,
        )

    @property
    def text(self) -> str:
        """Host, and the port if it is not the usual one."""
        return self.host if self.port == 80 else f"{self.host}:{self.port}"


class Exchange:
    """Asks the camera, one connection a request.

    Args:
        address: Where the camera is.
        clock: What deadlines are measured with; the net is a matter of real time.
        device: Name of the device in messages.
        user_agent: How the driver introduces itself.
        timeout_s: How long connecting and answering may take.
    """

    def __init__(
        self, address: Address, clock: Clock, *, device: str, user_agent: str, timeout_s: float
    ) -> None:
        self._address = address
        self._clock = clock
        self._device = device
        self._user_agent = user_agent
        self._timeout_s = timeout_s
        variable = address.password_variable
        self._password_is_set = not variable or variable in os.environ
        self._credentials = Credentials(address.user, os.environ.get(variable, ""))

    def get(self, target: str) -> Reply:
        """Return the answer to a request.

        Raises:
            DeviceError: The camera turned it down or answered nonsense.
            DeviceTimeout: It is not there or does not answer.
        """
        with self.open(target) as opened:
            return Reply(opened.content_type, opened.read_all())

    def open(self, target: str) -> OpenReply:
        """Return a successful answer whose body is still to be read.

        Raises:
            DeviceError: The camera turned it down or answered nonsense.
            DeviceTimeout: It is not there or does not answer.
        """
        opened = self._send(target)
        if opened.status == 401 and self._credentials.learn(opened.challenges):
            opened.close()
            opened = self._send(target)
        if opened.status in _SUCCESS:
            return opened
        opened.close()
        raise self._refusal(opened.status, target)

    def _send(self, target: str) -> OpenReply:
        connection = _Connection(self._address, self._clock.now_s)
        connection.allow(self._timeout_s)
        headers = {"User-Agent": self._user_agent, "Connection": "close"}
        authorization = self._credentials.header("GET", target)
        if authorization is not None:
            headers["Authorization"] = authorization
        try:
            connection.request("GET", target, headers=headers)
            response = connection.getresponse()
        except (OSError, http.client.HTTPException) as error:
            connection.close()
            raise self.translated(error, self._timeout_s) from error
        return OpenReply(connection, response, self)

    def translated(self, error: Exception, timeout_s: float) -> DeviceError:
        """Return a failure of the net in our words."""
        where = self._address.text
        if isinstance(error, ConnectionRefusedError):
            return DeviceError(
                self._device,
                f"nothing takes requests at {where}",
                hint="see whether web_camera.url is the camera's address and port",
            )
        if isinstance(error, socket.gaierror):
            return DeviceError(
                self._device,
                f"no computer on this net is called {where}",
                hint="write the camera's number, such as http://192.168.0.90",
            )
        if isinstance(error, TimeoutError):
            return DeviceTimeout(
                self._device,
                f"no answer from {where} within {timeout_s:g} s",
                hint="see whether the camera has power and is on the cell's net",
            )
        if isinstance(error, OSError) and not isinstance(error, ConnectionError):
            return DeviceError(
                self._device,
                f"{where} cannot be reached: {error.strerror or type(error).__name__}",
                hint="see whether this computer is on the cell's net",
            )
        return DeviceError(
            self._device,
            f"{where} ended the connection before its answer was whole",
            hint="see whether the camera restarts, and ask again",
        )

    def too_long(self) -> DeviceError:
        """Return the complaint about an answer without end."""
        return DeviceError(
            self._device,
            f"{self._address.text} sends more than {MOST_BODY_BYTES} bytes for one answer",
            hint="see whether web_camera.url is the camera's address",
        )

    def _refusal(self, status: int, target: str) -> DeviceError:
        path = target.partition("?")[0]
        problem, hint = {
            401: self._who(),
            403: ("lets this user not do that", "give the user operator's rights in the camera"),
            404: (f"has no {path}", "see whether the model and its firmware have this function"),
            503: ("is busy: it has too many viewers", "close other viewers, then ask again"),
        }.get(status, ("turned the request down", "look at the camera's own page"))
        return DeviceError(self._device, problem, code=status, hint=hint)

    def _who(self) -> tuple[str, str]:
        variable, user = self._address.password_variable, self._address.user
        if not user:
            hint = "set user and password_variable in the profile's [web_camera]"
            return "wants a user and a password", hint
        if not variable:
            hint = "set password_variable in the profile's [web_camera]"
            return f"does not let {user!r} in without a password", hint
        if not self._password_is_set:
            return (
                f"wants the password of {user!r}",
                f"put it into the environment variable {variable}",
            )
        return (
            f"does not let {user!r} in with the password in {variable}",
            "correct user or password, or give the user more rights in the camera",
        )


class OpenReply:
    """An answer whose body is read piece by piece."""

    def __init__(
        self, connection: _Connection, response: http.client.HTTPResponse, exchange: Exchange
    ) -> None:
        self._connection = connection
        self._response = response
        self._exchange = exchange
        self.status = response.status
        self.content_type = response.getheader("Content-Type", "")
        self.challenges = response.headers.get_all("WWW-Authenticate", [])

    def __enter__(self) -> Self:
        """Return the answer."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let the connection go."""
        self.close()

    def allow(self, duration_s: float) -> None:
        """Let everything that is read from now on arrive within `duration_s`."""
        self._connection.allow(duration_s)

    def read(self) -> bytes:
        """Return what has arrived, waiting for something; empty at the end.

        Raises:
            DeviceTimeout: Nothing arrived in time.
            DeviceError: The connection broke.
        """
        try:
            return self._response.read1(_CHUNK_BYTES)
        except (OSError, http.client.HTTPException, ValueError) as error:
            # A ValueError is what reading from a file that another thread has closed gives.
            raise self._exchange.translated(error, self._connection.allowed_s) from error

    def read_all(self) -> bytes:
        """Return the whole body.

        Raises:
            DeviceTimeout: It did not arrive in time.
            DeviceError: It is cut off or too long.
        """
        told = self._response.getheader("Content-Length", "")
        pieces, size = [], 0
        while piece := self.read():
            pieces.append(piece)
            size += len(piece)
            if size > MOST_BODY_BYTES:
                raise self._exchange.too_long()
        if told.isdigit() and size < int(told) and self.status != 204:
            raise self._exchange.translated(http.client.IncompleteRead(b"", int(told)), 0.0)
        return b"".join(pieces)

    def interrupt(self) -> None:
        """Have a thread that waits in `read` return at once."""
        self._connection.interrupt()

    def close(self) -> None:
        """Let the connection go; closing twice is harmless."""
        self._response.close()
        self._connection.close()


class _Connection(http.client.HTTPConnection):
    """A connection whose whole answer has one deadline, however slowly it trickles in."""

    def __init__(self, address: Address, now_s: Callable[[], float]) -> None:
        super().__init__(address.host, address.port)
        self._now_s = now_s
        self._deadline_s = 0.0
        self.allowed_s = 0.0
        self._line: _DeadlineSocket | None = None

    def allow(self, duration_s: float) -> None:
        self.allowed_s = duration_s
        self._deadline_s = self._now_s() + duration_s

    def remaining_s(self) -> float:
        remaining_s = self._deadline_s - self._now_s()
        if remaining_s <= 0:
            raise TimeoutError("the answer is late")
        return max(remaining_s, _LEAST_WAIT_S)

    def connect(self) -> None:
        plain = socket.create_connection((self.host, self.port), self.remaining_s())
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._line = _DeadlineSocket(fileno=plain.detach())
        self._line.remaining_s = self.remaining_s
        self._line.settimeout(self.remaining_s())
        self.sock = self._line

    def interrupt(self) -> None:
        if self._line is not None and self._line.fileno() >= 0:
            try:
                self._line.shutdown(socket.SHUT_RDWR)
            except OSError:
                return  # It has ended by itself, which is what was wanted.


class _DeadlineSocket(socket.socket):
    """A socket that waits no longer than somebody allows."""

    remaining_s: Callable[[], float]

    def recv_into(self, buffer: WriteableBuffer, nbytes: int = 0, flags: int = 0) -> int:
        self.settimeout(self.remaining_s())
        return super().recv_into(buffer, nbytes, flags)
