"""What the emulated web camera sees: a room of squares that tell where it looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.twin.emulators.axis_vapix.head import HeadState, angle_of_view_deg
from cell.twin.emulators.axis_vapix.settings import EmulatedAxisSettings

Pixels: TypeAlias = NDArray[np.uint8]
"""Shape (height, width, 3), uint8, R G B."""

PictureSource: TypeAlias = Callable[[HeadState, EmulatedAxisSettings, int, int], Pixels]
"""Gives the picture of a width and a height for where the head points."""

_SQUARE_DEG = 5.0
_SHARP_FOCUS = 4642.0
_MIDDLE_BRIGHTNESS = 4999.0


def panorama(
    state: HeadState, settings: EmulatedAxisSettings, width_px: int, height_px: int
) -> Pixels:
    """Return the part of a wall of squares that the camera sees.

    Every square of 5 deg has a colour of its own, a line marks each border, and the
    position stands in a corner. Rows and columns are angles (f-theta projection), so a
    pixel's pan and tilt follow from its distance to the middle.
    """
    view_deg = angle_of_view_deg(state, settings)
    scale = view_deg / width_px
    pan = state.pan_deg + (np.arange(width_px) + 0.5 - width_px / 2) * scale
    tilt = state.tilt_deg - (np.arange(height_px) + 0.5 - height_px / 2) * scale
    column, row = np.floor(pan / _SQUARE_DEG).astype(int), np.floor(tilt / _SQUARE_DEG).astype(int)
    pixels = np.empty((height_px, width_px, 3), np.float32)
    pixels[..., 0] = 60 + (column[None, :] * 37 + row[:, None] * 11) % 160
    pixels[..., 1] = 60 + (column[None, :] * 17 + row[:, None] * 53) % 160
    pixels[..., 2] = 60 + (column[None, :] * 71 + row[:, None] * 29) % 160
    line = max(0.05, 1.5 * scale)
    pixels[:, np.abs(pan - np.round(pan / _SQUARE_DEG) * _SQUARE_DEG) < line] = 20
    pixels[np.abs(tilt - np.round(tilt / _SQUARE_DEG) * _SQUARE_DEG) < line] = 20
    blur = 0.0 if state.has_autofocus else abs(state.focus - _SHARP_FOCUS) / 600.0
    if blur > 0.3:
        pixels = np.asarray(cv2.GaussianBlur(pixels, (0, 0), blur), np.float32)
    pixels *= np.float32(0.5 + 0.5 * state.brightness / _MIDDLE_BRIGHTNESS)
    picture = np.ascontiguousarray(np.clip(np.rint(pixels), 0, 255), np.uint8)
    text = f"pan {state.pan_deg:.1f}  tilt {state.tilt_deg:.1f}  zoom {state.zoom:.0f}"
    size, row = max(0.3, width_px / 1000), height_px - 12
    # A dark copy beside the light one keeps the text legible on every square.
    for shift, colour in ((1, (0, 0, 0)), (0, (255, 255, 255))):
        at = (8 + shift, row + shift)
        cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
    return picture


def encode_jpeg(pixels: Pixels, compression: int) -> bytes:
    """Return the JPEG file of a picture; the higher the compression, the smaller it is."""
    quality = max(1, 100 - compression)
    _, data = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    return data.tobytes()
