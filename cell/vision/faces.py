"""Faces that may be block tops: flat patches of a block's colour, grown to their edges.

A block's top is one flat colour; its sides are lit otherwise and part from it at the edge.
Flat patches whose colour the model knows are the seeds, sought in a quarter of the picture's
size, where there is least noise; each grows over all pixels of nearly its own mean colour in
half the size, where its outline is exact enough to tell the kinds apart.
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
"""Pixels of the picture to one pixel of the half-size picture."""

_FLAT_WINDOW = np.ones((3, 3), np.uint8)
_FLAT_LEVELS = 10.0
_GROW_LEVELS = 4.0
_GROW_SHARE = 0.06
_LEAST_SEED_SHARE = 0.12
_LEAST_FACE_SHARE = 0.6
_MOST_FACES = 16.0
_MOST_PARTS = 6
_RING_PX = (3, 5)
_BEYOND_PX = 3
_STEP_SLACKS = 2.0
_UNSEEN, _GROWN, _TAKEN = 1, 2, 3


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A patch of one colour.

    Attributes:
        outline_px: Its outer outline in the picture, (n, 2), through its outermost pixels.
        area_px: Its pixels in the half-size picture.
        mean_rgb: Mean colour of its seed.
    """

    outline_px: NDArray[np.float64]
    area_px: int
    mean_rgb: tuple[float, float, float]

    def touches_edge(self, looked_at: Pixels) -> bool:
        """Return whether it reaches the edge of what is looked at.

        Args:
            looked_at: Above 0 where blocks are looked for, in the half-size picture.
        """
        height, width = looked_at.shape
        column, row = np.rint((self.outline_px + 0.5) / PITCH_PX - 0.5).astype(np.intp).T
        at_rim = (column < 1) | (row < 1) | (column > width - 2) | (row > height - 2)
        column, row = np.clip(column, 1, width - 2), np.clip(row, 1, height - 2)
        for right, down in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            at_rim |= looked_at[row + down, column + right] == 0
        return int(at_rim.sum()) > 3

    def stepped_share(self, small: Pixels, looked_at: Pixels) -> float:
        """Return the share of its outline beyond which the colour is clearly another.

        A block ends in a step; a patch of a picture's water or leaves fades away.

        Args:
            small: The half-size picture it was grown in.
            looked_at: Above 0 where blocks are looked for; nothing is known beyond.
        """
        places = np.rint((self.outline_px + 0.5) / PITCH_PX - 0.5).astype(np.int32)
        height, width = small.shape[:2]
        low = np.maximum(places.min(axis=0) - _BEYOND_PX, 0)
        high = np.minimum(places.max(axis=0) + _BEYOND_PX + 1, (width, height))
        part = np.s_[low[1] : high[1], low[0] : high[0]]
        window = small[part]
        mask = np.zeros(window.shape[:2], np.uint8)
        cv2.fillPoly(mask, [places - low], 1)
        inner, outer = (cv2.dilate(mask, np.ones((k, k), np.uint8)) for k in _RING_PX)
        ring = window[(outer > inner) & (looked_at[part] > 0)].astype(np.float64)
        slack = _GROW_LEVELS + _GROW_SHARE * np.array(self.mean_rgb)
        off = (np.abs(ring - self.mean_rgb) / slack).max(axis=1)
        return float((off > _STEP_SLACKS).mean()) if len(off) else 0.0


