"""Where on a sheet there is room left: a map of free square millimetres."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """A rectangle of the sheet, in plan millimetres.

    Attributes:
        x_mm: Its left edge.
        y_mm: Its upper edge.
        width_mm: Its width.
        height_mm: Its height.
    """

    x_mm: float
    y_mm: float
    width_mm: float
    height_mm: float


class Room:
    """The free room of a sheet; what is placed is taken."""

    def __init__(self, width_mm: int, height_mm: int) -> None:
        """Begin with an empty sheet."""
        self._taken = np.zeros((height_mm, width_mm), np.bool_)

    def take(self, area: Area) -> None:
        """Take an area, as far as it lies on the sheet."""
        left, top = max(math.floor(area.x_mm), 0), max(math.floor(area.y_mm), 0)
        right = max(math.ceil(area.x_mm + area.width_mm), 0)
        low = max(math.ceil(area.y_mm + area.height_mm), 0)
        self._taken[top:low, left:right] = True

    def find(self, width_mm: int, height_mm: int, near_mm: tuple[float, float]) -> Area | None:
        """Return the free area of a size nearest to a wanted upper left corner, if any.

        Args:
            width_mm: Its width.
            height_mm: Its height.
            near_mm: Where its upper left corner shall be, if it can.
        """
        y, x = self.corners(width_mm, height_mm)
        if x.size == 0:
            return None
        best = int(np.argmin((x - near_mm[0]) ** 2 + (y - near_mm[1]) ** 2))
        return Area(
            x_mm=float(x[best]), y_mm=float(y[best]), width_mm=width_mm, height_mm=height_mm
        )

    def corners(
        self, width_mm: int, height_mm: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return y and x of the upper left corners of every free area of a size."""
        tall, wide = self._taken.shape
        if height_mm > tall or width_mm > wide:
            return np.empty(0), np.empty(0)
        total = np.zeros((tall + 1, wide + 1), np.int64)
        total[1:, 1:] = self._taken.cumsum(axis=0).cumsum(axis=1)
        inside = (
            total[height_mm:, width_mm:]
            - total[:-height_mm, width_mm:]
            - total[height_mm:, :-width_mm]
            + total[:-height_mm, :-width_mm]
        )
        y, x = np.nonzero(inside == 0)
        return y.astype(np.float64), x.astype(np.float64)
