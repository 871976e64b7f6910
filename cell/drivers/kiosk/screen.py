"""The screen whose picture a browser shows, and which waits until it really does."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cell.clock import Clock, SystemClock
from cell.drivers.kiosk.judgement import Complaint, picture_complaint, view_complaint
from cell.drivers.kiosk.last_picture import KeptPicture, LastPicture
from cell.drivers.kiosk.messages import Painted, Show
from cell.drivers.kiosk.pages import PageBoard, PageState
from cell.drivers.kiosk.png import encode_png
from cell.drivers.kiosk.server import KioskServer
from cell.drivers.kiosk.settings import KioskSettings
from cell.drivers.kiosk.telling import PageTold, ScreenTold
from cell.errors import DeviceError, DeviceTimeout
from cell.pictures import HEIGHT_PX, PICTURE_NAMES, WIDTH_PX, picture

_SLICE_S = 0.05


class KioskScreen:
    """A `cell.devices.display.Screen` that a browser on the television's computer shows.

    Every page that is connected must confirm: the wanted content, decoded, at the panel's
    size, in a frame that the browser has finished, in a window that can be seen. A page
    that does not is named in the error.

    Calls may come from any thread; one picture is shown at a time.

    Args:
        settings: Address, size and deadline.
        clock: What deadlines are measured with; a browser paints in real time, so a
            simulated clock is of no use here.
    """

    def __init__(self, settings: KioskSettings, clock: Clock | None = None) -> None:
        self._settings = settings
        self._clock = SystemClock() if clock is None else clock
        self._board = PageBoard()
        self._server = KioskServer(
            settings.device,
            settings.host,
            settings.port,
            self._board,
            self._clock.now_s,
            lambda: self.told().model_dump_json(),
        )
        self._memory = None if settings.state_folder is None else LastPicture(settings.state_folder)
        self._turn = threading.RLock()
        self._number = 0
        self._show: Show | None = None
        self._kept: KeptPicture | None = None

    @property
    def url(self) -> str:
        """The page's address, to be opened on the television's computer."""
        return self._server.url

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the panel."""
        return self._settings.width_px, self._settings.height_px

    def start(self) -> None:
        """Serve the page; the picture that was shown last is shown again.

        Raises:
            DeviceError: The port cannot be had.
        """
        with self._turn:
            self._server.start()
            kept = self._memory.read() if self._memory and self._show is None else None
            if kept is not None:
                self._publish(kept)

    def stop(self) -> None:
        """End the server; pages keep their picture and connect again when it is back."""
        with self._turn:
            self._server.stop()

    def __enter__(self) -> Self:
        """Serve the page."""
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the server."""
        self.stop()

    def show(self, picture: str) -> None:
        """Show a picture of `cell.pictures`; return when every page has painted it.

        Raises:
            DeviceError: There is no such picture, no page, or a page that cannot show it.
            DeviceTimeout: A page did not paint it in time.
        """
        kept = self._named_picture(picture)
        with self._turn:
            self._await_painted(self._publish(kept))

    def send(self, picture: str) -> None:
        """Have pages show a picture of `cell.pictures`, now or when they come; do not wait.

        Raises:
            DeviceError: There is no such picture.
        """
        kept = self._named_picture(picture)
        with self._turn:
            self._publish(kept)

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture, pixel by pixel; return when every page has painted it.

        Args:
            pixels: Shape (height, width, 3) of the panel, uint8, R G B.
            name: What it is called in messages and by `shown`.

        Raises:
            DeviceError: It is no picture of the panel's size, or cannot be shown.
            DeviceTimeout: A page did not paint it in time.
        """
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
            raise DeviceError(
                self._settings.device,
                f"cannot show an array of {pixels.dtype} with shape {pixels.shape}",
                hint="give uint8 with shape (height, width, 3)",
            )
        self._require_size((pixels.shape[1], pixels.shape[0]), name)
        png = encode_png(pixels)
        with self._turn:
            kept = KeptPicture(name, hashlib.sha256(png).hexdigest(), png)
            self._await_painted(self._publish(kept))

    def shown(self) -> str:
        """Return the name of the picture that was sent last; empty if there was none."""
        return "" if self._show is None else self._show.name

    def bookmark(self) -> Callable[[], None]:
        """Return what shows the present picture again, and waits until it is painted."""
        with self._turn:
            kept = self._kept or self._named_picture("black")

        def show_again() -> None:
            with self._turn:
                self._await_painted(self._publish(kept))

        return show_again

    def painted(self) -> tuple[Painted, ...]:
        """Return what each page confirmed last: the evidence."""
        return tuple(page.painted for page in self.pages() if page.painted is not None)

    def pages(self) -> tuple[PageState, ...]:
        """Return the connected pages."""
        return self._board.read()[1]

    def check(self) -> None:
        """Return if every page still shows the picture that was sent last.

        Raises:
            DeviceError: There is no page, or one does not; the text says why.
        """
        _, pages = self._board.read()
        trouble = self._trouble(pages, self._show)
        if trouble is not None:
            raise DeviceError(self._settings.device, trouble.problem, hint=trouble.hint)

    def told(self) -> ScreenTold:
        """Return what is on the screen, as other programs are told it."""
        show = self._show
        pages = self.pages()
        return ScreenTold(
            size=self.size_px,
            shown="" if show is None else show.name,
            painted=show is not None and self._trouble(pages, show) is None,
            pages=tuple(self._page_told(page, show) for page in pages),
        )

    def await_change(self, seen: int, timeout_s: float) -> tuple[int, tuple[PageState, ...]]:
        """Return when pages came, went or said something that was not `seen`, or time is up.

        Returns:
            What to give as `seen` next time (0 at first), and the pages.
        """
        self._board.wait_for_change(seen, timeout_s)
        return self._board.read()

    def _named_picture(self, name: str) -> KeptPicture:
        if name not in PICTURE_NAMES:
            raise DeviceError(
                self._settings.device,
                f"knows no picture {name!r}",
                hint=f"use {', '.join(PICTURE_NAMES)}",
            )
        self._require_size((WIDTH_PX, HEIGHT_PX), name)
        sha256, png = _named_png(name)
        return KeptPicture(name, sha256, png)

    def _publish(self, kept: KeptPicture) -> Show:
        width_px, height_px = self.size_px
        self._number += 1
        show = Show(
            number=self._number,
            name=kept.name,
            sha256=kept.sha256,
            width_px=width_px,
            height_px=height_px,
        )
        self._show, self._kept = show, kept
        self._server.show(show, kept.png)
        if self._memory is not None:
            self._memory.keep(kept)
        return show

    def _await_painted(self, show: Show) -> None:
        timeout_s = self._settings.paint_timeout_s
        deadline_s = self._clock.now_s() + timeout_s
        waited_s = 0.0
        version, pages = self._board.read()
        while (trouble := self._trouble(pages, show)) is not None:
            # What was waited counts, too: a clock that stands still must not make this endless.
            remaining_s = min(deadline_s - self._clock.now_s(), timeout_s - waited_s)
            if remaining_s <= 0:
                kind = DeviceTimeout if trouble.is_late else DeviceError
                problem = f"{trouble.problem} ({timeout_s:g} s after {show.name!r} was sent)"
                raise kind(self._settings.device, problem, hint=trouble.hint)
            slice_s = min(_SLICE_S, remaining_s)
            if not self._board.wait_for_change(version, slice_s):
                waited_s += slice_s
            version, pages = self._board.read()

    def _trouble(self, pages: tuple[PageState, ...], show: Show | None) -> Complaint | None:
        if not pages:
            return Complaint(
                "no page is connected",
                f"open {self.url} on the television's computer, in full screen",
            )
        for page in pages:
            complaint = self._complaint(page, show)
            if complaint is not None:
                return _named(complaint, page, len(pages))
        return None

    def _complaint(self, page: PageState, show: Show | None) -> Complaint | None:
        width_px, height_px = self.size_px
        if show is not None:
            return picture_complaint(page, show, width_px, height_px)
        if page.view is None:
            return Complaint("is connected and says nothing", "reload the page (Ctrl+Shift+R)")
        return view_complaint(page.view, width_px, height_px)

    def _page_told(self, page: PageState, show: Show | None) -> PageTold:
        complaint, view = self._complaint(page, show), page.view
        return PageTold(
            page=page.page,
            covers_px=None if view is None else view.covers_px,
            is_visible=view is not None and view.is_visible,
            trouble="" if complaint is None else f"{complaint.problem}; {complaint.hint}",
        )

    def _require_size(self, size_px: tuple[int, int], name: str) -> None:
        if size_px != self.size_px:
            raise DeviceError(
                self._settings.device,
                "{!r} has {} x {} pixels, the panel {} x {}".format(name, *size_px, *self.size_px),
                hint="give a picture of the panel's size; pictures are not scaled",
            )


def _named(complaint: Complaint, page: PageState, count: int) -> Complaint:
    if count == 1:
        return replace(complaint, problem=f"the page {complaint.problem}")
    return replace(
        complaint,
        problem=f"page {page.page}, one of {count} connected, {complaint.problem}",
        hint=f"{complaint.hint}, or close it if it is not the television's",
    )


@lru_cache(maxsize=len(PICTURE_NAMES))
def _named_png(name: str) -> tuple[str, bytes]:
    png = encode_png(picture(name))
    return hashlib.sha256(png).hexdigest(), png
