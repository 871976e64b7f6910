"""The controller over TCP: replies without an end of their own, or in HC frames.

Both are links that the dialogue uses like the serial port: requests end with a carriage
return, and so do the replies that it reads.
"""

from __future__ import annotations

from cell.clock import Clock
from cell.drivers.melfa_r3.codec import END, GarbledMessage
from cell.drivers.melfa_r3.hc_framing import (
    ACKNOWLEDGE,
    CHANGE_TO_HC,
    NOTHING,
    REQUEST,
    SEQUENCES,
    TAKEN,
    Frame,
    FrameReader,
    encode_frame,
)
from cell.errors import DeviceTimeout
from cell.links.base import Link

_ENDS = b"\x00\r\n"


class PacketLink:
    """Each packet is one reply; it gets the carriage return that the controller leaves out."""

    def __init__(self, link: Link) -> None:
        self._link = link

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._link.name

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        self._link.write(data)

    def read(self, timeout_s: float) -> bytes:
        """Return the packet that has arrived, with its end, or nothing."""
        data = self._link.read(timeout_s).rstrip(_ENDS)
        return data + END if data else b""

    def close(self) -> None:
        """Let the link go."""
        self._link.close()


class FramedLink:
    """Speaks HC frames; the change to them is asked for before the first request.

    Args:
        link: The connection.
        clock: The cell's clock, for the deadline of the change.
        timeout_s: How long the controller may take to change.
    """

    def __init__(self, link: Link, clock: Clock, *, timeout_s: float = 2.0) -> None:
        self._link = link
        self._clock = clock
        self._timeout_s = timeout_s
        self._reader = FrameReader()
        self._sequence = 0
        self._is_framed = False

    @property
    def name(self) -> str:
        """Name of the device behind the link."""
        return self._link.name

    def write(self, data: bytes) -> None:
        """Send requests, each in a frame.

        Raises:
            DeviceTimeout: The controller does not change to frames.
            LinkError: The link is closed or broken.
        """
        if not self._is_framed:
            self._change()
        self._reader.clear()
        for line in data.rstrip(END).split(END):
            self._send(REQUEST, line.decode("latin-1"))
            self._sequence = (self._sequence + 1) % SEQUENCES

    def read(self, timeout_s: float) -> bytes:
        """Return the answers that have arrived, waiting for at least one.

        Raises:
            GarbledMessage: A frame is damaged.
            LinkError: The link is closed or broken.
        """
        deadline_s = self._clock.now_s() + timeout_s
        answers = b""
        while not answers:
            left_s = deadline_s - self._clock.now_s()
            data = self._link.read(max(left_s, 0.0))
            if not data:
                return b""
            answers = self._answers(data)
        return answers

    def close(self) -> None:
        """Let the link go; the next one begins without frames."""
        self._is_framed = False
        self._link.close()

    def _answers(self, data: bytes) -> bytes:
        answers = b""
        for frame in self._frames(data):
            if frame.kind != ACKNOWLEDGE:
                self._link.write(encode_frame(Frame(frame.sequence, TAKEN, NOTHING)))
                answers += frame.payload.encode("latin-1") + END
        return answers

    def _frames(self, data: bytes) -> list[Frame]:
        try:
            return self._reader.feed(data)
        except GarbledMessage as error:
            raise GarbledMessage(error.problem, device=self.name) from error

    def _change(self) -> None:
        for request in ("1;1;OPEN=TOOLBOX", f"1;1;{CHANGE_TO_HC}"):
            self._link.write(request.encode("ascii") + END)
            reply = self._link.read(self._timeout_s)
            if not reply.startswith((b"QoK", b"Qok")):
                raise DeviceTimeout(
                    self.name,
                    f"the controller did not change to frames: {reply[:40]!r} came for {request}",
                    hint="set the profile's framing to text",
                )
        self._is_framed = True

    def _send(self, kind: str, payload: str) -> None:
        self._link.write(encode_frame(Frame(self._sequence, kind, payload)))
