"""What a failed test leaves behind for whoever repairs it: bytes, pictures, versions."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2

from cell.clock import Clock
from cell.devices.camera import Frame
from cell.errors import VisionError
from cell.links.base import Direction, Tap

_MOST_MESSAGES = 400


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file that goes with a report."""

    name: str
    mime: str
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """What was seen while a test failed.

    Attributes:
        wire: The last messages on all wires during the test, one a line.
        pictures: Pictures that the test took, as PNG.
        versions: Version of everything that matters, by name.
    """

    wire: str
    pictures: tuple[Attachment, ...]
    versions: Mapping[str, str]

    def attachments(self) -> tuple[Attachment, ...]:
        """Return everything that is a file of its own."""
        wire = Attachment("wire.txt", "text/plain", self.wire.encode())
        return ((wire,) if self.wire else ()) + self.pictures


class WireLog:
    """A tap that remembers the last messages while it is asked to, and hands all of them on.

    A cell's links have one tap; this one stands in front of the recorder's.
    """

    def __init__(self, clock: Clock, following: Tap | None = None) -> None:
        self._clock = clock
        self._following = following
        self._lines: deque[str] = deque(maxlen=_MOST_MESSAGES)
        self._is_on = False

    def begin(self) -> None:
        """Forget what was noted and take note from now on."""
        self._lines.clear()
        self._is_on = True

    def end(self) -> str:
        """Take no more note; return what was noted, one message a line."""
        self._is_on = False
        return "\n".join(self._lines)

    def __call__(self, link: str, direction: Direction, data: bytes) -> None:
        """Take note of bytes on a link."""
        if self._is_on:
            arrow = ">" if direction == "to_device" else "<"
            printable = data.decode("ascii", "backslashreplace").encode("unicode_escape").decode()
            self._lines.append(
                f"{self._clock.now_s():12.4f} s {link:8} {arrow} {data.hex(' ')}  {printable}"
            )
        if self._following is not None:
            self._following(link, direction, data)


def gather(wire: str, frames: Sequence[Frame], versions: Mapping[str, str]) -> Evidence:
    """Return the evidence of a failed test."""
    return Evidence(
        wire=wire,
        pictures=tuple(_as_png(index, frame) for index, frame in enumerate(frames, 1)),
        versions=dict(versions),
    )


def _as_png(index: int, frame: Frame) -> Attachment:
    is_encoded, data = cv2.imencode(".png", cv2.cvtColor(frame.pixels, cv2.COLOR_RGB2BGR))
    if not is_encoded:
        raise VisionError(f"the picture of camera {frame.camera} cannot be written as PNG")
    return Attachment(f"{index}-{frame.camera}.png", "image/png", data.tobytes())
