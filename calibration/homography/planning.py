"""Where the calibration object is put: corners first, then where the map is known least."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.homography.knowledge import TableFit
from calibration.playground import PLAYGROUND_MM, playground_grid

Points = NDArray[np.float64]
Place = tuple[float, float]

_STEP_MM = 10.0
_NEAREST_MM = 60.0
_GRID = (9, 11)
_HELD_OUT = ((0.3, 0.35), (0.7, 0.7), (0.45, 0.8), (0.75, 0.2), (0.15, 0.55), (0.5, 0.5))
"""Fresh points, as shares of the playground along x and y, far from corners and each other."""

IsReached = Callable[[float, float], str]
"""Says why a place cannot be reached; empty if it can."""


def corners(why_not: IsReached) -> tuple[Place, ...]:
    """Return the playground's corners, each drawn towards the middle until it is in reach."""
    middle = np.array(PLAYGROUND_MM).mean(axis=0)
    return tuple(_drawn_in(np.array(corner), middle, why_not) for corner in PLAYGROUND_MM)


def _drawn_in(corner: Points, middle: Points, why_not: IsReached) -> Place:
    way = middle - corner
    steps = int(np.hypot(*way) // _STEP_MM)
    for step in range(steps + 1):
        x, y = (float(v) for v in corner + way * (step * _STEP_MM / np.hypot(*way)))
        if not why_not(x, y):
            return round(x, 1), round(y, 1)
    return float(middle[0]), float(middle[1])


def least_known(fit: TableFit, taken: Sequence[Place], why_not: IsReached) -> Place | None:
    """Return the place in reach where the map is predicted to be worst, away from the others."""
    grid = playground_grid(*_GRID)
    spread = np.trace(fit.covariance_at(fit.to_picture(grid)), axis1=1, axis2=2)
    for index in np.argsort(-spread):
        x, y = (float(v) for v in grid[index])
        is_far = all(np.hypot(x - tx, y - ty) >= _NEAREST_MM for tx, ty in taken)
        if is_far and not why_not(x, y):
            return x, y
    return None


def fresh_places(count: int, why_not: IsReached) -> tuple[Place, ...]:
    """Return places to test a map at."""
    (x0, y0), _, (x1, y1), _ = PLAYGROUND_MM
    middle = np.array(PLAYGROUND_MM).mean(axis=0)
    shares = [_HELD_OUT[index % len(_HELD_OUT)] for index in range(count)]
    places = [np.array([x0 + a * (x1 - x0), y0 + b * (y1 - y0)]) for a, b in shares]
    return tuple(_drawn_in(place, middle, why_not) for place in places)


def predicted_error(fit: TableFit) -> tuple[float, float]:
    """Return the predicted RMS error over the playground and its worst place's 95 % radius, mm."""
    covariances = fit.covariance_at(fit.to_picture(playground_grid(*_GRID)))
    rms = float(np.sqrt(np.trace(covariances, axis1=1, axis2=2).mean()))
    largest = float(np.linalg.eigvalsh(covariances).max())
    return rms, float(np.sqrt(largest * fit.region_factor(2)))
