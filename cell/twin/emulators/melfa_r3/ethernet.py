"""The emulated controller's network port: packets without an end, and HC frames on request."""

from __future__ import annotations

from cell.drivers.melfa_r3.codec import END, GarbledMessage
from cell.drivers.melfa_r3.hc_framing import (
    ACKNOWLEDGE,
    ANSWER,
    CHANGE_TO_HC,
    NOTHING,
    REQUEST,
    Frame,
    FrameReader,
    encode_frame,
)
from cell.links.base import Emulator

_ENDS = b"\x00\r\n"
_ACCEPTED = b"QoK"


class EthernetPort:
    """Stands before a controller that expects ends of lines, as its serial port has them.

    A packet is a request, whatever end it has or has not (NUL, CR, LF); a reply has none. After
    `CHGPRT=HC` requests and replies come in frames, until the connection is made anew.
    """

    def __init__(self, controller: Emulator) -> None:
        self._controller = controller
        self._frames: FrameReader | None = None
        self._asked: list[int] = []
        self._own = b""

    def connect(self) -> None:
        """Begin a new connection, without frames."""
        self._frames = None
        self._asked.clear()
        self._own = b""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take a packet that arrives at `now_s`."""
        if self._frames is not None:
            self._take_frames(self._frames, data, now_s)
            return
        for line in data.replace(b"\n", END).replace(b"\x00", END).split(END):
            if line.endswith(CHANGE_TO_HC.encode("ascii")):
                self._own += _ACCEPTED
                self._frames = FrameReader()
            elif line:
                self._controller.receive(line + END, now_s)

    def transmit(self, now_s: float) -> bytes:
        """Return (once) all bytes that are out on the wire by `now_s`."""
        out, self._own = self._own, b""
        data = self._controller.transmit(now_s)
        if self._frames is None:
            return out + data.rstrip(_ENDS)
        for line in data.split(END):
            if line:
                sequence = self._asked.pop(0) if self._asked else 0
                out += encode_frame(Frame(sequence, ANSWER, line.decode("latin-1")))
        return out

    def next_output_s(self) -> float | None:
        """Return when the next bytes will be out, or None if none are coming."""
        return 0.0 if self._own else self._controller.next_output_s()

    def _take_frames(self, reader: FrameReader, data: bytes, now_s: float) -> None:
        try:
            frames = reader.feed(data)
        except GarbledMessage:
            return  # A damaged frame is not acknowledged; the host asks again.
        for frame in frames:
            if frame.kind == REQUEST:
                self._own += encode_frame(Frame(frame.sequence, ACKNOWLEDGE, NOTHING))
                self._asked.append(frame.sequence)
                self._controller.receive(frame.payload.encode("latin-1") + END, now_s)
