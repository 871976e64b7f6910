"""A TCP connection as a link: the arm controller's other wire."""

from __future__ import annotations

import contextlib
import math
import os
import select
import socket
from collections.abc import Callable

from cell.errors import LinkError
from cell.links.errors import DeviceVanished, NotReached, WriteStuck
from cell.profile import TcpProfile

_READ_BYTES = 4096


class TcpLink:
    """An open connection to a device.

    Args:
        name: Name of the device, as in the profile.
        profile: Its address.
        write_timeout_s: How long bytes may take to leave.
        is_polled: Whether the socket is polled; where that is possible unless given. Windows
            only has `select`, which elsewhere fails at descriptors above 1023.

    Raises:
        NotReached: Nobody answers at the address.
    """

    def __init__(
        self,
        name: str,
        profile: TcpProfile,
        *,
        write_timeout_s: float = 2.0,
        is_polled: bool = os.name == "posix",
    ) -> None:
        self._name = name
        self._write_timeout_s = write_timeout_s
        self._place = f"{profile.host}:{profile.port}"
        try:
            self._socket = socket.create_connection(
                (profile.host, profile.port), timeout=profile.connect_timeout_s
            )
        except OSError as error:
            reason = error.strerror or str(error)
            raise NotReached(name, self._place, reason) from error
        # Requests are small and each waits for its reply: Nagle's algorithm would hold them back.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(write_timeout_s)
        self._is_open = True
        self._has_data: Callable[[float], bool] = self._has_data_by_select
        if is_polled:
            self._poller = select.poll()
            self._poller.register(self._socket, select.POLLIN)
            self._has_data = self._has_data_by_poll

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    def write(self, data: bytes) -> None:
        """Send all bytes.

        Raises:
            DeviceVanished: The connection broke.
            WriteStuck: The bytes did not leave in time.
            LinkError: The link is closed.
        """
        self._require_open()
        try:
            self._socket.sendall(data)
        except TimeoutError as error:
            raise WriteStuck(self._name, self._place, self._write_timeout_s) from error
        except OSError as error:
            raise self._vanished(error.strerror or str(error)) from error

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting in real time for at least one byte.

        Raises:
            DeviceVanished: The connection broke or the device closed it.
            LinkError: The link is closed.
        """
        self._require_open()
        if not self._has_data(max(timeout_s, 0.0)):
            return b""
        try:
            data = self._socket.recv(_READ_BYTES)
        except OSError as error:
            raise self._vanished(error.strerror or str(error)) from error
        if not data:
            raise self._vanished("the device closed the connection")
        return data

    def close(self) -> None:
        """Close the connection; closing twice is harmless."""
        if self._is_open:
            self._is_open = False
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            self._socket.close()

    def _has_data_by_poll(self, timeout_s: float) -> bool:
        # Rounded up: a wait that ends before its time would spin.
        return bool(self._poller.poll(math.ceil(timeout_s * 1000.0)))

    def _has_data_by_select(self, timeout_s: float) -> bool:
        return bool(select.select([self._socket], [], [], timeout_s)[0])

    def _vanished(self, reason: str) -> DeviceVanished:
        return DeviceVanished(self._name, self._place, reason)

    def _require_open(self) -> None:
        if not self._is_open:
            raise LinkError(f"the link to {self._name} is closed")
