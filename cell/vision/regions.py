"""Dark regions that lit screen encloses: what may be blocks.

A region that touches the picture's edge, or joins bezel, table or arm that do, is
no hole in the lit screen and never becomes a region.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.difference import ScreenLight
from cell.vision.settings import RecognitionSettings


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A dark region in a window of the cropped picture, with a lit margin all around.

    Attributes:
        column: First column of the window in the cropped picture.
        row: First row of the window in the cropped picture.
        mask: 255 on the region's pixels, 0 elsewhere, (rows, columns), uint8.
        levels: White minus black in the window, with other regions made lit and lit spots
            inside this one made dark: its threshold line is the outer outline alone.
        threshold: Levels above it are lit.
        area_px: Number of the region's pixels.
    """

    column: int
    row: int
    mask: NDArray[np.uint8]
    levels: NDArray[np.uint8]
    threshold: float
    area_px: int


def dark_regions(light: ScreenLight, settings: RecognitionSettings) -> Iterator[Region]:
    """Yield the regions that lit screen encloses on all sides, specks dropped.

    Dark pixels belong together when they share a side.
    """
    _, lit = cv2.threshold(light.levels, light.threshold, 255, cv2.THRESH_BINARY)
    contours, tree = cv2.findContours(lit, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    if tree is None:
        return
    screens: dict[int, bool] = {}
    for contour, (_, _, _, parent) in zip(contours, tree[0].tolist(), strict=True):
        # A hole's contour runs through the lit pixels around it, so it holds more than
        # the hole's own area.
        if parent < 0 or cv2.contourArea(contour) < settings.least_area_px:
            continue
        if parent not in screens:
            screens[parent] = cv2.contourArea(contours[parent]) >= settings.least_screen_px
        if screens[parent]:
            region = _region(light, lit, contour)
            if region.area_px >= settings.least_area_px:
                yield region


def _region(light: ScreenLight, lit: cv2.typing.MatLike, contour: cv2.typing.MatLike) -> Region:
    left, top, wide, tall = cv2.boundingRect(contour)
    window = np.s_[top : top + tall, left : left + wide]
    inside = np.zeros((tall, wide), np.uint8)
    cv2.drawContours(inside, [contour], 0, 255, cv2.FILLED, offset=(-left, -top))
    # The contour itself runs through lit pixels; what remains inside it is the region
    # and the lit spots within.
    cv2.drawContours(inside, [contour], 0, 0, 1, offset=(-left, -top))
    mask = cv2.subtract(inside, lit[window])
    spots = cv2.subtract(inside, mask)
    levels = cv2.subtract(cv2.max(light.levels[window], cv2.bitwise_not(inside)), spots)
    # Outside, levels must be those of the picture where they are lit: the outline's place
    # between two pixels depends on them.
    outside_lit = cv2.subtract(lit[window], inside)
    cv2.copyTo(light.levels[window], outside_lit, levels)
    return Region(
        column=left,
        row=top,
        mask=np.asarray(mask, np.uint8),
        levels=np.asarray(levels, np.uint8),
        threshold=light.threshold,
        area_px=cv2.countNonZero(mask),
    )
