"""Pictures one after the other, through reconnections, until somebody stops it."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

from cell.drivers.axis_vapix.exchange import Exchange, OpenReply
from cell.drivers.axis_vapix.multipart import (
    MalformedStream,
    MultipartReader,
    Part,
    boundary_of,
)
from cell.drivers.axis_vapix.replies import MalformedReply, error_text, whole_jpeg
from cell.drivers.axis_vapix.settings import AxisSettings
from cell.errors import DeviceError, DeviceTimeout

_LOGGER = logging.getLogger(__name__)
_FINAL = (400, 401, 403, 404)
"""Refusals that asking again does not change."""


class _NotUnderstood(DeviceError):
    """The camera complains about the request, which asking again does not change."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WebPicture:
    """One picture of the web camera.

    Attributes:
        number: Counts the whole pictures, from 1.
        time_s: When it had arrived, on the cell's clock.
        jpeg: The JPEG file.
    """

    number: int
    time_s: float
    jpeg: bytes


class AxisStream:
    """An iterator of pictures. Use it in a `with`, or call `stop` at the end.

    When no whole picture arrives in time, or the connection breaks, it is opened anew
    after a pause that grows; after too many failures in a row it is given up.
    `stop` may be called from any thread and ends a wait at once.

    Attributes:
        reconnects: How often the stream was opened anew.
        broken: How many pictures were left out because they were not whole.
    """

    def __init__(
        self, exchange: Exchange, target: str, settings: AxisSettings, now_s: Callable[[], float]
    ) -> None:
        self._exchange = exchange
        self._target = target
        self._settings = settings
        self._now_s = now_s
        self._stopped = threading.Event()
        self._lock = threading.Lock()
        self._opened: OpenReply | None = None
        self._reader: MultipartReader | None = None
        self._waiting: deque[Part] = deque()
        self._number = 0
        self._failures = 0
        self.reconnects = 0
        self.broken = 0

    def __enter__(self) -> Self:
        """Return the stream."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop it."""
        self.stop()
        self._close()

    def __iter__(self) -> Self:
        """Return the stream."""
        return self

    def __next__(self) -> WebPicture:
        """Return the next picture.

        Raises:
            StopIteration: The stream was stopped.
            DeviceError: The camera refuses, or the stream failed too often in a row.
        """
        while not self._stopped.is_set():
            try:
                picture = self._next_picture()
            except DeviceError as error:
                self._close()
                if self._stopped.is_set():
                    break
                self._pause_after(error)
                continue
            if picture is not None:
                self._failures = 0
                return picture
        self._close()
        raise StopIteration

    def stop(self) -> None:
        """End the stream; who waits for a picture gets none."""
        self._stopped.set()
        with self._lock:
            if self._opened is not None:
                self._opened.interrupt()

    def _next_picture(self) -> WebPicture | None:
        """Return the next whole picture, or None when the next one is broken."""
        if self._opened is None:
            self._open()
        part = self._next_part()
        try:
            jpeg = whole_jpeg(part.body)
        except MalformedReply as error:
            self.broken += 1
            _LOGGER.info("%s: a picture is left out: %s", self._settings.device, error)
            return None
        self._number += 1
        if self._opened is not None:
            self._opened.allow(self._settings.part_timeout_s)
        return WebPicture(number=self._number, time_s=self._now_s(), jpeg=jpeg)

    def _open(self) -> None:
        opened = self._exchange.open(self._target)
        with self._lock:
            self._opened = opened
        try:
            self._reader = MultipartReader(boundary_of(opened.content_type))
        except MalformedStream as error:
            complaint = error_text(opened.read())
            if complaint is None:
                raise DeviceError(self._settings.device, str(error)) from error
            raise _NotUnderstood(
                self._settings.device,
                f"gives no stream: {complaint}",
                hint="see whether the model has this size and rate",
            ) from error
        opened.allow(self._settings.part_timeout_s)

    def _next_part(self) -> Part:
        opened, reader = self._opened, self._reader
        while not self._waiting:
            if opened is None or reader is None:
                raise DeviceError(self._settings.device, "the stream is not open")
            data = opened.read()
            if not data:
                raise DeviceError(self._settings.device, "the camera ended the stream")
            try:
                self._waiting.extend(reader.feed(data))
            except MalformedStream as error:
                raise DeviceError(self._settings.device, str(error)) from error
        return self._waiting.popleft()

    def _pause_after(self, error: DeviceError) -> None:
        self._failures += 1
        if error.code in _FINAL or isinstance(error, _NotUnderstood):
            raise error
        if self._failures >= self._settings.stream_attempts:
            raise DeviceTimeout(
                self._settings.device,
                f"the stream failed {self._failures} times in a row, at last: {error.problem}",
                code=error.code,
                hint=error.hint or "see whether a still picture comes: `cell webcam still`",
            ) from error
        pause_s = self._settings.back_off_s(self._failures)
        _LOGGER.warning("%s; the stream is opened anew in %.2f s", error, pause_s)
        self._stopped.wait(pause_s)
        self.reconnects += 1

    def _close(self) -> None:
        with self._lock:
            opened, self._opened = self._opened, None
        self._reader = None
        self._waiting.clear()
        if opened is not None:
            opened.close()
