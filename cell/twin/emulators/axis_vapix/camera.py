"""The emulated web camera: an HTTP server on loopback, started and stopped."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable
from http.server import ThreadingHTTPServer
from types import TracebackType
from typing import Self

from cell.clock import Clock, SystemClock
from cell.errors import DeviceError
from cell.twin.emulators.axis_vapix.answers import HeadAnswers
from cell.twin.emulators.axis_vapix.faults import LASTING, Faults, WebCameraFault
from cell.twin.emulators.axis_vapix.gatekeeper import Gatekeeper
from cell.twin.emulators.axis_vapix.handler import Handler
from cell.twin.emulators.axis_vapix.head import Head, HeadState
from cell.twin.emulators.axis_vapix.pictures import PictureSource, encode_jpeg, panorama
from cell.twin.emulators.axis_vapix.settings import EmulatedAxisSettings

_LOGGER = logging.getLogger(__name__)
_POLL_S = 0.02
_STOP_TIMEOUT_S = 5.0


class EmulatedAxisCamera:
    """A camera at `url` that turns, zooms, and can be made to fail.

    Args:
        settings: What kind of camera it is.
        clock: What its head moves by; real time unless given.
        source: What it sees.
        host: Address to listen on.
        port: Port to listen on, 0 for a free one.
        seed: Seed of its nonces.
    """

    def __init__(
        self,
        settings: EmulatedAxisSettings | None = None,
        *,
        clock: Clock | None = None,
        source: PictureSource = panorama,
        host: str = "127.0.0.1",
        port: int = 0,
        seed: int = 0,
    ) -> None:
        self.settings = EmulatedAxisSettings() if settings is None else settings
        now_s: Callable[[], float] = (SystemClock() if clock is None else clock).now_s
        self.head = Head(self.settings, now_s)
        self.answers = HeadAnswers(self.head, self.settings)
        self.gate = Gatekeeper(self.settings, seed)
        self.faults = Faults()
        self.stopping = threading.Event()
        self._source = source
        self._host = host
        self._port = port
        self._viewers = threading.Semaphore(self.settings.most_viewers)
        self._server: _Server | None = None
        self._thread: threading.Thread | None = None
        self._log: list[str] = []
        self._log_lock = threading.Lock()

    @property
    def url(self) -> str:
        """Where the camera is, such as `http://127.0.0.1:8080`."""
        return f"http://{self._host}:{self._port}"

    @property
    def requests(self) -> tuple[str, ...]:
        """Everything that was asked since the start: method, path and query."""
        with self._log_lock:
            return tuple(self._log)

    def start(self) -> None:
        """Listen; starting twice is harmless. A free port, once taken, stays the same.

        Raises:
            DeviceError: The port cannot be had.
        """
        if self._server is not None:
            return
        self.stopping.clear()
        try:
            self._server = _Server((self._host, self._port), Handler)
        except OSError as error:
            raise DeviceError(
                "emulated web camera",
                f"cannot listen on {self._host}:{self._port}: {error.strerror or error}",
                hint="end the program that has the port, or choose another one",
            ) from error
        self._server.camera = self
        self._port = int(self._server.server_address[1])
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=[_POLL_S], name="emulated web camera"
        )
        self._thread.daemon = True
        self._thread.start()

    def stop(self) -> None:
        """End all connections and let the port go; stopping twice is harmless."""
        server, thread = self._server, self._thread
        self._server = self._thread = None
        if server is None or thread is None:
            return
        self.stopping.set()
        self.faults.clear()
        server.shutdown()
        server.server_close()
        thread.join(_STOP_TIMEOUT_S)

    def __enter__(self) -> Self:
        """Listen."""
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End."""
        self.stop()

    def inject(self, fault: WebCameraFault, times: int = LASTING) -> None:
        """Let a fault happen to the next `times` requests or pictures; to all unless given."""
        self.faults.inject(fault, times)

    def clear(self) -> None:
        """End all faults."""
        self.faults.clear()

    def state(self) -> HeadState:
        """Return where the head really is; for tests."""
        return self.head.state()

    def jpeg(self, width_px: int, height_px: int, compression: int) -> bytes:
        """Return what it sees now as a JPEG file."""
        pixels = self._source(self.head.state(), self.settings, width_px, height_px)
        return encode_jpeg(pixels, compression)

    def noted(self, request: str) -> None:
        """Take note of a request."""
        with self._log_lock:
            self._log.append(request)

    def enters(self) -> bool:
        """Return whether one more viewer may watch."""
        return self._viewers.acquire(blocking=False)

    def leaves(self) -> None:
        """Take note that a viewer has gone."""
        self._viewers.release()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    camera: EmulatedAxisCamera

    def handle_error(self, request: object, client_address: object) -> None:
        """Write to the log instead of to the terminal."""
        _LOGGER.warning("a request failed: %r", sys.exception())
