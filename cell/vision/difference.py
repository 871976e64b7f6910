"""What the screen lights: the picture on a white screen minus the one on a black screen.

Whatever the lamps light is the same in both pictures and vanishes; the lit screen
stays, and things that lie on it stay dark.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError
from cell.vision.settings import PICTURE_HEIGHT_PX, PICTURE_WIDTH_PX, RecognitionSettings

_SCREEN_RANK = 0.2
"""The brightest fifth of the crop is screen even when blocks and arm hide much of it."""

_DARK_LEVEL = 25.0
_DARK_RANK = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class ScreenLight:
    """How much of the screen's light each pixel of the cropped picture gets.

    Attributes:
        levels: Largest difference of the three channels, (rows, columns), uint8.
        threshold: Pixels above it are lit by the screen; a whole number and a half, so
            that no level lies on it.
    """

    levels: NDArray[np.uint8]
    threshold: float


def screen_light(
    white: NDArray[np.uint8], black: NDArray[np.uint8], settings: RecognitionSettings
) -> ScreenLight:
    """Subtract the picture on a black screen from the one on a white screen.

    Args:
        white: R G B, shape (960, 1280, 3), uint8.
        black: The same view with the screen black.
        settings: Crop rows, threshold and the least level of a lit screen.

    Raises:
        VisionError: A picture has the wrong shape or type, or the screen does not light up.
    """
    for name, picture in (("white", white), ("black", black)):
        if picture.shape != (PICTURE_HEIGHT_PX, PICTURE_WIDTH_PX, 3) or picture.dtype != np.uint8:
            raise VisionError(
                f"the picture on a {name} screen is {picture.dtype} of shape {picture.shape}; "
                f"take it as uint8 R G B of {PICTURE_WIDTH_PX} x {PICTURE_HEIGHT_PX} pixels"
            )
    rows = slice(settings.first_row, settings.end_row)
    red, green, blue = cv2.split(cv2.subtract(white[rows], black[rows]))
    levels = cv2.max(cv2.max(red, green, dst=red), blue, dst=red)
    screen_level = _level_at_rank(levels, _SCREEN_RANK)
    if screen_level < settings.least_screen_level:
        raise VisionError(_unlit_screen(screen_level, black, settings))
    threshold = int(settings.threshold_share * screen_level) + 0.5
    return ScreenLight(np.asarray(levels, np.uint8), threshold)


def _level_at_rank(levels: cv2.typing.MatLike, share: float) -> float:
    """Return the level that this share of the pixels reaches or exceeds."""
    counts = cv2.calcHist([levels], [0], None, [256], [0, 256]).ravel()
    from_top = np.cumsum(counts[::-1])
    return 255.0 - float(np.searchsorted(from_top, share * from_top[-1]))


def _unlit_screen(
    screen_level: float, black: NDArray[np.uint8], settings: RecognitionSettings
) -> str:
    brightest = _level_at_rank(np.ascontiguousarray(black.max(axis=2)), _DARK_RANK)
    lights = (
        f" The black picture is dark throughout ({brightest:.0f} of 255): the lights seem to be "
        "off too; switch them on."
        if brightest < _DARK_LEVEL
        else ""
    )
    return (
        f"the screen is off or shows the same in both pictures: white minus black is "
        f"{screen_level:.0f} grey levels, a lit screen gives at least "
        f"{settings.least_screen_level:.0f}; switch the screen on, show white for the first "
        f"picture and black for the second.{lights}"
    )
