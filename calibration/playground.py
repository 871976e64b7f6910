"""The part of the table that accuracy is stated for."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

PLAYGROUND_MM: Final = ((300.0, -350.0), (700.0, -350.0), (700.0, 300.0), (300.0, 300.0))
"""Corners in the robot frame: the four points at which the reference calibrates its camera
(Dubec 2011, 5.4)."""


def playground_grid(across: int = 5, along: int = 7) -> NDArray[np.float64]:
    """Return points all over the playground with its corners, (n, 2), robot mm."""
    corners = np.array(PLAYGROUND_MM)
    (left, low), (right, high) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    x, y = np.meshgrid(np.linspace(left, right, across), np.linspace(low, high, along))
    return np.stack([x.ravel(), y.ravel()], axis=1)
