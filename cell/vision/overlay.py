"""Pictures for people: what was recognised, how far points miss, what was covered."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.recognition import FoundBlock, Recognition, UnknownThing

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]
Rgb = tuple[int, int, int]

_LINE: Rgb = (0, 230, 255)
_DOUBT: Rgb = (255, 170, 0)
_UNKNOWN: Rgb = (255, 0, 160)
_INK: Rgb = (255, 255, 255)
_SHADE: Rgb = (0, 0, 0)
_SURE = 0.95
_HATCH_PX = 9
_SHIFT = 4


def draw_recognition(picture: Pixels, recognition: Recognition) -> Pixels:
    """Return a copy with outline, centre, direction, name and confidence of every block.

    Unknown things are hatched with their reason, and what was not looked at is darkened.
    """
    height, width = picture.shape[:2]
    seen = cv2.resize(recognition.area.mask, (width, height), interpolation=cv2.INTER_NEAREST)
    canvas = np.where(seen[..., None] > 0, picture, picture // 2).astype(np.uint8)
    for thing in recognition.unknown:
        _draw_unknown(canvas, thing)
    for block in recognition.blocks:
        _draw_block(canvas, block)
    return canvas


def draw_residuals(
    picture: Pixels, places_px: Points, misses_px: Points, *, enlarge: float = 50.0
) -> Pixels:
    """Return a copy with an arrow for each miss, enlarged, and a bar that tells the scale.

    Args:
        picture: R G B, (h, w, 3).
        places_px: Where the points are, (n, 2).
        misses_px: How far each was off, (n, 2).
        enlarge: How many times longer than life the arrows are.
    """
    canvas = np.asarray(picture.copy(), np.uint8)
    for place, miss in zip(places_px, misses_px, strict=True):
        start, end = _point(place), _point(place + enlarge * miss)
        cv2.arrowedLine(canvas, start, end, _UNKNOWN, 2, cv2.LINE_AA, 0, 0.25)
        cv2.circle(canvas, start, 3, _LINE, -1, cv2.LINE_AA)
    unit = _round_figure(60.0 / enlarge)
    y, x = canvas.shape[0] - 24, 24
    cv2.line(canvas, (x, y), (x + round(unit * enlarge), y), _INK, 3, cv2.LINE_AA)
    rms = float(np.sqrt(np.square(misses_px).sum(axis=1).mean())) if len(misses_px) else 0.0
    _write(canvas, f"{unit:g} px   rms {rms:.3f} px   {len(misses_px)} points", (x, y - 10))
    return canvas


def draw_coverage(
    size_px: tuple[int, int], places_px: Points, *, cells: tuple[int, int] = (8, 6)
) -> Pixels:
    """Return a map of how many points lie in each cell of a picture, dark where there are none.

    Args:
        size_px: Width and height of the picture.
        places_px: The points, (n, 2).
        cells: Columns and rows of the map.
    """
    width, height = size_px
    columns, rows = cells
    counts, _, _ = np.histogram2d(
        places_px[:, 1], places_px[:, 0], bins=(rows, columns), range=((0, height), (0, width))
    )
    share = counts / max(1.0, float(counts.max()))
    grown = cv2.resize(
        np.rint(255.0 * np.sqrt(share)).astype(np.uint8),
        (width, height),
        interpolation=cv2.INTER_NEAREST,
    )
    tinted = cv2.applyColorMap(np.asarray(grown, np.uint8), cv2.COLORMAP_VIRIDIS)
    canvas = np.asarray(cv2.cvtColor(tinted, cv2.COLOR_BGR2RGB), np.uint8)
    for row in range(rows):
        for column in range(columns):
            place = (int((column + 0.5) * width / columns) - 8, int((row + 0.5) * height / rows))
            _write(canvas, f"{counts[row, column]:.0f}", place)
    for place in places_px:
        cv2.circle(canvas, _point(place), 2, _INK, -1, cv2.LINE_AA)
    return canvas


def _draw_block(canvas: Pixels, block: FoundBlock) -> None:
    colour = _LINE if block.confidence >= _SURE else _DOUBT
    _polyline(canvas, block.outline_px, colour)
    middle = block.outline_px.mean(axis=0)
    cv2.drawMarker(canvas, _point(middle), colour, cv2.MARKER_CROSS, 14, 2, cv2.LINE_AA)
    if len(block.outline_px) == 4:
        # The corner order starts at the lower left of the block's own frame.
        ahead = (block.outline_px[1] + block.outline_px[2]) / 2.0
        cv2.arrowedLine(canvas, _point(middle), _point(ahead), colour, 2, cv2.LINE_AA, 0, 0.2)
    u, v = _point(block.outline_px.max(axis=0))
    _write(canvas, f"{block.colour} {block.kind}", (u + 3, v - 14))
    figures = f"{100 * block.confidence:.1f} %  {block.angle_deg:.1f} deg"
    _write(canvas, f"{figures}  +-{block.deviation_mm:.2f} mm", (u + 3, v + 2))


def _draw_unknown(canvas: Pixels, thing: UnknownThing) -> None:
    low = np.floor(thing.outline_px.min(axis=0)).astype(int)
    high = np.ceil(thing.outline_px.max(axis=0)).astype(int)
    inside = np.zeros(canvas.shape[:2], np.uint8)
    line = np.rint(thing.outline_px).astype(np.int32)
    cv2.fillPoly(inside, [line], 255)
    rows, columns = np.mgrid[: canvas.shape[0], : canvas.shape[1]]
    canvas[(inside > 0) & ((rows + columns) % _HATCH_PX < 2)] = _UNKNOWN
    _polyline(canvas, thing.outline_px, _UNKNOWN)
    _write(canvas, thing.reason, (int(low[0]), int(high[1]) + 14))


def _polyline(canvas: Pixels, outline_px: Points, colour: Rgb) -> None:
    line = np.rint(outline_px * (1 << _SHIFT)).astype(np.int32)
    cv2.polylines(canvas, [line], True, colour, 2, cv2.LINE_AA, _SHIFT)


def _write(canvas: Pixels, text: str, place: tuple[int, int]) -> None:
    for colour, width in ((_SHADE, 3), (_INK, 1)):
        cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, width, cv2.LINE_AA)


def _point(place: Points) -> tuple[int, int]:
    return round(float(place[0])), round(float(place[1]))


def _round_figure(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * 1.0001))
