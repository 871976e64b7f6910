"""A serial port as a link, opened by pyserial with every parameter from the profile.

On POSIX the open port's descriptor is polled and read as it is: pyserial's own `read`
needs two or three system calls for each byte count, and sets the port up anew whenever
its time-out changes. Elsewhere pyserial does the reading, in slices of a fixed time-out.
"""

from __future__ import annotations

import contextlib
import errno
import math
import os
import select
import time
from collections.abc import Callable

import serial

from cell.errors import LinkError
from cell.links.errors import (
    DeviceVanished,
    PortForbidden,
    PortTaken,
    SettingsRefused,
    WriteStuck,
)
from cell.links.ports import missing, port_of
from cell.links.settings_text import settings_text
from cell.profile import SerialProfile

_REFUSALS: tuple[type[Exception], ...] = (ValueError,)
with contextlib.suppress(ImportError):  # Windows has no termios, nor its errors.
    import termios

    # What the C library says of settings that a port does not take is no OSError.
    _REFUSALS = (ValueError, termios.error)

_READ_BYTES = 4096
_SLICE_S = 0.01
_PARITIES = {"none": serial.PARITY_NONE, "even": serial.PARITY_EVEN, "odd": serial.PARITY_ODD}
_MISSING = frozenset({errno.ENOENT, errno.ENXIO, errno.ENODEV, errno.EIO})
_TAKEN = frozenset({errno.EBUSY, errno.EAGAIN})
_FORBIDDEN = frozenset({errno.EACCES, errno.EPERM})


class SerialLink:
    """An open serial port; nobody else can open it meanwhile.

    Args:
        name: Name of the device behind the port, as in the profile.
        profile: The port and its parameters.
        write_timeout_s: How long bytes may take to leave.
        is_polled: Whether the port's descriptor is polled; where that is possible unless given.

    Raises:
        PortMissing: There is no such port.
        PortTaken: Another program has it.
        PortForbidden: The user may not open it.
        SettingsRefused: It does not take the parameters.
    """

    def __init__(
        self,
        name: str,
        profile: SerialProfile,
        *,
        write_timeout_s: float = 2.0,
        is_polled: bool = os.name == "posix",
    ) -> None:
        self._name = name
        self._write_timeout_s = write_timeout_s
        self.port = _open_port(name, profile, write_timeout_s)
        self._place = str(self.port.port)
        self._is_open = True
        self._fd = -1
        self._read: Callable[[float], bytes] = self._read_by_pyserial
        if is_polled:
            self._fd = self.port.fileno()
            poller = select.poll()
            poller.register(self._fd, select.POLLIN)
            self._poll = poller.poll
            self._read = self._read_polled

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._name

    def write(self, data: bytes) -> None:
        """Send all bytes.

        Raises:
            DeviceVanished: The port is gone.
            WriteStuck: The bytes did not leave in time.
            LinkError: The link is closed.
        """
        self._require_open()
        try:
            rest = data if self._fd < 0 else self._write_at_once(data)
            if rest:
                self.port.write(rest)
        except serial.SerialTimeoutException as error:
            raise WriteStuck(self._name, self._place, self._write_timeout_s) from error
        except OSError as error:
            raise self._vanished(error) from error

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived, waiting in real time for at least one byte.

        Raises:
            DeviceVanished: The port is gone.
            LinkError: The link is closed.
        """
        self._require_open()
        try:
            return self._read(timeout_s)
        except OSError as error:
            raise self._vanished(error) from error

    def close(self) -> None:
        """Let the port go; closing twice is harmless."""
        self._is_open = False
        self.port.close()

    def _write_at_once(self, data: bytes) -> bytes:
        """Write what there is room for, without waiting; return the rest."""
        try:
            return data[os.write(self._fd, data) :]
        except BlockingIOError:
            return data

    def _read_polled(self, timeout_s: float) -> bytes:
        # Rounded up: a wait that ends before its time would spin.
        if not self._poll(math.ceil(max(timeout_s, 0.0) * 1000.0)):
            return b""
        try:
            data = os.read(self._fd, _READ_BYTES)
        except BlockingIOError:
            return b""
        if not data:
            raise OSError(errno.EIO, "end of file")
        return data

    def _read_by_pyserial(self, timeout_s: float) -> bytes:
        port = self.port
        deadline_s = time.monotonic() + timeout_s
        while not (waiting := port.in_waiting):
            if time.monotonic() >= deadline_s:
                return b""
            # In slices of the port's own time-out: changing it sets the whole port up anew.
            first = bytes(port.read(1))
            if first:
                return first + bytes(port.read(port.in_waiting))
        return bytes(port.read(waiting))

    def _vanished(self, error: OSError) -> DeviceVanished:
        return DeviceVanished(self._name, self._place, error.strerror or str(error))

    def _require_open(self) -> None:
        if not self._is_open:
            raise LinkError(f"the link to {self._name} is closed")


def _open_port(name: str, profile: SerialProfile, write_timeout_s: float) -> serial.Serial:
    place = port_of(name, profile)
    port = serial.Serial()
    try:
        port.port = place
        port.baudrate = profile.baud
        port.bytesize = profile.data_bits
        port.parity = _PARITIES[profile.parity]
        port.stopbits = profile.stop_bits
        port.rtscts = profile.flow_control == "rts-cts"
        port.exclusive = True
        port.timeout = _SLICE_S
        port.write_timeout = write_timeout_s
        # Adapters powered from these lines, and devices that wait for them, need them high.
        port.dtr = True
        port.rts = True
        port.open()
        port.reset_input_buffer()
    except OSError as error:
        port.close()
        raise _not_opened(name, place, profile, error) from error
    except _REFUSALS as error:
        port.close()
        raise SettingsRefused(name, place, settings_text(profile), str(error)) from error
    return port


def _not_opened(name: str, place: str, profile: SerialProfile, error: OSError) -> LinkError:
    """Return the error that tells why a port was not opened.

    On Windows pyserial puts the system's error into its text only, and a port that
    another program has open reads "Access is denied" there.
    """
    text = str(error)
    if error.errno in _MISSING or "FileNotFoundError" in text:
        return missing(name, place)
    if error.errno in _TAKEN or "PermissionError(13" in text:
        return PortTaken(name, place)
    if error.errno in _FORBIDDEN:
        return PortForbidden(name, place)
    return SettingsRefused(name, place, settings_text(profile), text)
