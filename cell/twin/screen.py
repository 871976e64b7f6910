"""The picture that the computer sends to the twin's television, and the page that has it."""

from __future__ import annotations

import enum
import hashlib
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cell.errors import DeviceError, DeviceTimeout
from cell.pictures import HEIGHT_PX, PICTURE_NAMES, WIDTH_PX
from cell.twin.world import World


class PageFault(enum.Enum):
    """What may be wrong with the page that shows the picture; the words are its report."""

    CLOSED = "no page is connected"
    HIDDEN = "the page is hidden: another tab or window is in front, or it is minimised"
    WRONG_SIZE = "the page has 1536 x 864 pixels, 1920 x 1080 are needed"
    LATE = "the page has begun to load the picture and has not painted it"


_HINTS = {
    PageFault.CLOSED: "open the page on the television's computer, in full screen",
    PageFault.HIDDEN: "bring the page to the front on the television's computer",
    PageFault.WRONG_SIZE: "click into the page (or press F11) to make it full screen",
    PageFault.LATE: "see whether the television's computer is busy or its screen asleep",
}


class TwinScreen:
    """A `cell.devices.display.Screen` whose panel is the twin's.

    Its page is always there, in front, and of the right size, unless a fault is put on it.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._fault: PageFault | None = None
        self._pictures_left = 0

    def show(self, picture: str) -> None:
        """Show one of the pictures of `cell.pictures`.

        Raises:
            DeviceError: There is no such picture, or the page has a fault.
            DeviceTimeout: The page does not paint it in time.
        """
        if picture not in PICTURE_NAMES:
            known = ", ".join(PICTURE_NAMES)
            raise DeviceError("screen", f"knows no picture {picture!r}", hint=f"use {known}")
        self._require_page()
        self._world.set_picture(picture)

    def show_pixels(self, pixels: NDArray[np.uint8], name: str = "pixels") -> None:
        """Show any picture of 1920 x 1080 pixels; see `cell.devices.display.Screen`."""
        if pixels.shape != (HEIGHT_PX, WIDTH_PX, 3) or pixels.dtype != np.uint8:
            raise DeviceError(
                "screen",
                f"cannot show an array of {pixels.dtype} with shape {pixels.shape}",
                hint=f"give uint8 with shape ({HEIGHT_PX}, {WIDTH_PX}, 3)",
            )
        self._require_page()
        kept = np.ascontiguousarray(pixels)
        digest = hashlib.blake2b(kept.data, digest_size=8).hexdigest()
        self._world.set_picture(f"{name} {digest}", kept)

    def shown(self) -> str:
        """Return the name of the picture that was shown last."""
        return self._world.sent_picture

    def bookmark(self) -> Callable[[], None]:
        """Return what shows the present picture again."""
        name, pixels = self._world.sent_picture, self._world.sent_pixels

        def show_again() -> None:
            self._require_page()
            self._world.set_picture(name, pixels)

        return show_again

    # Hands at the television's computer

    def disturb(self, fault: PageFault, *, pictures: int | None = None) -> None:
        """Let the page fail.

        Args:
            fault: What is wrong with it.
            pictures: For how many pictures; until `mend` unless given.
        """
        self._fault = fault
        self._pictures_left = -1 if pictures is None else pictures

    def mend(self) -> None:
        """Put the page right."""
        self._fault = None

    def _require_page(self) -> None:
        fault = self._next_fault()
        if fault is not None:
            kind = DeviceTimeout if fault is PageFault.LATE else DeviceError
            raise kind("screen", fault.value, hint=_HINTS[fault])

    def _next_fault(self) -> PageFault | None:
        fault = self._fault
        if self._pictures_left > 0:
            self._pictures_left -= 1
            if self._pictures_left == 0:
                self._fault = None
        return fault
