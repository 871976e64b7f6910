"""What the page's server tells other programs of this computer, and how they ask it.

A program that only wants to know what is on the screen, such as the doctor, must not serve
the page itself: it would take the port from the program that does.
"""

from __future__ import annotations

import http.client
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cell.errors import DeviceError

STATE_PATH = "/state"
_MOST_BYTES = 1_000_000

_Size = tuple[Annotated[int, Field(ge=0)], Annotated[int, Field(ge=0)]]


class _Told(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class PageTold(_Told):
    """One connected page."""

    page: int
    """Counts the connections."""
    covers_px: _Size | None
    """Screen pixels that its window covers, None until it has spoken."""
    is_visible: bool
    trouble: str
    """Why it does not show what it should; empty when it does."""


class ScreenTold(_Told):
    """What is on the screen."""

    size: _Size
    """Width and height of the panel."""
    shown: str
    """Name of the picture that was sent last; empty for none."""
    painted: bool
    """Whether every page, and there is one at least, has confirmed it."""
    pages: tuple[PageTold, ...]


def ask_screen(port: int, *, host: str = "127.0.0.1", timeout_s: float = 2.0) -> ScreenTold | None:
    """Ask whichever program of this computer serves the page; None where nobody does.

    Raises:
        DeviceError: Something else has the port, or does not answer in time.
    """
    connection = http.client.HTTPConnection(host, port, timeout=timeout_s)
    try:
        connection.request("GET", STATE_PATH)
        answer = connection.getresponse()
        data = answer.read(_MOST_BYTES)
    except ConnectionRefusedError:
        return None
    except (OSError, http.client.HTTPException) as error:
        raise _stranger(host, port, str(error) or type(error).__name__) from error
    finally:
        connection.close()
    try:
        return ScreenTold.model_validate_json(data)
    except ValidationError as error:
        raise _stranger(host, port, f"it answers {answer.status} {data[:40]!r}") from error


def _stranger(host: str, port: int, what: str) -> DeviceError:
    return DeviceError(
        "screen",
        f"what listens on {host}:{port} does not serve the television's page: {what}",
        hint="end that program, or give the page another port (display.page_port)",
    )
