"""The picture on the television kept in service: sent once more when it was painted late."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cell.devices.display import Screen
from cell.errors import DeviceTimeout
from cell.reporting import FaultReporter


class ScreenKeeper:
    """Shows pictures, and sends one again that was not painted in time.

    Whatever else is wrong with a page (none is connected, it is hidden, it has a wrong size)
    only a person can mend.

    Args:
        screen: The screen.
        reporter: Told when a picture had to be sent again.
    """

    def __init__(self, screen: Screen, reporter: FaultReporter) -> None:
        self._screen = screen
        self._reporter = reporter

    def show(self, picture: str) -> None:
        """Show a picture; it is on when this returns.

        Raises:
            DeviceError: There is no such picture, or it cannot be shown.
        """
        self._twice(lambda: self._screen.show(picture))

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture of the panel's size; it is on when this returns.

        Raises:
            DeviceError: It has not the panel's size, or cannot be shown.
        """
        self._twice(lambda: self._screen.show_pixels(pixels, name))

    def _twice(self, show: Callable[[], None]) -> None:
        try:
            show()
            return
        except DeviceTimeout as error:
            late = error
        show()
        self._reporter.recovered("screen", f"shown again after: {late.problem}")

    def shown(self) -> str:
        """Return the name of the picture that was shown last."""
        return self._screen.shown()
