"""A camera that sees the table as a plane map says, for cameras whose lens nobody measured.

A homography alone does not say how far away a camera is. For the small motions that the check
for drift looks for it does not matter: any camera that maps the block tops alike will do.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from calibration.playground import playground_grid
from cell.geometry import CameraView, LensModel, PlaneView, Transform

_WIDTH_PX: Final = 1280
_HEIGHT_PX: Final = 960
_FOCAL_PX: Final = tuple(float(k) for k in np.geomspace(500.0, 6000.0, 40))


def camera_like(view: PlaneView, top_mm: float) -> CameraView | None:
    """Return the camera with a middle lens that sees the playground most as a map says.

    Args:
        view: The map.
        top_mm: Height of the block tops, where it holds.

    Returns:
        The camera, None if no camera over the table sees it so.
    """
    grid = playground_grid()
    pixels = view.to_picture(grid, top_mm)
    points = np.column_stack([grid, np.zeros(len(grid))])
    best: CameraView | None = None
    least = np.inf
    for focal_px in _FOCAL_PX:
        lens = _lens(focal_px)
        is_found, turn, shift = cv2.solvePnP(
            points, pixels, lens.matrix, None, flags=cv2.SOLVEPNP_IPPE
        )
        if not is_found or not np.isfinite(shift).all():
            continue
        matrix = np.eye(4, dtype=np.float64)
        matrix[:3, :3] = cv2.Rodrigues(np.asarray(turn, np.float64))[0]
        matrix[:3, 3] = np.asarray(shift, np.float64).ravel()
        above = np.asarray(np.linalg.inv(matrix), np.float64)
        above[2, 3] += top_mm
        if above[2, 3] <= top_mm:
            continue
        found = CameraView(lens, Transform(above))
        off = float(np.mean((found.to_picture(grid, top_mm) - pixels) ** 2))
        if off < least:
            best, least = found, off
    return best


def _lens(focal_px: float) -> LensModel:
    return LensModel(
        width_px=_WIDTH_PX,
        height_px=_HEIGHT_PX,
        focal_u_px=focal_px,
        focal_v_px=focal_px,
        centre_u_px=0.5 * (_WIDTH_PX - 1),
        centre_v_px=0.5 * (_HEIGHT_PX - 1),
    )
