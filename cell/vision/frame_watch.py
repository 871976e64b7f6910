"""Notices cameras that repeat themselves: by number, by time and by pixels.

A sensor's noise makes any two pictures differ, even of a scene that stands still. Equal
pixels under a new number are a frozen camera; an old number or time is a frame delivered
twice. Feed it with pictures that were really taken anew (`Camera.grab_fresh`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cell.devices.camera import Frame

FrameFault = Literal["duplicate", "frozen"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameFinding:
    """One repetition.

    Attributes:
        fault: `duplicate` for a number or time that was there before, `frozen` for pixels.
        camera: Name of the camera.
        number: Number of the frame that repeats.
        repeats: How many frames in a row repeat so, this one included.
        text: A sentence for a technician.
    """

    fault: FrameFault
    camera: str
    number: int
    repeats: int
    text: str


class FrameWatch:
    """Watches the frames of one camera, in the order in which they come."""

    def __init__(self, *, least_repeats: int = 1) -> None:
        """Begin.

        Args:
            least_repeats: How many equal pictures after the first make a frozen camera;
                more than 1 for sources that are meant to stand still for a while.
        """
        self._least_repeats = least_repeats
        self._last: Frame | None = None
        self._equal = 0
        self._old = 0

    def reset(self) -> None:
        """Forget everything: the camera was opened anew."""
        self._last = None
        self._equal = self._old = 0

    def see(self, frame: Frame) -> tuple[FrameFinding, ...]:
        """Return what is wrong with the next frame, beside those before it."""
        last, self._last = self._last, frame
        if last is None:
            return ()
        is_old = frame.number <= last.number or frame.time_s <= last.time_s
        self._old = self._old + 1 if is_old else 0
        if is_old:
            return (self._duplicate(frame, last),)
        is_equal = frame.pixels is last.pixels or np.array_equal(frame.pixels, last.pixels)
        self._equal = self._equal + 1 if is_equal else 0
        if self._equal >= self._least_repeats:
            return (self._frozen(frame),)
        return ()

    def _duplicate(self, frame: Frame, last: Frame) -> FrameFinding:
        text = (
            f"frame {frame.number} at {frame.time_s:.3f} s came after frame {last.number} at "
            f"{last.time_s:.3f} s; a frame was delivered twice or out of order: "
            "close and open the camera"
        )
        return FrameFinding(
            fault="duplicate",
            camera=frame.camera,
            number=frame.number,
            repeats=self._old,
            text=text,
        )

    def _frozen(self, frame: Frame) -> FrameFinding:
        text = (
            f"frame {frame.number} has the same pixels as {self._equal} before it, to the last "
            "bit, which noise rules out: the camera stands still; unplug it and plug it in again"
        )
        return FrameFinding(
            fault="frozen",
            camera=frame.camera,
            number=frame.number,
            repeats=self._equal,
            text=text,
        )
