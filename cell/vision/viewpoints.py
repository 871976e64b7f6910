"""Which camera to look at the playground with, when several are mapped to it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cell.geometry import TableView
from cell.profile import DisplayProfile, Profile

_STEP_MM = 1.0
_SHARES = ((0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9), (0.5, 0.5))
"""Places of the screen that are looked at: near its corners, and its middle."""

Points = NDArray[np.float64]


def mapped_cameras(profile: Profile) -> tuple[str, ...]:
    """Return the cameras whose pictures are mapped to the block tops, the best one first.

    The best one shows a millimetre in the most pixels where it shows it in the fewest: close
    by, and from above rather than from the side, where blocks hide each other.
    """
    top_mm = profile.block_top_mm
    places = _places(profile.display)
    fineness = {
        name: _least_px_per_mm(view, places, top_mm)
        for name, camera in profile.cameras.items()
        if (view := camera.view(top_mm)) is not None
    }
    return tuple(sorted(fineness, key=lambda name: -fineness[name]))


def _places(display: DisplayProfile) -> Points:
    wide, high = display.size_mm
    return np.array([display.to_robot(wide * along, high * below) for along, below in _SHARES])


def _least_px_per_mm(view: TableView, places: Points, height_mm: float) -> float:
    """Return the fewest pixels a millimetre, in any direction at any place; 0 if unseen."""
    ahead, aside = np.array([_STEP_MM, 0.0]), np.array([0.0, _STEP_MM])
    try:
        at, along_x, along_y = (
            view.to_picture(places + step, height_mm) for step in (np.zeros(2), ahead, aside)
        )
    except ValueError:
        return 0.0
    slopes = np.stack([along_x - at, along_y - at], axis=-1) / _STEP_MM
    return float(np.linalg.svd(slopes, compute_uv=False)[:, -1].min())
