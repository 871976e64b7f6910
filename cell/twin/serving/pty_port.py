"""A pseudo-terminal that looks to a driver like the serial port of a device.

What it cannot show: the kernel keeps speed, stop bits and RTS/CTS that a program sets on
a pseudo-terminal, but always says eight data bits and no parity. So a program that opens
the port at a wrong speed or with wrong stop bits gets garbage, as on a real line; wrong
parity or data bits pass unnoticed here.

For the same reason the C library lets a second program open such a port with parity only
if it changes something else by that: a setting of which nothing took effect is an error.
So the port carries a mark without any effect, a flag of line editing, which every program
clears when it sets the port up, and which is put back afterwards.
"""

from __future__ import annotations

import contextlib
import errno
import os
import random
import select
import termios
import tty
from pathlib import Path

from cell.errors import CellError, LinkError
from cell.profile import SerialProfile
from cell.twin.serving.closings import Closings

_READ_BYTES = 4096
_CFLAG, _LFLAG, _ISPEED, _OSPEED = 2, 3, 4, 5
_MARK = termios.ECHOK


class PtyPort:
    """A port under a path of its own, which stays the same when the cable is pulled and put back.

    Args:
        path: The port's name: a symbolic link that is made here; its folder must exist.
        line: How the device's line is set; the port is set the same until somebody opens it.
        seed: Seed of the garbage that a wrongly set line gives.

    Raises:
        CellError: There is something else at the path, or the system has no pseudo-terminals.
    """

    def __init__(self, path: Path, line: SerialProfile, *, seed: int = 0) -> None:
        self._path = path
        self._line = line
        self._speed = vars(termios).get(f"B{line.baud}")
        self._random = random.Random(seed)
        self._master = -1
        self._slave = -1
        self._closings: Closings | None = None
        self.plug()

    @property
    def path(self) -> Path:
        """The port's name, for whoever opens it."""
        return self._path

    @property
    def is_plugged(self) -> bool:
        """Whether the port is there."""
        return self._master >= 0

    def descriptors(self) -> tuple[int, ...]:
        """Return what to wait on for bytes, and for a program that leaves; empty when unplugged."""
        if self._closings is None:
            return ()
        return tuple(fd for fd in (self._master, self._closings.fileno()) if fd >= 0)

    def plug(self) -> None:
        """Make the port appear under its path.

        Raises:
            CellError: There is something else at the path, or no pseudo-terminal is left.
        """
        if self.is_plugged:
            return
        try:
            # The slave end stays open here: without it the master's reads fail as soon as a
            # program closes the port.
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            self._set_line()
            os.set_blocking(self._master, False)
            self._closings = Closings(os.ttyname(self._slave))
            if self._path.is_symlink():
                self._path.unlink()
            self._path.symlink_to(os.ttyname(self._slave))
        except OSError as error:
            self.unplug()
            raise CellError(
                f"no port can be made at {self._path}: {error.strerror or error}; "
                "give a path in a folder that exists, where there is no file yet"
            ) from error

    def unplug(self) -> None:
        """Make the port vanish; whoever has it open loses it."""
        if self._slave >= 0:
            target = os.ttyname(self._slave)
            with contextlib.suppress(OSError):
                # Another server may have taken the path over meanwhile: that link stays.
                if os.readlink(self._path) == target:
                    self._path.unlink()
        for end in (self._master, self._slave):
            if end >= 0:
                os.close(end)
        self._master = self._slave = -1
        if self._closings is not None:
            self._closings.close()
            self._closings = None

    def greet(self) -> None:
        """Make ready for the next program, after one has set the port up or closed it."""
        self.is_line_right()

    def hear(self) -> bytes:
        """Return what the program has sent, as the device hears it; empty if there is nothing.

        Raises:
            LinkError: The cable is out.
        """
        master = self._require_master()
        if self._closings is not None and self._closings.happened():
            self.greet()
        try:
            data = os.read(master, _READ_BYTES)
        except BlockingIOError:
            return b""
        return data if self.is_line_right() else self._random.randbytes(len(data))

    def await_heard(self, count: int, timeout_s: float) -> bytes:
        """Return the next `count` bytes that the program has sent, as the device hears them.

        Args:
            count: How many bytes are known to be on their way.
            timeout_s: How long they may take in real time; the kernel brings them at once.

        Raises:
            LinkError: The cable is out, or bytes were lost.
        """
        data = self.hear()
        while len(data) < count:
            master = self._require_master()
            if not select.select([master], [], [], timeout_s)[0]:
                raise LinkError(f"{self._path}: {count - len(data)} bytes were lost on the way")
            data += self.hear()
        return data

    def say(self, data: bytes) -> int:
        """Send bytes to the program, as it will hear them; return how many the port took.

        Bytes for which there is no room are lost, as on a line whose listener sleeps.

        Raises:
            LinkError: The cable is out.
        """
        sent = data if self.is_line_right() else self._random.randbytes(len(data))
        try:
            return os.write(self._require_master(), sent)
        except BlockingIOError:
            return 0
        except OSError as error:
            if error.errno == errno.EIO:
                return 0
            raise

    def is_line_right(self) -> bool:
        """Return whether speed and stop bits are the device's; put the mark back.

        The rest of the line's settings is not to be seen.
        """
        if self._slave < 0:
            return True
        attributes = termios.tcgetattr(self._slave)
        if not attributes[_LFLAG] & _MARK:
            attributes[_LFLAG] |= _MARK
            termios.tcsetattr(self._slave, termios.TCSANOW, attributes)
        has_two = bool(attributes[_CFLAG] & termios.CSTOPB)
        return has_two == (self._line.stop_bits == 2) and self._speed in (
            None,
            attributes[_OSPEED],
        )

    def _set_line(self) -> None:
        attributes = termios.tcgetattr(self._slave)
        if self._speed is not None:
            attributes[_ISPEED] = attributes[_OSPEED] = self._speed
        if self._line.stop_bits == 2:
            attributes[_CFLAG] |= termios.CSTOPB
        else:
            attributes[_CFLAG] &= ~termios.CSTOPB
        attributes[_LFLAG] |= _MARK
        termios.tcsetattr(self._slave, termios.TCSANOW, attributes)

    def _require_master(self) -> int:
        if self._master < 0:
            raise LinkError(f"{self._path}: the cable is out")
        return self._master
