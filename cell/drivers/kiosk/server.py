"""The server of the page: tornado with an event loop of its own in a thread of its own."""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import socket
import threading
from collections import OrderedDict
from collections.abc import Callable
from importlib.resources import files

from tornado.httpserver import HTTPServer
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from cell.drivers.kiosk.messages import (
    MOST_BYTES,
    MalformedMessage,
    Show,
    decode_message,
    encode_show,
)
from cell.drivers.kiosk.pages import PageBoard
from cell.drivers.kiosk.telling import STATE_PATH
from cell.errors import DeviceError

_LOGGER = logging.getLogger(__name__)
_PING_S = 5.0
_STOP_TIMEOUT_S = 5.0
_PICTURES_KEPT = 4
"""How many PNG files are kept for pages that are still fetching an older one."""


class KioskServer:
    """Serves the page and its pictures, and tells every page what to show.

    Args:
        device: Name of the device in messages.
        host: Address to listen on.
        port: Port to listen on, 0 for a free one.
        board: Where the pages' words are noted.
        now_s: The cell's time.
        state: Tells as JSON what is on the screen, for other programs of this computer.
    """

    def __init__(
        self,
        device: str,
        host: str,
        port: int,
        board: PageBoard,
        now_s: Callable[[], float],
        state: Callable[[], str],
    ) -> None:
        self._device = device
        self._host = host
        self._port = port
        self._board = board
        self._now_s = now_s
        self._state = state
        self._lock = threading.Lock()
        self._pictures: OrderedDict[str, bytes] = OrderedDict()
        self._show: Show | None = None
        self._running: _Running | None = None
        self.sockets: set[_PageSocket] = set()
        """The lines to the pages; only the server's thread touches it."""

    @property
    def url(self) -> str:
        """Where the page is, such as `http://127.0.0.1:8320/`."""
        return f"http://{self._host}:{self._port}/"

    def start(self) -> None:
        """Listen; starting twice is harmless. A free port, once taken, stays the same.

        Raises:
            DeviceError: The port cannot be had.
        """
        if self._running is not None:
            return
        try:
            listener = socket.create_server((self._host, self._port), backlog=16)
        except OSError as error:
            raise DeviceError(
                self._device,
                f"cannot serve the page on {self._host}:{self._port}: {error.strerror or error}",
                hint="end the program that has the port, or choose another one",
            ) from error
        listener.setblocking(False)
        self._port = int(listener.getsockname()[1])
        self._running = _Running(listener, self._application(), self)

    def stop(self) -> None:
        """Let pages and port go; stopping twice is harmless.

        Raises:
            DeviceError: The server's thread does not end.
        """
        running, self._running = self._running, None
        if running is not None and not running.stop():
            raise DeviceError(
                self._device,
                f"the page's server did not end within {_STOP_TIMEOUT_S:g} s",
                hint="end this program",
            )

    def show(self, show: Show, png: bytes) -> None:
        """Have every page show a picture, and every page that connects later."""
        with self._lock:
            self._pictures[show.sha256] = png
            self._pictures.move_to_end(show.sha256)
            while len(self._pictures) > _PICTURES_KEPT:
                self._pictures.popitem(last=False)
            self._show = show
        if self._running is not None:
            self._running.tell(encode_show(show))

    def picture(self, sha256: str) -> bytes | None:
        """Return a PNG file by its content, or None."""
        with self._lock:
            return self._pictures.get(sha256)

    def greeting(self) -> str | None:
        """Return what a page that connects is told, or None if there is no picture yet."""
        with self._lock:
            return None if self._show is None else encode_show(self._show)

    def joined(self) -> int:
        """Take note of a page and return its number."""
        return self._board.join()

    def left(self, page: int) -> None:
        """Take note that a page has gone."""
        self._board.leave(page)

    def heard(self, page: int, text: str | bytes) -> None:
        """Take note of what a page said.

        Raises:
            MalformedMessage: It is nothing that a page says.
        """
        self._board.hear(page, decode_message(text), self._now_s())

    def _application(self) -> Application:
        return Application(
            [
                (r"/", _AssetHandler, {"name": "page.html", "kind": "text/html"}),
                (r"/page\.js", _AssetHandler, {"name": "page.js", "kind": "text/javascript"}),
                (r"/pictures/([0-9a-f]{64})\.png", _PictureHandler, {"server": self}),
                (r"/socket", _PageSocket, {"server": self}),
                (STATE_PATH, _StateHandler, {"state": self._state}),
            ],
            websocket_ping_interval=_PING_S,
            websocket_ping_timeout=_PING_S,
            websocket_max_message_size=MOST_BYTES,
            log_function=_log_request,
        )


