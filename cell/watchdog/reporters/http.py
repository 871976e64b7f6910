"""JSON over HTTP with the standard library: deadlines, no proxies, errors as sentences."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from collections.abc import Mapping
from dataclasses import dataclass
from http.client import HTTPException

from cell.watchdog.report import ReportUndelivered

_MOST_ANSWER_BYTES = 1 << 20


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
        try:
            request = urllib.request.Request(url, data=body, headers=self._headers)  # noqa: S310
            with self._opener.open(request, timeout=self._timeout_s) as response:
                return Answer(response.status, _fields(response.read(_MOST_ANSWER_BYTES)))
        except urllib.error.HTTPError as error:
            with error:
                return Answer(error.code, _fields(_rest(error)))
        except (OSError, HTTPException, ValueError) as error:
            reason = getattr(error, "reason", error)
            raise ReportUndelivered(f"{self._who} does not answer: {reason}") from error


def _rest(error: urllib.error.HTTPError) -> bytes:
    try:
        return error.read(_MOST_ANSWER_BYTES)
    except (OSError, HTTPException):
        return b""


def _fields(body: bytes) -> Mapping[str, object]:
    try:
        fields = json.loads(body)
    except ValueError:
        return {}
    return fields if isinstance(fields, dict) else {}
