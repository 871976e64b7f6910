"""A camera over the screen: eleven numbers, and where screen points appear.

The screen frame has its origin at the middle of the upper left pixel, x along the columns to
the right, y along the rows down, z into the table; millimetres. The lens has square pixels
and Brown's radial coefficients k1 and k2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.least_squares import Fit, Vector, fit
from calibration.screen.decode import Correspondences
from cell.geometry import LensModel, Transform

Points = NDArray[np.float64]

NAMES: Final = (
    "focal", "centre_u", "centre_v", "k1", "k2", "turn_x", "turn_y", "turn_z", "x", "y", "z",
)  # fmt: skip
UNITS: Final = ("px", "px", "px", "", "", "rad", "rad", "rad", "mm", "mm", "mm")
COUNT: Final = len(NAMES)
WIDTH_PX: Final = 1280
HEIGHT_PX: Final = 960

_FOCAL_STARTS: Final = (0.7, 1.2, 2.1, 3.6)
_START_POINTS: Final = 150
_FEWEST: Final = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class LensPrior:
    """What is known of a lens before anything is measured; standard deviations.

    Attributes:
        centre_px: Where lens and sensor are mounted to each other, about the picture's middle.
        focal_px: Focal length from the lens's data sheet; None if nobody looked it up.
        focal_deviation_px: How far off that may be.
        height_mm: Height of the lens over the glass by tape; None if nobody measured.
        height_deviation_mm: How far off that may be.
    """

    centre_px: float = 20.0
    focal_px: float | None = None
    focal_deviation_px: float = 60.0
    height_mm: float | None = None
    height_deviation_mm: float = 15.0

    def residuals(self, camera: Vector) -> Vector:
        """Return how far a camera (11,) lies from what is known, in standard deviations."""
        focal, centre_u, centre_v = camera[:3].tolist()
        off = [
            (centre_u - 0.5 * (WIDTH_PX - 1)) / self.centre_px,
            (centre_v - 0.5 * (HEIGHT_PX - 1)) / self.centre_px,
        ]
        if self.focal_px is not None:
            off.append((focal - self.focal_px) / self.focal_deviation_px)
        if self.height_mm is not None:
            height_mm = -screen_from_camera(camera).translation_mm[2]
            off.append((height_mm - self.height_mm) / self.height_deviation_mm)
        return np.array(off)


def lens_of(camera: Vector) -> LensModel:
    """Return the lens of a camera (11,)."""
    focal, centre_u, centre_v, k1, k2 = (float(k) for k in camera[:5])
    return LensModel(
        width_px=WIDTH_PX,
        height_px=HEIGHT_PX,
        focal_u_px=focal,
        focal_v_px=focal,
        centre_u_px=centre_u,
        centre_v_px=centre_v,
        k1=k1,
        k2=k2,
    )


def screen_from_camera(camera: Vector) -> Transform:
    """Return where a camera (11,) stands over the screen."""
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(camera[5:8])
    matrix[:3, 3] = camera[8:11]
    return Transform(matrix).inverse()


def project(camera: Vector, points_mm: Points) -> Points:
    """Return pixels (n, 2) of points (n, 3) of the screen frame.

    Points beside or behind the camera come out finite and far away, so that a fit that
    strays finds back.
    """
    seen = points_mm @ _rotation(camera[5:8]).T + camera[8:11]
    depth = np.maximum(seen[:, 2], 1.0)
    x, y = seen[:, 0] / depth, seen[:, 1] / depth
    squared = np.minimum(x * x + y * y, 4.0)
    factor = camera[0] * (1.0 + squared * (camera[3] + camera[4] * squared))
    return np.stack([x * factor + camera[1], y * factor + camera[2]], axis=1)


def on_glass(places: Points, pixel_mm: float) -> Points:
    """Return points (n, 3) of the screen frame of columns and rows (n, 2)."""
    return np.column_stack([places * pixel_mm, np.zeros(len(places))])


def fit_alone(seen: Correspondences, pixel_mm: float, prior: LensPrior, deviation_px: float) -> Fit:
    """Fit a camera to what it sees of the screen.

    Several focal lengths are tried as a start, as one plane hardly tells them apart.

    Raises:
        FitFailed: Too little of the screen is seen.
    """
    if len(seen) < _FEWEST:
        raise FitFailed(
            f"only {len(seen)} places of the screen are seen clearly, {_FEWEST} are needed; "
            "clear the screen and look at its picture"
        )
    points = on_glass(seen.places, pixel_mm)
    some = np.linspace(0, len(seen) - 1, min(len(seen), _START_POINTS)).astype(int)

    def residuals(chosen: NDArray[np.int_] | slice, camera: Vector) -> Vector:
        off = (project(camera, points[chosen]) - seen.pixels[chosen]) / deviation_px
        return np.concatenate([off.ravel(), prior.residuals(camera)])

    best: Fit | None = None
    for share in _FOCAL_STARTS:
        start = _start(points[some], seen.pixels[some], share * WIDTH_PX)
        if start is None:
            continue
        tried = fit(
            lambda camera: residuals(some, camera), start, is_noise_known=True, tolerance=1e-4
        )
        if best is None or tried.residuals @ tried.residuals < best.residuals @ best.residuals:
            best = tried
    if best is None:
        raise FitFailed("no place of the camera explains what it sees of the screen")
    return fit(
        lambda camera: residuals(slice(None), camera),
        best.parameters,
        is_noise_known=True,
        tolerance=1e-7,
    )


def _start(points: Points, pixels: Points, focal_px: float) -> Vector | None:
    matrix = np.array(
        [[focal_px, 0, 0.5 * (WIDTH_PX - 1)], [0, focal_px, 0.5 * (HEIGHT_PX - 1)], [0, 0, 1.0]]
    )
    is_found, turn, shift = cv2.solvePnP(points, pixels, matrix, None, flags=cv2.SOLVEPNP_IPPE)
    if not is_found or not np.isfinite(shift).all() or shift[2, 0] <= 0.0:
        return None
    head = [focal_px, matrix[0, 2], matrix[1, 2], 0.0, 0.0]
    return np.array([*head, *turn.ravel().tolist(), *shift.ravel().tolist()])


def _rotation(turn: Vector) -> Points:
    """Return the matrix of a rotation vector (Rodrigues)."""
    return np.asarray(cv2.Rodrigues(np.asarray(turn, np.float64))[0], np.float64)
