"""Soft shadows where blocks stand on the table or the sheet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.profile import BlockProfile
from cell.twin.cameras.light import ScreenGlow
from cell.twin.cameras.painter import Eye
from cell.twin.scene import SceneBlock

_STRENGTH = 0.5
_LEAST_STRENGTH = 0.05
_FADE_MM = 14.0
_GROW_MM = 3.0
_SHIFT_MM = (-4.0, 5.0)
_BLUR_MM = 4.0
_LIT_LEVEL = 40.0
_COARSE_PX = 4.0
"""A shadow blurred over many pixels is drawn this much coarser and enlarged."""


def cast_shadows(
    canvas: NDArray[np.uint8],
    blocks: Sequence[SceneBlock],
    sizes: Mapping[str, BlockProfile],
    surface_mm: float,
    eye: Eye,
    glow: ScreenGlow,
) -> None:
    """Darken the canvas around the foot of every block.

    A lit panel shines from below and hides the shadow.
    """
    if not blocks:
        return
    places = np.array([(b.x_mm, b.y_mm, surface_mm) for b in blocks])
    above = np.maximum([b.z_mm - surface_mm for b in blocks], 0.0)
    around = glow.around(places).max(axis=1)
    strengths = _STRENGTH * np.exp(-above / _FADE_MM) * _LIT_LEVEL / (_LIT_LEVEL + around)
    camera = eye.to_camera(places)
    is_cast = (strengths >= _LEAST_STRENGTH) & (camera[:, 2] > 60.0)
    lens = eye.lens
    reach = np.abs(camera[:, :2]) - 120.0 < 0.62 / lens.focal_px * camera[:, 2:] * (
        lens.width_px,
        lens.height_px,
    )
    is_cast &= reach.all(axis=1)
    for index in np.flatnonzero(is_cast).tolist():
        block = blocks[index]
        outline = _foot(sizes[block.kind], block.yaw_deg) + places[index]
        soft_mm = _BLUR_MM + 0.5 * float(above[index])
        _cast(canvas, eye, outline, soft_mm, float(strengths[index]))


def _cast(
    canvas: NDArray[np.uint8],
    eye: Eye,
    outline: NDArray[np.float64],
    soft_mm: float,
    strength: float,
) -> None:
    """Darken the canvas inside an outline (n, 3), blurred over `soft_mm`."""
    camera = eye.to_camera(outline)
    if camera[:, 2].min() < 20.0:
        return
    pixels = eye.lens.project(camera)
    soft_px = soft_mm * eye.lens.focal_px / float(camera[:, 2].mean())
    margin = 3 * soft_px + 2
    height, width = canvas.shape[:2]
    left, top = (max(0, int(k - margin)) for k in pixels.min(axis=0).tolist())
    high_u, high_v = pixels.max(axis=0).tolist()
    right, bottom = min(width, int(high_u + margin)), min(height, int(high_v + margin))
    if left >= right or top >= bottom:
        return
    coarse = _COARSE_PX if soft_px > 2 * _COARSE_PX else 1.0
    size = (math.ceil((right - left) / coarse), math.ceil((bottom - top) / coarse))
    mask = np.full(size[::-1], 255, np.uint8)
    points = np.rint((pixels - (left, top)) * (16 / coarse)).astype(np.int32)
    cv2.fillConvexPoly(mask, points, round(255 * (1.0 - strength)), cv2.LINE_AA, 4)
    side = 2 * round(1.5 * soft_px / coarse) + 1
    for _ in range(2):
        mask = np.asarray(cv2.blur(mask, (side, side), borderType=cv2.BORDER_REPLICATE), np.uint8)
    if coarse > 1.0:
        mask = np.asarray(cv2.resize(mask, (right - left, bottom - top)), np.uint8)
    part = canvas[top:bottom, left:right]
    cv2.multiply(part, cv2.merge([mask, mask, mask]), dst=part, scale=1.0 / 255.0)


@lru_cache(maxsize=64)
def _foot(size: BlockProfile, yaw_deg: float) -> NDArray[np.float64]:
    """Return the outline (n, 3) of a block's foot, grown and moved away from the lamp."""
    turn = math.radians(yaw_deg)
    cos, sin = math.cos(turn), math.sin(turn)
    if size.shape == "cylinder":
        angles = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
        radius = size.length_mm / 2 + _GROW_MM
        local = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    else:
        half = np.array([size.length_mm / 2 + _GROW_MM, size.width_mm / 2 + _GROW_MM])
        local = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    place = local @ np.array([[cos, sin], [-sin, cos]]) + _SHIFT_MM
    return np.column_stack([place, np.zeros(len(place))])
