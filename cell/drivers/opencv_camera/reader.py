"""A thread that waits for pictures, so that nobody else has to wait without end.

OpenCV's `grab` may block for ever when a camera falls silent. The thread takes every picture
as it comes, so the newest is never older than one frame period, and a caller waits at most
until its deadline. A thread stuck in `grab` cannot be ended; it is a daemon, and it gives the
capture back itself should `grab` ever return.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.clock import Clock
from cell.drivers.opencv_camera.capture import Capture

_JOIN_S = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grabbed:
    """One picture as it came.

    Attributes:
        number: Counts the pictures of this reader from 1.
        time_s: When `grab` returned, on the cell's clock.
        source_s: The source's own time in seconds, None if it tells none.
        picture: As OpenCV gave it, None if it could not be decoded.
    """

    number: int
    time_s: float
    source_s: float | None
    picture: NDArray[np.uint8] | None


class Reader:
    """Reads a capture on a thread of its own."""

    def __init__(self, name: str, capture: Capture, clock: Clock, *, is_live: bool) -> None:
        """Start reading.

        Args:
            name: Name of the camera, for the thread's name.
            capture: The open source; the reader gives it back.
            clock: Tells when a picture came.
            is_live: Whether the source runs by itself: only the newest picture counts.
                Otherwise (files) the next one is read when the last one was taken.
        """
        self._capture = capture
        self._clock = clock
        self._is_live = is_live
        self._changed = threading.Condition()
        self._newest: Grabbed | None = None
        self._wanted = 0
        self._has_ended = False
        self._problem = ""
        self._is_stopped = False
        self._thread = threading.Thread(target=self._read, name=f"camera {name}", daemon=True)
        self._thread.start()

    @property
    def problem(self) -> str:
        """Why reading ended by a fault; empty if it did not."""
        return self._problem

    @property
    def has_ended(self) -> bool:
        """Whether the source gives no more pictures."""
        return self._has_ended

    def next(self, timeout_s: float) -> Grabbed | None:
        """Return the first picture that comes after this call; None if none comes in time.

        The deadline is real time: a camera does not know the cell's clock.
        """
        deadline_s = time.monotonic() + timeout_s
        with self._changed:
            after = self._newest.number if self._newest is not None else 0
            self._wanted = after + 1
            self._changed.notify_all()
            while self._newest is None or self._newest.number <= after:
                left_s = deadline_s - time.monotonic()
                if self._has_ended or self._is_stopped or left_s <= 0:
                    return None
                self._changed.wait(left_s)
            return self._newest

    def stop(self) -> bool:
        """End the thread; return False if it is stuck in the source."""
        with self._changed:
            self._is_stopped = True
            self._changed.notify_all()
        self._thread.join(_JOIN_S)
        return not self._thread.is_alive()

    def _read(self) -> None:
        try:
            number = 0
            while self._may_read(number):
                if not self._capture.grab():
                    break
                number += 1
                self._publish(number)
        except cv2.error as error:
            self._problem = f"OpenCV failed: {error}"
        finally:
            self._capture.release()
            with self._changed:
                self._has_ended = True
                self._changed.notify_all()

    def _may_read(self, number: int) -> bool:
        """Return whether to go on; wait for somebody who wants a picture of a file."""
        with self._changed:
            while not self._is_live and self._wanted <= number and not self._is_stopped:
                self._changed.wait(_JOIN_S)
            return not self._is_stopped

    def _publish(self, number: int) -> None:
        time_s = self._clock.now_s()
        source_ms = self._capture.get(cv2.CAP_PROP_POS_MSEC)
        grabbed = Grabbed(
            number=number,
            time_s=time_s,
            source_s=source_ms / 1000.0 if source_ms > 0 else None,
            picture=self._capture.retrieve(),
        )
        with self._changed:
            self._newest = grabbed
            self._changed.notify_all()
