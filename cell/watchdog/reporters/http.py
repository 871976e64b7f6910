"""JSON over HTTP with the standard library: deadlines, no proxies, errors as sentences."""

from __future__ import annotations

import json
import time
import urllib.error
import urllib.request
from collections.abc import Mapping
from dataclasses import dataclass
from http.client import HTTPException
from typing import Protocol

from cell.watchdog.report import ReportUndelivered

_MOST_ANSWER_BYTES = 1 << 20
_PIECE_BYTES = 1 << 14


class _Readable(Protocol):
    def read1(self, count: int, /) -> bytes: ...


@dataclass(frozen=True, slots=True)
class Answer:
    """What a server answered.

    Attributes:
        status: HTTP status.
        fields: The JSON object of the body; empty if the body is none.
    """

    status: int
    fields: Mapping[str, object]


class JsonClient:
    """Sends JSON to one server.

    Args:
        who: Name of the server, for messages.
        timeout_s: Deadline of each exchange.
        headers: Sent with every request.
    """

    def __init__(
        self, who: str, timeout_s: float, headers: Mapping[str, str] | None = None
    ) -> None:
        self._who = who
        self._timeout_s = timeout_s
        self._headers = {
            "Content-Type": "application/json",
            "Accept": "application/json",
            **(headers or {}),
        }
        # Whatever proxies the environment names, a tracker is reached directly.
        self._opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))

    def post(self, url: str, fields: Mapping[str, object]) -> Answer:
        """Send fields as JSON and return the answer, refusals included.

        Raises:
            ReportUndelivered: The server does not answer, or not in HTTP.
        """
        return self._exchange(url, json.dumps(fields).encode())

    def get(self, url: str) -> Answer:
        """Ask for something and return the answer, refusals included.

        Raises:
            ReportUndelivered: The server does not answer, or not in HTTP.
        """
        return self._exchange(url, None)

    def _exchange(self, url: str, body: bytes | None) -> Answer:
        deadline_s = time.monotonic() + self._timeout_s
        try:
            request = urllib.request.Request(url, data=body, headers=self._headers)  # noqa: S310
            with self._opener.open(request, timeout=self._timeout_s) as response:
                return Answer(response.status, _fields(_body(response, deadline_s)))
        except urllib.error.HTTPError as error:
            with error:
                return Answer(error.code, _fields(_rest(error, deadline_s)))
        except (OSError, HTTPException) as error:
            reason = getattr(error, "reason", error)
            raise ReportUndelivered(f"{self._who} does not answer: {reason}") from error
        except ValueError as error:
            # Its text may hold what was sent, a key among it.
            raise ReportUndelivered(
                f"{self._who} cannot be asked: its address or key holds characters that HTTP "
                "does not carry",
                is_final=True,
            ) from error


def _body(response: _Readable, deadline_s: float) -> bytes:
    """Return a body that has come by a deadline, however slowly it trickles in.

    Raises:
        TimeoutError: It had not come by then.
    """
    body = b""
    while len(body) < _MOST_ANSWER_BYTES:
        piece = response.read1(_PIECE_BYTES)
        if not piece:
            break
        body += piece
        if time.monotonic() > deadline_s:
            raise TimeoutError("its answer trickles in too slowly")
    return body


def _rest(error: urllib.error.HTTPError, deadline_s: float) -> bytes:
    try:
        return error.read(_MOST_ANSWER_BYTES) if time.monotonic() < deadline_s else b""
    except (OSError, HTTPException):
        return b""


def _fields(body: bytes) -> Mapping[str, object]:
    try:
        fields = json.loads(body)
    except ValueError:
        return {}
    return fields if isinstance(fields, dict) else {}
