"""The pages that are connected, and what each has said so far."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

from cell.drivers.kiosk.messages import Failed, Loading, PageMessage, PageView, Painted, Viewed


@dataclass(frozen=True, slots=True, kw_only=True)
class PageState:
    """One connected page.

    Attributes:
        page: Counts the connections since the server was made.
        view: Its window and screen as it said last; None until it has spoken.
        loading: Number of the picture it began to fetch last.
        painted: The picture it confirmed last.
        painted_s: When that confirmation arrived, on the cell's clock.
        failed: The picture it could not show, if that was the last one it spoke of.
    """

    page: int
    view: PageView | None = None
    loading: int | None = None
    painted: Painted | None = None
    painted_s: float | None = None
    failed: Failed | None = None

    def after(self, message: PageMessage, now_s: float) -> PageState:
        """Return the page as it is after it said something."""
        match message:
            case Viewed(view=view):
                return replace(self, view=view)
            case Loading(number=number):
                return replace(self, loading=number, failed=None)
            case Painted(view=view):
                return replace(self, view=view, painted=message, painted_s=now_s, failed=None)
            case Failed():
                return replace(self, failed=message)


class PageBoard:
    """What all connected pages said; written by the server's thread, read by any."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._pages: dict[int, PageState] = {}
        self._joined = 0
        self._version = 0

    def join(self) -> int:
        """Take note of a new page and return its number."""
        with self._changed:
            self._joined += 1
            self._pages[self._joined] = PageState(page=self._joined)
            self._tell()
            return self._joined

    def leave(self, page: int) -> None:
        """Forget a page that has gone."""
        with self._changed:
            self._pages.pop(page, None)
            self._tell()

    def hear(self, page: int, message: PageMessage, now_s: float) -> None:
        """Take note of what a page said."""
        with self._changed:
            state = self._pages.get(page)
            if state is not None:
                self._pages[page] = state.after(message, now_s)
                self._tell()

    def read(self) -> tuple[int, tuple[PageState, ...]]:
        """Return a number that grows with every change, and the pages."""
        with self._changed:
            return self._version, tuple(self._pages.values())

    def wait_for_change(self, version: int, timeout_s: float) -> bool:
        """Return whether something has changed since `version`, at once or within `timeout_s`."""
        with self._changed:
            return self._changed.wait_for(lambda: self._version != version, timeout_s)

    def _tell(self) -> None:
        self._version += 1
        self._changed.notify_all()
