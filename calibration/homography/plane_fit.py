"""A homography with least geometric error, and how well it is known at every pixel.

The pairs' errors, in picture and placement, are taken together as an error in the robot
plane (to first order; Hartley and Zisserman, 4.3 and 5.2). With four pairs the fit goes
through all of them: what is known of its errors then comes from the stated noise alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.homography.dlt import apply, homography, local_scale
from calibration.homography.noise import PairNoise, whitener
from calibration.least_squares import fit
from calibration.statistics import region_factor

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

PARAMETERS = 8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaneFit:
    """A fitted homography, picture to robot.

    Attributes:
        matrix: Shape (3, 3), last entry 1.
        covariance: Of the other eight entries, row by row, shape (8, 8).
        freedom: Degrees of freedom of the noise if it came from the residuals; None if it
            was stated.
        residuals_mm: Fitted less given robot points, shape (n, 2).
        noise_ratio: Spread of the residuals as a multiple of the stated noise; None where no
            residual is left, with four pairs.
    """

    matrix: Matrix
    covariance: Matrix
    freedom: int | None
    residuals_mm: Points
    noise_ratio: float | None

    def to_robot(self, pixels: Points) -> Points:
        """Return robot x, y in mm (n, 2) of pixels (n, 2)."""
        return apply(self.matrix, pixels)

    def to_picture(self, points_mm: Points) -> Points:
        """Return pixels (n, 2) of robot points (n, 2)."""
        return apply(np.asarray(np.linalg.inv(self.matrix), np.float64), points_mm)

    def covariance_at(self, pixels: Points) -> Matrix:
        """Return the covariances (n, 2, 2), in mm², of where pixels are mapped to."""
        slopes = _entry_slopes(self.matrix, pixels)
        return np.asarray(slopes @ self.covariance @ slopes.transpose(0, 2, 1))

    def region_factor(self, dimensions: int, probability: float = 0.95) -> float:
        """Return the squared Mahalanobis distance that bounds regions of a probability."""
        return region_factor(dimensions, self.freedom, probability)


def fit_plane(
    pixels: Points, points_mm: Points, noise: PairNoise, *, is_noise_known: bool = True
) -> PlaneFit:
    """Fit the homography from picture to robot.

    Args:
        pixels: u, v, shape (n, 2), n ≥ 4; of a lens without distortion.
        points_mm: Robot x, y, shape (n, 2).
        noise: How exactly the pairs are known.
        is_noise_known: Whether to believe the noise; else only its proportions are, and its
            size comes from the residuals (n ≥ 5).

    Raises:
        FitFailed: The pairs do not determine it.
    """
    start = homography(pixels, points_mm)
    white = whitener(noise.in_robot(local_scale(start, pixels)))
    ratio = None
    if len(pixels) == 4:
        slopes = (white @ _entry_slopes(start, pixels)).reshape(-1, PARAMETERS)
        inverse = np.linalg.inv(slopes)
        return PlaneFit(
            matrix=start,
            covariance=inverse @ inverse.T,
            freedom=None,
            residuals_mm=apply(start, pixels) - points_mm,
            noise_ratio=ratio,
        )

    def residuals(entries: Matrix) -> Points:
        miss = apply(np.append(entries, 1.0).reshape(3, 3), pixels) - points_mm
        return np.asarray((white @ miss[..., None]).ravel())

    def jacobian(entries: Matrix) -> Matrix:
        matrix = np.append(entries, 1.0).reshape(3, 3)
        return np.asarray((white @ _entry_slopes(matrix, pixels)).reshape(-1, PARAMETERS))

    found = fit(
        residuals, start.ravel()[:8], jacobian=jacobian, is_noise_known=is_noise_known, steps=20
    )
    matrix = np.append(found.parameters, 1.0).reshape(3, 3)
    return PlaneFit(
        matrix=matrix,
        covariance=found.covariance,
        freedom=None if is_noise_known else found.freedom,
        residuals_mm=apply(matrix, pixels) - points_mm,
        noise_ratio=float(np.sqrt(found.residuals @ found.residuals / found.freedom)),
    )


def _entry_slopes(matrix: Matrix, pixels: Points) -> Matrix:
    """Return d (x, y) / d entries, shape (n, 2, 8)."""
    u, v = pixels[:, 0], pixels[:, 1]
    weight = matrix[2, 0] * u + matrix[2, 1] * v + matrix[2, 2]
    a, b, c = u / weight, v / weight, 1.0 / weight
    mapped = apply(matrix, pixels)
    x, y = mapped[:, 0], mapped[:, 1]
    none = np.zeros_like(a)
    return np.stack(
        [
            np.stack([a, b, c, none, none, none, -x * a, -x * b], axis=1),
            np.stack([none, none, none, a, b, c, -y * a, -y * b], axis=1),
        ],
        axis=1,
    )
