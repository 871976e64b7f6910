"""Measures of a region: outline length, circularity, centroid and turn.

The outline is the line of the threshold's level between pixels, drawn cell by cell with
marching squares (Lorensen and Cline 1987, in the plane): straight edges and circles get
their true length in every direction, where chains of pixel steps are up to 8 % long.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

# Corners of a cell of four pixels, as bits: 1 upper left, 2 upper right, 4 lower right,
# 8 lower left. Sides: 0 upper, 1 right, 2 lower, 3 left. For each pattern of dark
# corners, the sides that the line joins. Patterns 5 and 10 have two pieces of line; their
# dark corners are cut off one by one, because dark pixels belong together by sides only.
_JOINS: dict[int, tuple[int, int]] = {
    1: (3, 0), 2: (0, 1), 3: (3, 1), 4: (1, 2), 5: (3, 0), 6: (0, 2), 7: (3, 2),
    8: (2, 3), 9: (2, 0), 10: (0, 1), 11: (2, 1), 12: (1, 3), 13: (1, 0), 14: (0, 3),
}  # fmt: skip
_SECOND_JOINS: dict[int, tuple[int, int]] = {5: (1, 2), 10: (2, 3)}


def _table(joins: dict[int, tuple[int, int]]) -> NDArray[np.intp]:
    """Return the joined sides by pattern, (16, 2); (0, 0) has no length."""
    return np.array([joins.get(pattern, (0, 0)) for pattern in range(16)], np.intp)


_JOIN_TABLE = _table(_JOINS)
_SECOND_TABLE = _table(_SECOND_JOINS)


def outline_length_px(levels: NDArray[np.uint8], threshold: float) -> float:
    """Return the length of the line where levels pass the threshold.

    Args:
        levels: A window of (rows, columns) whose margin lies above the threshold.
        threshold: No level may be equal to it.
    """
    dark = (levels < threshold).view(np.uint8)
    pattern = dark[:-1, :-1] | dark[:-1, 1:] << 1 | dark[1:, 1:] << 2 | dark[1:, :-1] << 3
    cells = np.flatnonzero((pattern.ravel() - np.uint8(1)) < 14)
    if cells.size == 0:
        return 0.0
    kinds = pattern.ravel()[cells]
    columns = levels.shape[1]
    upper_left = cells + cells // (columns - 1)
    height = levels.ravel().astype(np.float64) - threshold
    a, b = height[upper_left], height[upper_left + 1]
    d, c = height[upper_left + columns], height[upper_left + columns + 1]
    x = np.stack([_crossing(a, b), np.ones_like(a), _crossing(d, c), np.zeros_like(a)])
    y = np.stack([np.zeros_like(a), _crossing(b, c), np.ones_like(a), _crossing(a, d)])
    length = _joined(x, y, _JOIN_TABLE[kinds])
    twice = (kinds == 5) | (kinds == 10)
    if twice.any():
        length += _joined(x[:, twice], y[:, twice], _SECOND_TABLE[kinds[twice]])
    return length


def _crossing(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where between 0 and 1 the values pass zero; anything where they do not."""
    return np.asarray(np.abs(start) / (np.abs(start) + np.abs(end)))


def _joined(x: NDArray[np.float64], y: NDArray[np.float64], sides: NDArray[np.intp]) -> float:
    """Return the summed length of the lines that join two sides of each cell."""
    cell = np.arange(sides.shape[0])
    first, second = sides[:, 0], sides[:, 1]
    dx = x[first, cell] - x[second, cell]
    dy = y[first, cell] - y[second, cell]
    return float(np.sqrt(dx * dx + dy * dy).sum())


def circularity(area_px: float, perimeter_px: float) -> float:
    """Return 4πA/P²: 1 for a disc, π/4 for a square.

    Nothing is rounder than a disc; what rounding to pixels adds above 1 is cut off.
    """
    return min(1.0, 4.0 * math.pi * area_px / (perimeter_px * perimeter_px))


def centroid_px(mask: NDArray[np.uint8]) -> tuple[float, float]:
    """Return the mean column and row of a mask's pixels."""
    moments = cv2.moments(mask, binaryImage=True)
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]


def major_axis_deg(mask: NDArray[np.uint8]) -> float:
    """Return the angle from +u towards +v of the major axis, -90 to 90 deg.

    From the second central moments: tan 2θ = 2 μ11 / (μ20 - μ02).
    """
    moments = cv2.moments(mask, binaryImage=True)
    angle = 0.5 * math.atan2(2.0 * moments["mu11"], moments["mu20"] - moments["mu02"])
    return math.degrees(angle)


def square_turn_deg(mask: NDArray[np.uint8]) -> float:
    """Return the angle from +u towards +v of a square's sides, -45 to 45 deg.

    Second moments of a square are the same in all directions; the fourth are not: with
    z = u + iv from the centroid, the mean of z⁴ points along four times the turn of the
    diagonals, whatever the square's size.
    """
    u_px, v_px = centroid_px(mask)
    rows, columns = np.nonzero(mask)
    squared = ((columns - u_px) + 1j * (rows - v_px)) ** 2
    fourth = complex(np.dot(squared, squared))
    diagonal_deg = math.degrees(math.atan2(fourth.imag, fourth.real)) / 4.0
    return diagonal_deg - math.copysign(45.0, diagonal_deg)
