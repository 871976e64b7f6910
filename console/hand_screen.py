"""The television's picture for a single command: the page is served as long as it runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cell.drivers.kiosk.screen import KioskScreen
from cell.drivers.kiosk.settings import KioskSettings
from cell.profile import DisplayProfile
from console.output import say


class HandScreen:
    """A `cell.devices.display.Screen` that serves the television's page from its first picture.

    The page stays connected from picture to picture, until the command ends or closes it; a
    page that the browser has open keeps its picture when nobody serves it any more.

    Args:
        profile: The television.
        folder: Where the last picture is kept.
    """

    def __init__(self, profile: DisplayProfile, folder: Path) -> None:
        self._settings = KioskSettings.from_profile(profile, state_folder=folder)
        self._screen: KioskScreen | None = None
        self._shown = ""

    def show(self, picture: str) -> None:
        """Show a picture by name, and wait until the page has painted it."""
        self._serving().show(picture)
        self._shown = picture

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture of the panel's size, and wait until the page has painted it."""
        self._serving().show_pixels(pixels, name)
        self._shown = name

    def shown(self) -> str:
        """Return the name of the picture that this command showed; empty for none."""
        return self._shown

    def bookmark(self) -> Callable[[], None]:
        """Return what shows the present picture again, also one from before this command."""
        return self._serving().bookmark()

    def close(self) -> None:
        """Serve the page no more; closing twice is harmless."""
        screen, self._screen = self._screen, None
        if screen is not None:
            screen.stop()

    def __enter__(self) -> Self:
        """Return itself; the page is served when there is something to show."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Serve the page no more."""
        self.close()

    def _serving(self) -> KioskScreen:
        if self._screen is None:
            screen = KioskScreen(self._settings)
            screen.start()
            self._screen = screen
            say(f"the television's browser must have {screen.url} open ...", "dim")
        return self._screen
