"""A page without a browser, and a clock for those who will not wait."""

from __future__ import annotations

import asyncio
import hashlib
import json
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from tornado.httpclient import AsyncHTTPClient
from tornado.websocket import WebSocketClientConnection, websocket_connect

from cell.clock import SystemClock
from cell.drivers.kiosk import KioskScreen

PATIENCE_S = 20.0


class RushedClock(SystemClock):
    """Real time until `rush` is called; from then on every deadline has passed when asked."""

    def __init__(self) -> None:
        super().__init__()
        self._ahead_s: float | None = None

    def rush(self) -> None:
        self._ahead_s = 0.0

    def now_s(self) -> float:
        if self._ahead_s is None:
            return super().now_s()
        self._ahead_s += 1e6
        return self._ahead_s


def view(
    width_px: int = 1920,
    height_px: int = 1080,
    *,
    screen_px: tuple[int, int] = (1920, 1080),
    ratio: float = 1.0,
    is_visible: bool = True,
) -> dict[str, Any]:
    """Return what a page says of its window."""
    return {
        "window_px": [width_px, height_px],
        "pixel_ratio": ratio,
        "screen_px": list(screen_px),
        "is_visible": is_visible,
        "is_fullscreen": True,
        "browser": "fake",
    }


Reaction = Callable[[dict[str, Any], bytes], list[dict[str, Any]]]
"""What a page says to a `show`, given the message and the file it fetched."""


def silence(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
    return []


def loading_only(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
    return [{"kind": "loading", "number": show["number"]}]


def confirming(seen: dict[str, Any]) -> Reaction:
    """Return what a page with that view says when all is well."""

    def confirm(show: dict[str, Any], png: bytes) -> list[dict[str, Any]]:
        return [
            {"kind": "loading", "number": show["number"]},
            {
                "kind": "painted",
                "number": show["number"],
                "sha256": hashlib.sha256(png).hexdigest(),
                "picture_px": [show["width_px"], show["height_px"]],
                "painted_unix_ms": 1.0,
                "took_ms": 20.0,
                "view": seen,
            },
        ]

    return confirm


class DistantPage:
    """Connects to a server, tells its view, fetches what it is told to show, and reacts.

    Args:
        url: Where the page is served.
        reaction: What it says to a `show`.
        seen: Its view.
    """

    def __init__(self, url: str, reaction: Reaction, seen: dict[str, Any]) -> None:
        self._base = url.rstrip("/")
        self._reaction = reaction
        self._view = seen
        self._loop = asyncio.new_event_loop()
        self._socket: WebSocketClientConnection | None = None
        self.shows: list[dict[str, Any]] = []
        self.was_closed_by_server = threading.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=[self._run()])

    def __enter__(self) -> Self:
        self._thread.start()
        assert self._ready.wait(PATIENCE_S)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._close)
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()
        self._loop.close()

    def say(self, message: dict[str, Any] | str) -> None:
        """Send a message now."""
        text = message if isinstance(message, str) else json.dumps(message)
        self._loop.call_soon_threadsafe(self._send, text)

    def _send(self, text: str) -> None:
        assert self._socket is not None
        self._socket.write_message(text)

    def _close(self) -> None:
        if self._socket is not None:
            self._socket.close()

    async def _run(self) -> None:
        base = self._base
        self._socket = await websocket_connect(f"{base.replace('http', 'ws')}/socket")
        self._send(json.dumps({"kind": "view", "view": self._view}))
        self._ready.set()
        client = AsyncHTTPClient()
        while (text := await self._socket.read_message()) is not None:
            show = json.loads(text)
            self.shows.append(show)
            png = (await client.fetch(f"{base}{show['path']}")).body
            for answer in self._reaction(show, png):
                self._send(json.dumps(answer))
        self._socket.close()
        self.was_closed_by_server.set()
        client.close()


class FakePage(DistantPage):
    """A page of a screen in this process, there as soon as the screen knows it."""

    def __init__(self, screen: KioskScreen, reaction: Reaction, seen: dict[str, Any]) -> None:
        super().__init__(screen.url, reaction, seen)
        self._screen = screen

    def __enter__(self) -> Self:
        # By number, not by count: a page that has just left may still be among them.
        known = {page.page for page in self._screen.pages()}
        super().__enter__()
        await_pages(
            self._screen,
            lambda pages: any(p.page not in known and p.view is not None for p in pages),
        )
        return self


def await_pages(screen: KioskScreen, condition: Callable[[Any], bool]) -> None:
    """Return when the screen's pages are as wished."""
    seen, pages = screen.await_change(0, PATIENCE_S)
    while not condition(pages):
        before = seen
        seen, pages = screen.await_change(before, PATIENCE_S)
        assert seen != before, pages
