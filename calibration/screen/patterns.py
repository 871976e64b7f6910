"""What the screen shows to be measured: grey fields, a ChArUco board, phase and Gray code.

Along each axis a sine of `PERIOD_PX` pixels is shown shifted by sixths of its period. The
phase says where in a period a camera pixel looks, to a few hundredths of a screen pixel, and
bends of the screen's gamma up to the fourth harmonic cancel. Which period it is, a Gray code
of half periods tells; as the phase says which half it must be, a stripe's blurred edge does
no harm (Zhang, Sun, Lin, "Phase unwrapping with complementary Gray code", Optics Letters
2018, is the same thought).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.drivers.kiosk.patterns import Axis, gray_code_bits, gray_code_line

Pixels: TypeAlias = NDArray[np.uint8]

AXES: tuple[Axis, Axis] = ("columns", "rows")
PERIOD_PX = 48
"""Period of the sine in screen pixels: 22 mm on the 40 inch panel, so that a camera that
sees the far side at a flat angle still has five pixels for each."""

STEPS = 6
"""Pictures of a sine; harmonics 2 to 4 of its shape cancel."""

RAMP = (0, 64, 112, 160, 208, 255)
"""Values of the grey fields that the screen's response is read from."""

SQUARE_PX = 120
_MARKER_SHARE = 0.7
_DICTIONARY = cv2.aruco.DICT_5X5_250


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """The screen's panel and the grey values that patterns use on it.

    Attributes:
        width_px: Its columns.
        height_px: Its rows.
        bright: Value of the brightest grey, such that no camera clips.
        gamma: Light goes with (value / 255) to this power.
    """

    width_px: int
    height_px: int
    bright: int = 160
    gamma: float = 2.2

    def size_px(self, axis: Axis) -> int:
        """Return how many columns or rows there are."""
        return self.width_px if axis == "columns" else self.height_px

    def bits(self, axis: Axis) -> int:
        """Return how many pictures the Gray code of half periods needs."""
        return gray_code_bits(self.size_px(axis), PERIOD_PX // 2)

    def field(self, value: int) -> Pixels:
        """Return one grey all over."""
        return np.full((self.height_px, self.width_px, 3), value, np.uint8)

    def sine(self, axis: Axis, step: int) -> Pixels:
        """Return the sine of an axis, shifted by `step` of `STEPS` parts of its period."""
        places = np.arange(self.size_px(axis))
        turn = 2.0 * np.pi * (places / PERIOD_PX - step / STEPS)
        return self._along(axis, 0.5 + 0.5 * np.cos(turn))

    def code(self, axis: Axis, bit: int) -> Pixels:
        """Return a bit of the Gray code of each half period; a set bit is bright."""
        is_set = gray_code_line(self.size_px(axis), bit, PERIOD_PX // 2)
        return self._along(axis, is_set.astype(np.float64))

    def board(self) -> Pixels:
        """Return the ChArUco board, from black to `bright`."""
        drawn = charuco_board(self.width_px, self.height_px).generateImage(
            (self.width_px, self.height_px), marginSize=0, borderBits=1
        )
        grey = np.where(np.asarray(drawn) > 127, self.bright, 0).astype(np.uint8)
        return _three(grey)

    def _along(self, axis: Axis, light: NDArray[np.float64]) -> Pixels:
        """Return a picture whose light, a share of the brightest, changes along one axis."""
        values = np.rint(self.bright * light ** (1.0 / self.gamma)).astype(np.uint8)
        line = values[None, :] if axis == "columns" else values[:, None]
        return _three(np.broadcast_to(line, (self.height_px, self.width_px)))


@lru_cache(maxsize=4)
def charuco_board(width_px: int, height_px: int) -> cv2.aruco.CharucoBoard:
    """Return the board that fills a panel; its unit is a screen pixel."""
    squares = (width_px // SQUARE_PX, height_px // SQUARE_PX)
    dictionary = cv2.aruco.getPredefinedDictionary(_DICTIONARY)
    return cv2.aruco.CharucoBoard(squares, SQUARE_PX, SQUARE_PX * _MARKER_SHARE, dictionary)


def _three(grey: NDArray[np.uint8]) -> Pixels:
    return np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2))
