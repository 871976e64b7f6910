"""The lens: from directions in front of a camera to pixels and back.

Pinhole with Brown's distortion (Brown 1971), the model and the order of coefficients of
OpenCV's `calibrateCamera`: a direction (x, y) = (X/Z, Y/Z) of the camera frame (x to the
picture's right, y down, z along the view) goes, with r² = x² + y², to

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y

before focal length and centre apply. Pixel centres are whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

_STEPS = 30
_DONE = 1e-12

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LensModel:
    """A lens over a sensor.

    Attributes:
        width_px: Width of the picture that the figures speak of.
        height_px: Height of that picture.
        focal_u_px: Focal length in columns.
        focal_v_px: Focal length in rows.
        centre_u_px: Column where the optical axis meets the picture.
        centre_v_px: Row where the optical axis meets the picture.
        k1: Radial coefficient of r².
        k2: Radial coefficient of r⁴.
        p1: First tangential coefficient.
        p2: Second tangential coefficient.
        k3: Radial coefficient of r⁶.
    """

    width_px: int
    height_px: int
    focal_u_px: float
    focal_v_px: float
    centre_u_px: float
    centre_v_px: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    @property
    def matrix(self) -> Points:
        """The camera matrix, shape (3, 3)."""
        return np.array(
            [
                [self.focal_u_px, 0.0, self.centre_u_px],
                [0.0, self.focal_v_px, self.centre_v_px],
                [0.0, 0.0, 1.0],
            ]
        )

    @property
    def coefficients(self) -> Points:
        """k1, k2, p1, p2, k3: OpenCV's order, shape (5,)."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    def resized(self, width_px: int) -> LensModel:
        """Return the same lens over a sensor with fewer or more pixels."""
        scale = width_px / self.width_px
        return replace(
            self,
            width_px=width_px,
            height_px=round(self.height_px * scale),
            focal_u_px=self.focal_u_px * scale,
            focal_v_px=self.focal_v_px * scale,
            centre_u_px=(self.centre_u_px + 0.5) * scale - 0.5,
            centre_v_px=(self.centre_v_px + 0.5) * scale - 0.5,
        )

    def to_picture(self, directions: Points) -> Points:
        """Return pixels u, v of directions (x/z, y/z), shape (..., 2)."""
        distorted = self._distort(np.asarray(directions, np.float64))
        return distorted * self._focal + self._centre

    def to_directions(self, pixels: Points) -> Points:
        """Return directions (x/z, y/z) of pixels, shape (..., 2): the inverse of `to_picture`.

        Fixed-point iteration with Newton's correction by the radial slope; exact to 1e-10
        wherever the model is invertible.
        """
        target = (np.asarray(pixels, np.float64) - self._centre) / self._focal
        if not self.coefficients.any():
            return target
        directions = target.copy()
        for _ in range(_STEPS):
            miss = self._distort(directions) - target
            squared = np.einsum("...i,...i->...", directions, directions)
            slope = 1.0 + squared * (
                3.0 * self.k1 + squared * (5.0 * self.k2 + 7.0 * self.k3 * squared)
            )
            directions = directions - miss / np.maximum(slope, 0.2)[..., None]
            if np.abs(miss).max(initial=0.0) < _DONE:
                break
        return directions

    def to_ideal(self, pixels: Points) -> Points:
        """Return where pixels (..., 2) would lie if the lens did not distort."""
        return self.to_directions(pixels) * self._focal + self._centre

    @property
    def _focal(self) -> Points:
        return np.array([self.focal_u_px, self.focal_v_px])

    @property
    def _centre(self) -> Points:
        return np.array([self.centre_u_px, self.centre_v_px])

    def _distort(self, directions: Points) -> Points:
        x, y = directions[..., 0], directions[..., 1]
        squared = x * x + y * y
        radial = 1.0 + squared * (self.k1 + squared * (self.k2 + squared * self.k3))
        cross = x * y
        return np.stack(
            [
                x * radial + 2.0 * self.p1 * cross + self.p2 * (squared + 2.0 * x * x),
                y * radial + self.p1 * (squared + 2.0 * y * y) + 2.0 * self.p2 * cross,
            ],
            axis=-1,
        )
