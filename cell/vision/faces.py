"""Faces that may be block tops: flat patches of a block's colour, grown to their edges.

A block's top is one flat colour; its sides are lit otherwise and part from it at the edge.
Flat patches whose colour the model knows are the seeds; each grows over all pixels of nearly
its own mean colour. The picture is looked at in half its size, where noise is halved too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.colour_model import ColourModel, label_index

Pixels = NDArray[np.uint8]

PITCH_PX = 2.0
"""Pixels of the picture to one pixel that is looked at here."""

_FLAT_WINDOW_PX = 5
_FLAT_LEVELS = 10.0
_GROW_LEVELS = 4.0
_GROW_SHARE = 0.06
_LEAST_SEED_SHARE = 0.12
_MOST_FACES = 16.0
_REFUSED = 4
_MOST_SEED_PX = 400


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A patch of one colour.

    Attributes:
        outline_px: Its outer outline in the picture, (n, 2), through its outermost pixels.
        area_px: Its pixels in the half-size picture.
        window: Rows and columns of its mask in the half-size picture.
        mask: 255 on it, (h, w), within the window.
        mean_rgb: Mean colour of its seed.
        touches_edge: Whether it reaches the edge of what is looked at.
    """

    outline_px: NDArray[np.float64]
    area_px: int
    window: tuple[slice, slice]
    mask: Pixels
    mean_rgb: tuple[float, float, float]
    touches_edge: bool


def halved(picture: Pixels) -> Pixels:
    """Return a picture in half its size, each pixel the mean of four."""
    height, width = picture.shape[:2]
    size = (width // 2, height // 2)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def faces(small: Pixels, looked_at: Pixels, model: ColourModel, least_px: float) -> Iterator[Face]:
    """Yield the flat patches of block colours.

    Args:
        small: The half-size picture, R G B.
        looked_at: Above 0 where blocks are looked for, the same size.
        model: The blocks' colours.
        least_px: Area of the smallest block's face in the half-size picture.
    """
    labels = model.label_table[label_index(small)]
    even = cv2.bitwise_and(_even(small), looked_at)
    seeds = cv2.min(labels, even)
    count, parts, stats, _ = cv2.connectedComponentsWithStats(seeds, connectivity=4)
    field = small.copy()
    height, width = small.shape[:2]
    taken = np.zeros((height + 2, width + 2), np.uint8)
    taken[1:-1, 1:-1] = np.where(looked_at > 0, 0, 1)
    order = np.argsort(-stats[1:count, cv2.CC_STAT_AREA]) + 1
    for index in order.tolist():
        if stats[index, cv2.CC_STAT_AREA] < _LEAST_SEED_SHARE * least_px:
            break
        left, top, wide, tall = stats[index, :4].tolist()
        window = np.s_[top : top + tall, left : left + wide]
        yield from _grown(field, taken, parts[window] == index, (left, top), least_px)


def _grown(
    field: Pixels,
    taken: Pixels,
    patch: NDArray[np.bool_],
    corner: tuple[int, int],
    least_px: float,
) -> Iterator[Face]:
    """Yield the face that a patch is the seed of, if it is not taken and of a block's size."""
    left, top = corner
    rows, columns = np.nonzero(patch)
    centre = len(rows) // 2
    if taken[top + rows[centre] + 1, left + columns[centre] + 1]:
        return
    pixels = field[top + rows, left + columns]
    middle = pixels[:: max(1, len(pixels) // _MOST_SEED_PX)].mean(axis=0)
    nearest = int(np.argmin(np.abs(pixels.astype(np.float64) - middle).sum(axis=1)))
    seed = (left + int(columns[nearest]), top + int(rows[nearest]))
    if taken[seed[1] + 1, seed[0] + 1]:
        return
    slack = (_GROW_LEVELS + _GROW_SHARE * middle).tolist()
    # The flood's range lies about the seed pixel's value: the mean has less noise.
    field[seed[1], seed[0]] = np.rint(middle)
    flags = 4 | (2 << 8) | cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY
    area, _, _, (x, y, wide, tall) = cv2.floodFill(field, taken, seed, 0, slack, slack, flags)
    part = taken[y + 1 : y + 1 + tall, x + 1 : x + 1 + wide]
    is_own = part == 2
    if not 0.6 * least_px <= area <= _MOST_FACES * least_px:
        part[is_own] = _REFUSED
        return
    mask = np.zeros((tall + 2, wide + 2), np.uint8)
    mask[1:-1, 1:-1][is_own] = 255
    edge = taken[y : y + tall + 2, x : x + wide + 2] == 1
    reach = np.asarray(cv2.dilate(mask, np.ones((3, 3), np.uint8)))
    part[is_own] = 3
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(contours, key=len).reshape(-1, 2).astype(np.float64)
    offset = np.array([x - 1, y - 1], np.float64)
    red, green, blue = middle.tolist()
    yield Face(
        outline_px=(outline + offset + 0.5) * PITCH_PX - 0.5,
        area_px=int(area),
        window=(slice(y, y + tall), slice(x, x + wide)),
        mask=mask[1:-1, 1:-1],
        mean_rgb=(red, green, blue),
        touches_edge=bool((edge & (reach > 0)).sum() > 3),
    )


def _even(small: Pixels) -> Pixels:
    """Return 255 where levels differ little within a small window."""
    kernel = np.ones((_FLAT_WINDOW_PX, _FLAT_WINDOW_PX), np.uint8)
    spread = cv2.subtract(cv2.dilate(small, kernel), cv2.erode(small, kernel))
    red, green, blue = cv2.split(spread)
    most = cv2.max(cv2.max(red, green), blue)
    return np.asarray(cv2.threshold(most, _FLAT_LEVELS, 255, cv2.THRESH_BINARY_INV)[1], np.uint8)
