"""Hashes, compresses and writes views beside the session's own thread."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass

import cv2

from cell.devices.camera import Frame
from sessions.recording.errors import RecordingError
from sessions.recording.pictures import PictureStorage, encode_view

_log = logging.getLogger(__name__)

_CLOSE_TIMEOUT_S = 60.0


@dataclass(frozen=True, slots=True)
class _Job:
    number: int
    frame: Frame
    mime: str
    data: bytes | memoryview
    step: int


@dataclass(frozen=True, slots=True)
class _Known:
    number: int
    frame: Frame
    size: int


class ViewWriter:
    """One thread and a bounded queue; whoever is ahead of it waits, nothing is dropped.

    A view of a frame that was already written in the same encoding is not
    written again: its number is given back instead.
    """

    def __init__(
        self,
        write: Callable[[str, int, bytes], None],
        storage: PictureStorage,
        *,
        capacity: int = 6,
    ) -> None:
        """Prepare; the thread starts with the first view.

        Args:
            write: Called on the thread with camera, step and the finished message.
            storage: How pictures are kept.
            capacity: How many views may wait.
        """
        self._write = write
        self._storage = storage
        self._jobs: queue.Queue[_Job | None] = queue.Queue(capacity)
        self._known: dict[tuple[str, str], _Known] = {}
        self._count = 0
        self._thread: threading.Thread | None = None
        self._failure: RecordingError | cv2.error | None = None

    @property
    def count(self) -> int:
        """How many different views were handed over."""
        return self._count

    def take(self, frame: Frame, mime: str, data: bytes | memoryview, step: int) -> int:
        """Hand over a view and return its number; waits while the queue is full."""
        key = (frame.camera, mime)
        known = self._known.get(key)
        if known is not None and known.frame is frame and known.size == len(data):
            return known.number
        self._count += 1
        self._known[key] = _Known(self._count, frame, len(data))
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="view-writer", daemon=True)
            self._thread.start()
        self._jobs.put(_Job(self._count, frame, mime, data, step))
        return self._count

    def close(self) -> None:
        """Write what still waits and end the thread.

        Raises:
            RecordingError: A view could not be written, or the thread does not end.
        """
        if self._thread is not None:
            self._jobs.put(None)
            self._thread.join(_CLOSE_TIMEOUT_S)
            if self._thread.is_alive():
                raise RecordingError(f"views were not written within {_CLOSE_TIMEOUT_S:.0f} s")
            self._thread = None
        if self._failure is not None:
            raise RecordingError(f"views are missing: {self._failure}") from self._failure

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if self._failure is not None:
                continue  # The queue is still emptied, so that nobody waits for ever.
            try:
                message = encode_view(job.number, job.frame, job.mime, job.data, self._storage)
                self._write(job.frame.camera, job.step, message)
            except (RecordingError, cv2.error) as error:
                self._failure = error
                _log.error("view %d could not be recorded: %s", job.number, error)