def halved(picture: Pixels) -> Pixels:
    """Return a picture in half its size, each pixel the mean of four."""
    height, width = picture.shape[:2]
    size = (width // 2, height // 2)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def faces(
    small: Pixels, quarter: Pixels, looked_at: Pixels, model: ColourModel, least_px: float
) -> Iterator[Face]:
    """Yield the flat patches of block colours.

    Args:
        small: The half-size picture, R G B.
        quarter: The quarter-size picture.
        looked_at: Above 0 where blocks are looked for, of the half size.
        model: The blocks' colours.
        least_px: Area of the smallest block's face in the half-size picture.
    """
    even = _even(quarter)
    even &= looked_at[::2, ::2]
    seeds = np.where(even > 0, model.label_table[label_index(quarter)], np.uint8(0))
    count, parts, stats, _ = cv2.connectedComponentsWithStats(seeds, connectivity=4)
    taken = np.asarray(
        cv2.copyMakeBorder(looked_at, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=[255.0]), np.uint8
    )
    cv2.threshold(taken, 0, _UNSEEN, cv2.THRESH_BINARY_INV, dst=taken)
    growing = _Growing(small.copy(), taken, least_px)
    areas = stats[1:count, cv2.CC_STAT_AREA]
    least_seed = _LEAST_SEED_SHARE * least_px / 4.0
    order = np.argsort(-areas)[: np.count_nonzero(areas >= least_seed)]
    for index, (left, top, wide, tall, _) in zip(
        (order + 1).tolist(), stats[order + 1].tolist(), strict=True
    ):
        window = np.s_[top : top + tall, left : left + wide]
        patch = np.asarray(cv2.inRange(parts[window], index, index), np.uint8)
        mean = cv2.mean(quarter[window], patch)[:3]
        corners = np.s_[
            2 * top + 1 : 2 * (top + tall) + 1 : 2, 2 * left + 1 : 2 * (left + wide) + 1 : 2
        ]
        # A seam may hold up the growth: what it leaves of a patch grows by itself.
        for _ in range(_MOST_PARTS):
            face = growing.grown(_inside(patch, left, top), (mean[0], mean[1], mean[2]))
            if face is not None:
                yield face
            patch[taken[corners] > 0] = 0
            if cv2.countNonZero(patch) < least_seed:
                break


def _inside(patch: Pixels, left: int, top: int) -> tuple[int, int]:
    """Return column and row in the half-size picture of a pixel in the middle of a patch."""
    filled = np.flatnonzero(patch.any(axis=1))
    row = int(filled[len(filled) // 2])
    columns = np.flatnonzero(patch[row])
    return 2 * (left + int(columns[len(columns) // 2])), 2 * (top + row)


class _Growing:
    """The half-size picture while patches grow in it.

    Args:
        field: A copy of the picture, which is changed.
        taken: `_UNSEEN` where nothing is looked for, 0 elsewhere; a pixel larger at each side.
        least_px: Area of the smallest block's face.
    """

    def __init__(self, field: Pixels, taken: Pixels, least_px: float) -> None:
        self._field = field
        self._taken = taken
        self._least_px = least_px

    def grown(self, seed: tuple[int, int], mean_rgb: tuple[float, float, float]) -> Face | None:
        """Return the patch around a seed, None if it is taken or of no block's size."""
        column, row = seed
        if self._taken[row + 1, column + 1]:
            return None
        slack = [_GROW_LEVELS + _GROW_SHARE * level for level in mean_rgb]
        # The flood's range lies about the seed pixel's value: the mean has less noise.
        self._field[row, column] = [round(level) for level in mean_rgb]
        flags = 4 | (_GROWN << 8) | cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY
        area, _, _, (x, y, wide, tall) = cv2.floodFill(
            self._field, self._taken, seed, 0, slack, slack, flags
        )
        part = self._taken[y + 1 : y + 1 + tall, x + 1 : x + 1 + wide]
        mask = cv2.inRange(part, _GROWN, _GROWN)
        part[mask > 0] = _TAKEN
        if not _LEAST_FACE_SHARE * self._least_px <= area <= _MOST_FACES * self._least_px:
            return None
        contours, _ = cv2.findContours(
            mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=(x, y)
        )
        outline = np.asarray(max(contours, key=len), np.float64).reshape(-1, 2)
        return Face(
            outline_px=outline * PITCH_PX + (0.5 * PITCH_PX - 0.5),
            area_px=int(area),
            mean_rgb=mean_rgb,
        )


def _even(quarter: Pixels) -> Pixels:
    """Return 255 where levels differ little within a small window."""
    spread = cv2.subtract(cv2.dilate(quarter, _FLAT_WINDOW), cv2.erode(quarter, _FLAT_WINDOW))
    return np.asarray(cv2.inRange(spread, (0.0, 0.0, 0.0), (_FLAT_LEVELS,) * 3), np.uint8)
