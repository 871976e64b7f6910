"""The television's picture for a single command: the page is served while it is needed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cell.drivers.kiosk.screen import KioskScreen
from cell.drivers.kiosk.settings import KioskSettings
from cell.profile import DisplayProfile
from console.output import say


class HandScreen:
    """A `cell.devices.display.Screen` that serves the television's page only to show.

    The page that the browser has open keeps its picture when nobody serves it any more.

    Args:
        profile: The television.
        folder: Where the last picture is kept.
    """

    def __init__(self, profile: DisplayProfile, folder: Path) -> None:
        self._settings = KioskSettings.from_profile(profile, state_folder=folder)
        self._shown = ""

    def show(self, picture: str) -> None:
        """Show a picture by name, and wait until the page has painted it."""
        screen = KioskScreen(self._settings)
        with screen:
            say(f"the television's browser must have {screen.url} open ...", "dim")
            screen.show(picture)
        self._shown = picture

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture of the panel's size, and wait until the page has painted it."""
        with KioskScreen(self._settings) as screen:
            say(f"the television's browser must have {screen.url} open ...", "dim")
            screen.show_pixels(pixels, name)
        self._shown = name

    def shown(self) -> str:
        """Return the name of the picture that this command showed; empty for none."""
        return self._shown
