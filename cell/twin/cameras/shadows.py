"""Soft shadows where blocks stand on the table or the sheet."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.profile import BlockProfile
from cell.twin.cameras.light import ScreenGlow
from cell.twin.cameras.painter import Eye
from cell.twin.scene import SceneBlock

_STRENGTH = 0.5
_FADE_MM = 14.0
_GROW_MM = 3.0
_SHIFT_MM = (-4.0, 5.0)
_BLUR_MM = 4.0
_LIT_LEVEL = 40.0
_GLASS_SHARE = 0.3


def cast_shadows(
    canvas: NDArray[np.uint8],
    blocks: Iterable[SceneBlock],
    sizes: dict[str, BlockProfile],
    surface_mm: float,
    eye: Eye,
    glow: ScreenGlow,
) -> None:
    """Darken the canvas around the foot of every block.

    A lit panel shines from below and hides the shadow; dark glass hardly shows one.
    """
    for block in blocks:
        above = max(block.z_mm - surface_mm, 0.0)
        if above > 4 * _FADE_MM:
            continue
        place = np.array([[block.x_mm, block.y_mm, surface_mm]])
        around = float(glow.around(place).max())
        strength = _STRENGTH * math.exp(-above / _FADE_MM) * _LIT_LEVEL / (_LIT_LEVEL + around)
        if strength >= 0.04:
            _cast(canvas, block, sizes[block.kind], surface_mm, above, eye, strength)


def _cast(
    canvas: NDArray[np.uint8],
    block: SceneBlock,
    size: BlockProfile,
    surface_mm: float,
    above_mm: float,
    eye: Eye,
    strength: float,
) -> None:
    outline = _foot(block, size, surface_mm)
    camera = eye.to_camera(outline)
    if camera[:, 2].min() < 20.0:
        return
    pixels = eye.lens.project(camera)
    blur_px = (_BLUR_MM + above_mm * 0.5) * eye.lens.focal_px / float(camera[:, 2].mean())
    margin = 3 * blur_px + 2
    height, width = canvas.shape[:2]
    left, top = (max(0, int(k - margin)) for k in pixels.min(axis=0))
    right = min(width, int(pixels[:, 0].max() + margin))
    bottom = min(height, int(pixels[:, 1].max() + margin))
    if left >= right or top >= bottom:
        return
    mask = np.full((bottom - top, right - left), 255, np.uint8)
    points = np.rint((pixels - (left, top)) * 16).astype(np.int32)
    cv2.fillConvexPoly(mask, points, round(255 * (1.0 - strength)), cv2.LINE_AA, 4)
    side = 2 * round(1.5 * blur_px) + 1
    for _ in range(2):
        mask = np.asarray(cv2.blur(mask, (side, side), borderType=cv2.BORDER_REPLICATE), np.uint8)
    part = canvas[top:bottom, left:right]
    cv2.multiply(part, cv2.merge([mask, mask, mask]), dst=part, scale=1.0 / 255.0)


def _foot(block: SceneBlock, size: BlockProfile, surface_mm: float) -> NDArray[np.float64]:
    """Return the outline of a block's foot, grown and moved away from the lamp."""
    turn = math.radians(block.yaw_deg)
    cos, sin = math.cos(turn), math.sin(turn)
    if size.shape == "cylinder":
        angles = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
        radius = size.length_mm / 2 + _GROW_MM
        local = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    else:
        half = np.array([size.length_mm / 2 + _GROW_MM, size.width_mm / 2 + _GROW_MM])
        local = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    place = local @ np.array([[cos, sin], [-sin, cos]]) + (block.x_mm, block.y_mm) + _SHIFT_MM
    return np.column_stack([place, np.full(len(place), surface_mm)])
