"""The lens: from points in front of the camera to pixels and back.

Pinhole with Brown's radial distortion: a point (x, y, z) of the camera frame (x to
the picture's right, y down, z along the view) has the normalised coordinates
(x/z, y/z), which are multiplied by 1 + k1 r² + k2 r⁴ before focal length and centre
apply (Brown 1971; the model of OpenCV's `projectPoints`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import CameraMode
from cell.profile import TwinCameraProfile

FULL_WIDTH_PX = 1280
"""Width of the picture that the profile's focal length and centre speak of."""

_LEAST_COLUMNS = 80
"""Cells across the picture: enough for a tenth of a pixel with the cell's lenses."""

_NEWTON_STEPS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """A lens over a sensor of `width_px` by `height_px` pixels.

    Attributes:
        width_px: Width of the picture.
        height_px: Height of the picture.
        focal_px: Focal length in pixels.
        centre_u_px: Where the optical axis meets the picture.
        centre_v_px: Where the optical axis meets the picture.
        k1: Brown's second-order radial coefficient.
        k2: Brown's fourth-order radial coefficient.
        vignetting: Share of light lost in the picture's corners.
    """

    width_px: int
    height_px: int
    focal_px: float
    centre_u_px: float
    centre_v_px: float
    k1: float = 0.0
    k2: float = 0.0
    vignetting: float = 0.0

    def resized(self, width_px: int) -> Lens:
        """Return the same lens over a sensor with fewer or more pixels."""
        scale = width_px / self.width_px
        return replace(
            self,
            width_px=width_px,
            height_px=round(self.height_px * scale),
            focal_px=self.focal_px * scale,
            centre_u_px=(self.centre_u_px + 0.5) * scale - 0.5,
            centre_v_px=(self.centre_v_px + 0.5) * scale - 0.5,
        )

    def project(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pixels (n, 2) of points (n, 3) of the camera frame with z > 0.

        Far outside the picture, where Brown's polynomial would fold back, the
        distortion factor is held, so that such points stay outside.
        """
        normal = points_mm[:, :2] / points_mm[:, 2:]
        squared = np.minimum(np.einsum("ij,ij->i", normal, normal), self._fold_radius_squared())
        factor = self.focal_px * (1.0 + squared * (self.k1 + self.k2 * squared))
        return np.asarray(normal * factor[:, None] + (self.centre_u_px, self.centre_v_px))

    def undistort(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return normalised coordinates (n, 2) of pixels (n, 2): the inverse of `project`.

        Newton's method on the radius; exact to 1e-12 wherever the model is invertible.
        """
        distorted = (pixels - (self.centre_u_px, self.centre_v_px)) / self.focal_px
        target = np.hypot(distorted[:, 0], distorted[:, 1])
        radius = target.copy()
        for _ in range(_NEWTON_STEPS):
            squared = radius * radius
            value = radius * (1.0 + squared * (self.k1 + self.k2 * squared)) - target
            slope = 1.0 + squared * (3.0 * self.k1 + 5.0 * self.k2 * squared)
            radius -= value / np.maximum(slope, 0.05)
        ratio: NDArray[np.float64] = np.divide(
            radius, target, out=np.ones_like(radius), where=target > 0
        )
        return np.asarray(distorted * ratio[:, None])

    def brightness(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of light that reaches pixels (n, 2): 1 at the centre."""
        offset = pixels - (self.centre_u_px, self.centre_v_px)
        corner = (self.width_px / 2) ** 2 + (self.height_px / 2) ** 2
        return np.asarray(1.0 - self.vignetting * np.einsum("ij,ij->i", offset, offset) / corner)

    def _fold_radius_squared(self) -> float:
        """Return 90 % of the squared radius at which the distortion polynomial turns back."""
        if self.k2 == 0.0:
            return 0.9 / (3.0 * -self.k1) if self.k1 < 0 else np.inf
        roots = np.roots([5.0 * self.k2, 3.0 * self.k1, 1.0])
        turning = [float(r.real) for r in roots if abs(r.imag) < 1e-12 and r.real > 0]
        return 0.9 * min(turning) if turning else np.inf


def lens_for_mode(profile: TwinCameraProfile, mode: CameraMode) -> Lens:
    """Return the lens of a profile, scaled from 1280 x 960 to a mode's picture size.

    Pixel centres are whole numbers, so the picture's left edge lies at -0.5.
    """
    full = Lens(
        width_px=FULL_WIDTH_PX,
        height_px=FULL_WIDTH_PX * mode.height_px // mode.width_px,
        focal_px=profile.focal_px,
        centre_u_px=profile.centre_px[0],
        centre_v_px=profile.centre_px[1],
        k1=profile.k1,
        k2=profile.k2,
        vignetting=profile.vignetting,
    )
    return full.resized(mode.width_px)


@lru_cache(maxsize=16)
def coarse_rays(lens: Lens) -> NDArray[np.float64]:
    """Return viewing rays (rows, columns, 3), z = 1, of a grid that `GridSpreader` fills up."""
    columns, rows = _grid_size(lens)
    # Resizing holds the value beyond the outermost grid centres, so the grid reaches one
    # cell past the picture on every side.
    u = (np.arange(-1, columns + 1) + 0.5) * (lens.width_px / columns) - 0.5
    v = (np.arange(-1, rows + 1) + 0.5) * (lens.height_px / rows) - 0.5
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = np.ones((rows + 2, columns + 2, 3))
    rays[..., :2] = lens.undistort(pixels).reshape(rows + 2, columns + 2, 2)
    rays.setflags(write=False)
    return rays


class GridSpreader:
    """Interpolates pairs of values on the grid of `coarse_rays` to every pixel."""

    def __init__(self, lens: Lens) -> None:
        columns, rows = _grid_size(lens)
        self._pad_u, self._pad_v = lens.width_px // columns, lens.height_px // rows
        height, width = lens.height_px + 2 * self._pad_v, lens.width_px + 2 * self._pad_u
        # Fresh memory for a map costs more time than the interpolation itself.
        self._full = np.empty((height, width, 2), np.float32)

    def spread(self, coarse: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return values (h, w, 2) at every pixel, valid until the next call."""
        height, width = self._full.shape[:2]
        cv2.resize(coarse, (width, height), dst=self._full, interpolation=cv2.INTER_LINEAR)
        return self._full[self._pad_v : -self._pad_v, self._pad_u : -self._pad_u]


@lru_cache(maxsize=1)
def pixel_rays(lens: Lens) -> NDArray[np.float32]:
    """Return the viewing ray (h, w, 3), z = 1, of every pixel, exact."""
    u, v = np.meshgrid(np.arange(lens.width_px), np.arange(lens.height_px))
    pixels = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float64)
    rays = np.ones((lens.height_px, lens.width_px, 3), np.float32)
    rays[..., :2] = lens.undistort(pixels).reshape(lens.height_px, lens.width_px, 2)
    rays.setflags(write=False)
    return rays


@lru_cache(maxsize=6)
def brightness_map(lens: Lens) -> NDArray[np.float32]:
    """Return the share of light that reaches each pixel, shape (h, w)."""
    u, v = np.meshgrid(np.arange(lens.width_px), np.arange(lens.height_px))
    pixels = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float64)
    share = lens.brightness(pixels).reshape(lens.height_px, lens.width_px).astype(np.float32)
    share.setflags(write=False)
    return share


def _grid_size(lens: Lens) -> tuple[int, int]:
    """Return columns and rows of the coarse grid; both divide the picture's size."""
    common = math.gcd(lens.width_px, lens.height_px)
    coarsest = lens.width_px // _LEAST_COLUMNS
    pitch = max(p for p in range(1, coarsest + 1) if common % p == 0)
    return lens.width_px // pitch, lens.height_px // pitch
