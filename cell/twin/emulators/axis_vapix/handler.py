"""One request to the emulated web camera."""

from __future__ import annotations

import logging
from http.server import BaseHTTPRequestHandler
from typing import TYPE_CHECKING, cast
from urllib.parse import parse_qsl, urlsplit

from cell.drivers.axis_vapix.tables import HEAD_PATH, PARAMETER_PATH, STILL_PATH, STREAM_PATH
from cell.twin.emulators.axis_vapix.answers import Mistake, Query, parameters
from cell.twin.emulators.axis_vapix.faults import WebCameraFault

if TYPE_CHECKING:
    from cell.twin.emulators.axis_vapix.camera import EmulatedAxisCamera

_LOGGER = logging.getLogger(__name__)
_BOUNDARY = "myboundary"
_OLD_STREAM_PATH = "/mjpg/video.mjpg"
_LONGEST_SILENCE_S = 60.0
_SIZES = {"160x120", "320x240", "480x360", "640x480", "1280x720", "1920x1080"}


class Handler(BaseHTTPRequestHandler):
    """Answers GET requests; the server has the camera."""

    protocol_version = "HTTP/1.1"
    timeout = 30.0

    @property
    def camera(self) -> EmulatedAxisCamera:
        """The camera that is asked."""
        return cast("EmulatedAxisCamera", self.server.camera)  # type: ignore[attr-defined]

    def do_GET(self) -> None:  # noqa: N802 - the name that http.server looks for
        """Answer one request."""
        camera, faults = self.camera, self.camera.faults
        camera.noted(self.path)
        self.close_connection = True
        if faults.takes(WebCameraFault.SILENT):
            faults.hold(_LONGEST_SILENCE_S)
            return
        if faults.takes(WebCameraFault.DROPPED):
            return
        if not self._is_admitted():
            return
        try:
            self._route()
        except Mistake as error:
            self._text(f"Error: {error}\r\n")
        except (BrokenPipeError, ConnectionResetError, TimeoutError):
            _LOGGER.debug("a viewer has gone")

    def log_message(self, format: str, *arguments: object) -> None:
        """Write to the log instead of to the terminal."""
        _LOGGER.debug(format, *arguments)

    def _is_admitted(self) -> bool:
        camera, faults = self.camera, self.camera.faults
        header = self.headers.get("Authorization", "")
        agent = self.headers.get("User-Agent", "")
        if camera.settings.needs_browser and not agent.startswith("Mozilla/"):
            self._refuse(403)
        elif faults.takes(WebCameraFault.UNAUTHORISED):
            self._refuse(401, camera.gate.challenges(""))
        elif faults.takes(WebCameraFault.FORBIDDEN):
            self._refuse(403)
        elif faults.takes(WebCameraFault.BUSY):
            self._refuse(503)
        elif not camera.gate.admits(header, self.command, self.path):
            self._refuse(401, camera.gate.challenges(header))
        else:
            return True
        return False

    def _route(self) -> None:
        camera, parts = self.camera, urlsplit(self.path)
        query = dict(parse_qsl(parts.query, keep_blank_values=True))
        if camera.faults.takes(WebCameraFault.ERROR_TEXT):
            raise Mistake("syntax error in request")
        if parts.path == STILL_PATH:
            self._still(query)
        elif parts.path in (STREAM_PATH, _OLD_STREAM_PATH):
            self._stream(query)
        elif parts.path == HEAD_PATH and camera.settings.has_head:
            self._text(camera.answers.answer(query))
        elif parts.path == PARAMETER_PATH and camera.settings.tells_name:
            self._text(parameters(query, camera.settings))
        elif parts.path == PARAMETER_PATH:
            self._refuse(401, camera.gate.challenges(""))
        else:
            self._refuse(404)

    def _still(self, query: Query) -> None:
        jpeg = self._picture(query)
        self._head("image/jpeg", len(jpeg))
        self._send_picture(jpeg)

    def _stream(self, query: Query) -> None:
        camera = self.camera
        if not camera.enters():
            self._refuse(503)
            return
        try:
            self._send_stream(query)
        finally:
            camera.leaves()

    def _send_stream(self, query: Query) -> None:
        camera, settings = self.camera, self.camera.settings
        asked = _number(query.get("fps") or query.get("req_fps"), 0.0, "fps")
        rate_hz = asked or settings.rate_hz
        jpeg = self._picture(query)
        name = f"--{_BOUNDARY}" if settings.names_dashes else _BOUNDARY
        quoted = f'"{name}"' if settings.quotes_boundary else name
        self._head(f"multipart/x-mixed-replace;boundary={quoted}", None)
        while not camera.stopping.is_set():
            length = f"Content-Length: {len(jpeg)}\r\n" if settings.tells_length else ""
            head = f"--{_BOUNDARY}\r\nContent-Type: image/jpeg\r\n{length}\r\n"
            self.wfile.write(head.encode("ascii"))
            if not self._send_picture(jpeg):
                return
            self.wfile.write(b"\r\n")
            camera.stopping.wait(1.0 / rate_hz)
            jpeg = self._picture(query)

    def _send_picture(self, jpeg: bytes) -> bool:
        """Send a picture with what goes wrong with it; return whether it was sent whole."""
        faults, half = self.camera.faults, len(jpeg) // 2
        if faults.takes(WebCameraFault.CUT_OFF):
            self.wfile.write(jpeg[:half])
            return False
        if faults.takes(WebCameraFault.SLOW):
            self.wfile.write(jpeg[:half])
            self.wfile.flush()
            faults.hold(_LONGEST_SILENCE_S)
            jpeg = jpeg[half:]
        self.wfile.write(jpeg)
        return True

    def _picture(self, query: Query) -> bytes:
        size = query.get("resolution", "640x480")
        if size not in _SIZES:
            raise Mistake(f"resolution {size} is not supported")
        width, height = (int(word) for word in size.split("x"))
        compression = int(_number(query.get("compression"), 30.0, "compression"))
        jpeg = self.camera.jpeg(width, height, compression)
        if self.camera.faults.takes(WebCameraFault.BROKEN_JPEG):
            return bytes(len(jpeg))
        return jpeg

    def _text(self, text: str | None) -> None:
        if text is None:
            self.send_response(204)
            self.end_headers()
            return
        body = text.encode("utf-8")
        self._head("text/plain", len(body))
        self.wfile.write(body)

    def _head(self, content_type: str, length: int | None) -> None:
        self.send_response(200)
        self.send_header("Content-Type", content_type)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.send_header("Cache-Control", "no-cache")
        self.end_headers()

    def _refuse(self, status: int, challenges: list[str] | None = None) -> None:
        self.send_response(status)
        for challenge in challenges or ():
            self.send_header("WWW-Authenticate", challenge)
        self.send_header("Content-Length", "0")
        self.end_headers()


def _number(text: str | None, default: float, name: str) -> float:
    if text is None:
        return default
    try:
        return float(text)
    except ValueError:
        raise Mistake(f"{name} is no number") from None
