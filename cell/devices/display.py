"""What callers need of the television under the playground and of its picture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Display(Protocol):
    """The television as a switchable device; its picture comes over `Screen`."""

    def open(self) -> str:
        """Connect and check the link; return the identity."""

    def close(self) -> None:
        """Disconnect, leaving the set as it is."""

    def switch_on(self) -> None:
        """Switch the set on and return when it takes commands."""

    def switch_off(self) -> None:
        """Put the set into standby."""

    def is_on(self) -> bool:
        """Return whether the set is on."""

    def select_input(self, number: int) -> None:
        """Select an input of the profile's table."""

    def selected_input(self) -> int:
        """Return the number of the input that is shown.

        Raises:
            DeviceError: What is shown has no number, such as a tuner.
        """

    def require_input(self, number: int) -> None:
        """Return if the profile's table has an input; nothing is sent.

        Raises:
            OutOfRange: It has none of that number.
        """

    def set_volume(self, volume: int) -> None:
        """Set the volume, 0 to 60."""

    def require_volume(self, volume: int) -> None:
        """Return if there is such a volume; nothing is sent.

        Raises:
            OutOfRange: It is none of 0 to 60.
        """


class Screen(Protocol):
    """Puts a picture on the display, full screen, 1920 x 1080."""

    def show(self, picture: str) -> None:
        """Show a picture by name; it is on when this returns.

        Raises:
            DeviceError: There is no such picture, or it cannot be shown.
        """

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture, pixel by pixel; it is on when this returns.

        Args:
            pixels: Shape (1080, 1920, 3), uint8, R G B: the panel's size.
            name: What it is called in messages.

        Raises:
            DeviceError: It has not the panel's size, or cannot be shown.
        """

    def shown(self) -> str:
        """Return the name of the picture that was shown last."""

    def bookmark(self) -> Callable[[], None]:
        """Return what shows the present picture again, whatever it is; that may fail like `show`.

        Where none was shown yet it shows black.
        """