class _Running:
    """One run of the server, from listening to the end of its thread."""

    def __init__(
        self, listener: socket.socket, application: Application, server: KioskServer
    ) -> None:
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        self._pages = server.sockets
        self._listening = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(listener, application), name="kiosk page", daemon=True
        )
        self._thread.start()
        self._listening.wait(_STOP_TIMEOUT_S)

    def tell(self, message: str) -> None:
        """Send every page a message."""
        self._loop.call_soon_threadsafe(self._tell, message)

    def stop(self) -> bool:
        """End the server; return whether its thread has ended."""
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(_STOP_TIMEOUT_S)
        return not self._thread.is_alive()

    def _tell(self, message: str) -> None:
        for page in list(self._pages):
            page.tell(message)

    def _run(self, listener: socket.socket, application: Application) -> None:
        try:
            self._loop.run_until_complete(self._serve(listener, application))
        finally:
            self._loop.close()

    async def _serve(self, listener: socket.socket, application: Application) -> None:
        http = HTTPServer(application)
        http.add_socket(listener)
        self._listening.set()
        await self._end.wait()
        http.stop()
        for page in list(self._pages):
            page.close(1001, "the server ends")
        await http.close_all_connections()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)


class _AssetHandler(RequestHandler):
    """One of the page's own files."""

    def initialize(self, name: str, kind: str) -> None:
        self._name = name
        self._kind = kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self._kind}; charset=utf-8")
        self.set_header("Cache-Control", "no-cache")
        self.write(files(__package__).joinpath(self._name).read_bytes())


class _PictureHandler(RequestHandler):
    """A picture by its content, which therefore never changes."""

    def initialize(self, server: KioskServer) -> None:
        self._server = server

    def get(self, sha256: str) -> None:
        png = self._server.picture(sha256)
        if png is None:
            raise HTTPError(404)
        self.set_header("Content-Type", "image/png")
        self.set_header("Cache-Control", "max-age=31536000, immutable")
        self.write(png)


class _StateHandler(RequestHandler):
    """What is on the screen; only programs of this computer are told."""

    def initialize(self, state: Callable[[], str]) -> None:
        self._state = state

    def get(self) -> None:
        if not _is_loopback(self.request.remote_ip or ""):
            raise HTTPError(403)
        self.set_header("Content-Type", "application/json; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.write(self._state())


class _PageSocket(WebSocketHandler):
    """The line to one page."""

    def initialize(self, server: KioskServer) -> None:
        self._server = server
        self._page = 0

    def open(self, *args: str, **kwargs: str) -> None:
        self._page = self._server.joined()
        self._server.sockets.add(self)
        greeting = self._server.greeting()
        if greeting is not None:
            self.tell(greeting)

    def tell(self, message: str) -> None:
        try:
            self.write_message(message)
        except WebSocketClosedError:
            _LOGGER.debug("page %d has gone before it was told", self._page)

    def on_message(self, message: str | bytes) -> None:
        try:
            self._server.heard(self._page, message)
        except MalformedMessage as error:
            _LOGGER.warning("page %d: %s", self._page, error)
            self.close(1003, "not understood")

    def on_close(self) -> None:
        self._server.sockets.discard(self)
        self._server.left(self._page)


def _is_loopback(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


def _log_request(handler: RequestHandler) -> None:
    _LOGGER.debug("%s %s", handler.get_status(), handler.request.uri)
