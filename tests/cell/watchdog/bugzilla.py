"""A Bugzilla to file bugs at, which also goes down in every way that a server does."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Literal
from urllib.parse import parse_qs, urlsplit

Mood = Literal["up", "refuses", "overloaded", "drops", "deaf after filing", "garbage", "trickles"]
"""`trickles`: the answer comes byte by byte, each within any deadline for one.

`deaf after filing`: the bug is filed, and the connection dies before the answer."""

KEY = "sesame"
REQUIRED = ("product", "component", "summary", "version")
_CODES = {"product": 106, "component": 105, "summary": 107}


@dataclass
class Bug:
    id: int
    fields: Mapping[str, object]
    attachments: list[Mapping[str, object]] = field(default_factory=list)


class BugzillaStandIn:
    """The server, on a free port of the loopback; used with `with`."""

    def __init__(self, *, knows_header: bool = True) -> None:
        self.bugs: list[Bug] = []
        self.mood: Mood = "up"
        self.requests = 0
        self.is_closing = threading.Event()
        self._knows_header = knows_header
        self._lock = threading.Lock()
        stand_in = self

        class Handler(_Handler):
            bugzilla = stand_in

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))
        self._thread.start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self._server.server_address[1]}"

    def close(self) -> None:
        self.is_closing.set()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> BugzillaStandIn:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    def answer(
        self, method: str, path: str, fields: Mapping[str, object], header_key: str
    ) -> tuple[int, dict[str, object]]:
        with self._lock:
            self.requests += 1
            given = fields.get("api_key") or (header_key if self._knows_header else "")
            if given != KEY:
                return 400, error(306, "The API key you specified is invalid.")
            parts = path.strip("/").split("/")
            if parts[:2] != ["rest", "bug"]:
                return 404, error(32614, "No REST API resource found.")
            if method == "POST" and len(parts) == 2:
                return self._file(fields)
            if method == "POST" and len(parts) == 4 and parts[3] == "attachment":
                return self._attach(parts[2], fields)
            if len(parts) == 4 and parts[3] == "attachment":
                return self._files(parts[2])
            return self._get(parts[2])

    def _file(self, fields: Mapping[str, object]) -> tuple[int, dict[str, object]]:
        for name in REQUIRED:
            if not fields.get(name):
                return 400, error(_CODES.get(name, 50), f"{name} is missing")
        if fields["component"] == "Nowhere":
            return 400, error(105, "There is no component named Nowhere")
        alias = fields.get("alias")
        if alias and any(bug.fields.get("alias") == alias for bug in self.bugs):
            return 400, error(103, f"The alias {alias} has already been used.")
        bug = Bug(len(self.bugs) + 17, fields)
        self.bugs.append(bug)
        return 200, {"id": bug.id}

    def _attach(self, name: str, fields: Mapping[str, object]) -> tuple[int, dict[str, object]]:
        for bug in self.bugs:
            if str(bug.id) == name:
                bug.attachments.append(fields)
                return 201, {"ids": [len(bug.attachments)]}
        return 404, error(101, "no such bug")

    def _files(self, name: str) -> tuple[int, dict[str, object]]:
        for bug in self.bugs:
            if str(bug.id) == name:
                files = [{"file_name": a["file_name"]} for a in bug.attachments]
                return 200, {"bugs": {name: files}, "attachments": {}}
        return 404, error(101, "no such bug")

    def _get(self, name: str) -> tuple[int, dict[str, object]]:
        for bug in self.bugs:
            if name in (str(bug.id), bug.fields.get("alias")):
                return 200, {"bugs": [{"id": bug.id}]}
        return 404, error(101, "no such bug")


def error(code: int, message: str) -> dict[str, object]:
    return {"error": True, "code": code, "message": message, "documentation": "none"}


class _Handler(BaseHTTPRequestHandler):
    bugzilla: BugzillaStandIn
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        query = parse_qs(urlsplit(self.path).query)
        self._serve("GET", {name: values[0] for name, values in query.items()})

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", "0")))
        self._serve("POST", json.loads(body))

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def _serve(self, method: str, fields: Mapping[str, object]) -> None:
        mood = self.bugzilla.mood
        if mood == "drops":
            self.close_connection = True
            return
        if mood in ("refuses", "overloaded"):
            status = 503 if mood == "overloaded" else 500
            self._reply(status, error(-32000, "out of order"))
            return
        path = urlsplit(self.path).path
        status, answer = self.bugzilla.answer(
            method, path, fields, self.headers.get("X-BUGZILLA-API-KEY", "")
        )
        if mood == "deaf after filing":
            self.close_connection = True
            return
        if mood == "trickles":
            self._trickle()
            return
        if mood == "garbage":
            self._send(200, b"<html>gateway</html>")
            return
        self._reply(status, answer)

    def _trickle(self) -> None:
        self.send_response(200)
        self.end_headers()
        self.close_connection = True
        with suppress(OSError):  # Until the client has had enough.
            while not self.bugzilla.is_closing.wait(0.02):
                self.wfile.write(b" ")
                self.wfile.flush()

    def _reply(self, status: int, answer: Mapping[str, object]) -> None:
        self._send(status, json.dumps(answer).encode())

    def _send(self, status: int, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)
