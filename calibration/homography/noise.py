"""How exactly pairs of picture and robot points are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Matrices = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PairNoise:
    """Standard deviations, along each axis, of what a pair consists of.

    Attributes:
        pixel_px: Of a point found in the picture. 0.5 px is what thresholded regions of
            noisy pictures give; points found to a subpixel are better.
        placement_mm: Of where the object lies against where it should: the arm's scatter
            when it lets go, or a person's when he measures.
    """

    pixel_px: float = 0.5
    placement_mm: float = 0.3

    def in_robot(self, slopes: Matrices) -> Matrices:
        """Return the covariances (n, 2, 2) in mm², for slopes d robot / d picture (n, 2, 2)."""
        pixel = self.pixel_px**2 * slopes @ slopes.transpose(0, 2, 1)
        return np.asarray(pixel + self.placement_mm**2 * np.eye(2))

    def in_picture(self, slopes: Matrices) -> Matrices:
        """Return the covariances (n, 2, 2) in px², for slopes d picture / d robot (n, 2, 2)."""
        placement = self.placement_mm**2 * slopes @ slopes.transpose(0, 2, 1)
        return np.asarray(placement + self.pixel_px**2 * np.eye(2))


def whitener(covariances: Matrices) -> Matrices:
    """Return W (n, 2, 2) with Wᵀ·W the inverse of each covariance."""
    lower = np.linalg.cholesky(covariances)
    return np.asarray(np.linalg.inv(lower))
