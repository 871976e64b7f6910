"""Soft shadows where blocks stand on the table or the sheet."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.profile import BlockProfile
from cell.twin.cameras.light import ScreenGlow
from cell.twin.scene import SceneBlock

ToPixels = Callable[[NDArray[np.float64]], NDArray[np.float64] | None]
"""From robot points (n, 3) to canvas pixels (n, 2); None where they cannot be seen."""

STANDING_MM = 3.0
"""A block higher above the surface than this casts no shadow at its foot."""

_STRENGTH = 0.5
_LEAST_STRENGTH = 0.03
_GROW_MM = 3.0
_SHIFT_MM = (-4.0, 5.0)
_BLUR_MM = 4.0
_LIT_LEVEL = 40.0


def standing(blocks: Sequence[SceneBlock], surface_mm: float) -> tuple[SceneBlock, ...]:
    """Return the blocks that stand on the surface."""
    return tuple(block for block in blocks if block.z_mm - surface_mm < STANDING_MM)


def cast_shadows(
    canvas: NDArray[np.uint8],
    blocks: Sequence[SceneBlock],
    sizes: Mapping[str, BlockProfile],
    surface_mm: float,
    to_pixels: ToPixels,
    glow: ScreenGlow,
) -> None:
    """Darken the canvas, of three or four channels, around the foot of every block.

    A lit panel shines from below and hides the shadow.
    """
    if not blocks:
        return
    places = np.array([(b.x_mm, b.y_mm, surface_mm) for b in blocks])
    around = glow.around(places).max(axis=1)
    strengths = (_STRENGTH * _LIT_LEVEL / (_LIT_LEVEL + around)).tolist()
    for block, place, strength in zip(blocks, places, strengths, strict=True):
        if strength < _LEAST_STRENGTH:
            continue
        outline = _foot(sizes[block.kind], block.yaw_deg)
        pixels = to_pixels(outline + place)
        if pixels is not None:
            _darken(canvas, pixels, _BLUR_MM * _scale(pixels, outline), strength)


def _scale(pixels: NDArray[np.float64], outline_mm: NDArray[np.float64]) -> float:
    """Return pixels a millimetre, from the areas of an outline in both."""
    area_px = cv2.contourArea(pixels.astype(np.float32))
    area_mm = cv2.contourArea(outline_mm[:, :2].astype(np.float32))
    return math.sqrt(area_px / area_mm)


def _darken(
    canvas: NDArray[np.uint8], pixels: NDArray[np.float64], soft_px: float, strength: float
) -> None:
    """Darken the canvas inside an outline (n, 2) whose edge is `soft_px` wide."""
    margin = 3 * soft_px + 2
    height, width = canvas.shape[:2]
    left, top = (max(0, int(k - margin)) for k in pixels.min(axis=0).tolist())
    high_u, high_v = pixels.max(axis=0).tolist()
    right, bottom = min(width, int(high_u + margin)), min(height, int(high_v + margin))
    if left >= right or top >= bottom:
        return
    mask = np.full((bottom - top, right - left), 255, np.uint8)
    points = np.rint((pixels - (left, top)) * 16).astype(np.int32)
    cv2.fillConvexPoly(mask, points, round(255 * (1.0 - strength)), cv2.LINE_AA, 4)
    side = 2 * round(1.5 * soft_px) + 1
    for _ in range(2):
        mask = np.asarray(cv2.blur(mask, (side, side), borderType=cv2.BORDER_REPLICATE), np.uint8)
    part = canvas[top:bottom, left:right]
    cv2.multiply(part, cv2.merge([mask] * canvas.shape[2]), dst=part, scale=1.0 / 255.0)


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
