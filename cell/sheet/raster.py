"""A drawing as pixels, for the twin's sheet and for pictures of pages.

Text is drawn in OpenCV's stroke font, which stands for Helvetica; everything else is exact
to a quarter of a pixel.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.sheet.drawing import (
    Bitmap,
    Circle,
    Drawing,
    Figure,
    Line,
    Polygon,
    Rectangle,
    Text,
)
from cell.sheet.fonts import CAPITAL_SHARE, text_width_mm

_FINER = 4
_SHIFT = 6
_HERSHEY_CAPITAL_PX = 21

Picture = NDArray[np.uint8]


def raster(drawing: Drawing, px_per_mm: float) -> Picture:
    """Return a drawing as R G B pixels, (h, w, 3), edges softened.

    The pixel in column i covers the drawing from i to i + 1, over `px_per_mm`.
    """
    wide = round(drawing.width_mm * px_per_mm)
    tall = round(drawing.height_mm * px_per_mm)
    scale = px_per_mm * _FINER
    fine = np.full((tall * _FINER, wide * _FINER, 3), 255, np.uint8)
    for figure in drawing.figures:
        _draw(fine, figure, scale)
    return np.asarray(cv2.resize(fine, (wide, tall), interpolation=cv2.INTER_AREA), np.uint8)


def _draw(fine: Picture, figure: Figure, scale: float) -> None:
    match figure:
        case Rectangle():
            _rectangle(fine, figure, scale)
        case Bitmap():
            for run in figure.runs():
                _rectangle(fine, run, scale)
        case Circle():
            centre = _px(figure.x_mm, figure.y_mm, scale)
            half = 0.0 if figure.stroke is None else figure.stroke_mm / 2
            radius = round((figure.radius_mm + half) * scale * 2**_SHIFT)
            if figure.stroke is None:
                if figure.fill is not None:
                    cv2.circle(fine, centre, radius, figure.fill, -1, cv2.LINE_8, _SHIFT)
            else:
                radius = round(figure.radius_mm * scale * 2**_SHIFT)
                width = max(round(figure.stroke_mm * scale), 1)
                cv2.circle(fine, centre, radius, figure.stroke, width, cv2.LINE_8, _SHIFT)
        case Polygon():
            points = np.array([_px(x, y, scale) for x, y in figure.points_mm], np.int32)
            cv2.fillPoly(fine, [points], figure.fill, cv2.LINE_8, _SHIFT)
        case Line():
            ends = _px(figure.x1_mm, figure.y1_mm, scale), _px(figure.x2_mm, figure.y2_mm, scale)
            width = max(round(figure.width_mm * scale), 1)
            cv2.line(fine, *ends, figure.colour, width, cv2.LINE_8, _SHIFT)
        case Text():
            _text(fine, figure, scale)


def _rectangle(fine: Picture, figure: Rectangle, scale: float) -> None:
    half = 0.0 if figure.stroke is None else figure.stroke_mm / 2
    x, y, wide, tall = figure.x_mm, figure.y_mm, figure.width_mm, figure.height_mm
    if figure.fill is not None:
        fine[_part(x, y, wide, tall, scale)] = figure.fill
    if figure.stroke is not None:
        width = figure.stroke_mm
        for part in (
            (x - half, y - half, wide + width, width),
            (x - half, y + tall - half, wide + width, width),
            (x - half, y - half, width, tall + width),
            (x + wide - half, y - half, width, tall + width),
        ):
            fine[_part(*part, scale)] = figure.stroke


def _part(x: float, y: float, wide: float, tall: float, scale: float) -> tuple[slice, slice]:
    edges = [max(round(v * scale), 0) for v in (y, y + tall, x, x + wide)]
    return slice(edges[0], edges[1]), slice(edges[2], edges[3])


def _text(fine: Picture, text: Text, scale: float) -> None:
    """Draw a line of text, stretched to the width that Helvetica has."""
    width_mm = text_width_mm(text.text, text.size_mm, bold=text.bold)
    size = CAPITAL_SHARE * text.size_mm * scale / _HERSHEY_CAPITAL_PX
    weight = max(round((0.14 if text.bold else 0.09) * text.size_mm * scale), 1)
    font = cv2.FONT_HERSHEY_SIMPLEX
    (wide, tall), below = cv2.getTextSize(text.text, font, size, weight)
    pad = weight + 1
    patch = np.zeros((tall + below + 2 * pad, max(wide, 1) + 2 * pad), np.uint8)
    cv2.putText(patch, text.text, (pad, tall + pad), font, size, 255, weight, cv2.LINE_8)
    across = max(round(width_mm * scale), 1)
    patch = np.asarray(
        cv2.resize(patch, (across + 2 * pad, patch.shape[0]), interpolation=cv2.INTER_AREA),
        np.uint8,
    )
    back = {"start": 0.0, "middle": 0.5, "end": 1.0}[text.anchor] * across
    if text.turned:
        patch = np.asarray(cv2.rotate(patch, cv2.ROTATE_90_COUNTERCLOCKWISE), np.uint8)
        left = round(text.x_mm * scale) - tall - pad
        top = round(text.y_mm * scale + back) - across - pad
    else:
        left = round(text.x_mm * scale - back) - pad
        top = round(text.y_mm * scale) - tall - pad
    _lay(fine, patch, left, top, text.colour)


def _lay(
    fine: Picture, patch: NDArray[np.uint8], left: int, top: int, colour: tuple[int, int, int]
) -> None:
    """Colour the pixels of a patch, as far as it lies on the picture."""
    x0, y0 = max(left, 0), max(top, 0)
    part = patch[y0 - top : fine.shape[0] - top, x0 - left : fine.shape[1] - left]
    if part.size:
        fine[y0 : y0 + part.shape[0], x0 : x0 + part.shape[1]][part > 127] = colour


def _px(x_mm: float, y_mm: float, scale: float) -> tuple[int, int]:
    """Return a point for OpenCV's drawing, whose whole numbers are middles of pixels."""
    one = 2**_SHIFT
    return round((x_mm * scale - 0.5) * one), round((y_mm * scale - 0.5) * one)
