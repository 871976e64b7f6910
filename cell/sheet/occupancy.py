"""Which slots have a block, by the colours at them; best effort, and unknown where unsure.

An empty slot is white inside, whatever its colour. A ray to the middle of a slot meets its
block if there is one, from wherever the camera looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cell.geometry import TableView
from cell.sheet.finding import Pixels
from cell.sheet.layout import PrintedSlot, SheetLayout
from cell.sheet.placing import Points, SheetPlace
from cell.vision.tables import COLOURS

SlotState = Literal["empty", "occupied", "not known", "not in view"]

_DISC_MM = 8.0
_WHITE_LEAST = 0.72
_WHITE_CHROMA = 0.15
_PAINT_CHROMA = 0.2
_COLOUR_REACH = 0.12
_EDGE_PX = 2.0
_SHADES: Final = {
    one.colour: (one.red.low + one.red.high, one.green.low + one.green.high,
                 one.blue.low + one.blue.high)
    for one in COLOURS
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SlotReading:
    """What a picture tells of a slot.

    Attributes:
        number: Number of the slot.
        state: Whether something stands there.
        colour: Colour of what stands there; empty where that is not known.
        is_right: Whether it has the slot's colour; None where that is not known.
    """

    number: int
    state: SlotState
    colour: str = ""
    is_right: bool | None = None


def read_slots(
    pixels: Pixels,
    view: TableView,
    place: SheetPlace,
    layout: SheetLayout,
    *,
    surface_mm: float,
    seen: Sequence[int],
    hidden: Pixels | None = None,
) -> tuple[SlotReading, ...]:
    """Return what a picture tells of every slot.

    Args:
        pixels: The picture, (h, w, 3).
        view: Where it lies in the robot frame.
        place: Where the sheet lies.
        layout: What is printed where.
        surface_mm: Height of the sheet.
        seen: Indices of the markers found in this picture, around which the paper is white.
        hidden: Above 0 where the arm or its fingers may hide the table, (h, w).
    """
    whites = {
        (one.x_mm, one.y_mm): _white(pixels, view, place, one.corners_mm, surface_mm)
        for one in layout.fiducials
        if one.index in seen
    }
    if not whites:
        return tuple(SlotReading(number=s.slot.number, state="not known") for s in layout.slots)
    return tuple(
        _read_slot(pixels, view, place, one, surface_mm, _nearest(whites, one), hidden)
        for one in layout.slots
    )


def merged(readings: Sequence[tuple[SlotReading, ...]]) -> tuple[SlotReading, ...]:
    """Return what several pictures tell together; where they disagree, nothing is known."""
    merged_slots = []
    for of_one in zip(*readings, strict=True):
        known = [one for one in of_one if one.state in ("empty", "occupied")]
        states = {one.state for one in known}
        if len(states) == 1:
            best = max(known, key=lambda one: one.is_right is not None)
            colours = {one.colour for one in known if one.colour}
            if len(colours) > 1:
                best = SlotReading(number=best.number, state=best.state)
            merged_slots.append(best)
        elif len(states) > 1:
            merged_slots.append(SlotReading(number=of_one[0].number, state="not known"))
        else:
            doubtful = [one for one in of_one if one.state == "not known"]
            merged_slots.append(doubtful[0] if doubtful else of_one[0])
    return tuple(merged_slots)


def _read_slot(
    pixels: Pixels,
    view: TableView,
    place: SheetPlace,
    printed: PrintedSlot,
    surface_mm: float,
    white: NDArray[np.float64],
    hidden: Pixels | None,
) -> SlotReading:
    number = printed.slot.number
    middle = np.array([printed.slot.x_mm, printed.slot.y_mm])
    if hidden is not None:
        low_px = view.to_picture(place.to_robot(middle + _disc()), surface_mm)
        if _sampled(hidden, low_px).any():
            return SlotReading(number=number, state="not known")
    low = _shade(pixels, view, place.to_robot(middle + _disc()), surface_mm)
    if low is None:
        return SlotReading(number=number, state="not in view")
    share = low / white
    chroma = float((share.max() - share.min()) / max(share.max(), 1e-6))
    if share.min() > _WHITE_LEAST and chroma < _WHITE_CHROMA:
        return SlotReading(number=number, state="empty")
    top_mm = surface_mm + printed.size.height_mm
    try:
        top = _shade(pixels, view, place.to_robot(middle + _disc()), top_mm)
    except ValueError:
        # A plain homography knows one height alone.
        top = None
    colour = "" if top is None else _colour(top / white)
    if chroma < _PAINT_CHROMA:
        # Grey is no block's paint: fingers, a shadow, or something that was left there.
        return SlotReading(number=number, state="not known")
    is_right = colour == printed.slot.colour if colour else None
    return SlotReading(number=number, state="occupied", colour=colour, is_right=is_right)


def _colour(share: NDArray[np.float64]) -> str:
    """Return the paint that light from a block's top is of; empty where it may be another."""
    hue = share / max(float(share.sum()), 1e-6)
    distances = sorted(
        (float(np.linalg.norm(hue - np.array(shade) / sum(shade))), colour)
        for colour, shade in _SHADES.items()
    )
    (nearest, colour), (second, _) = distances[0], distances[1]
    return colour if nearest < _COLOUR_REACH and second > 1.5 * nearest else ""


def _white(
    pixels: Pixels,
    view: TableView,
    place: SheetPlace,
    corners: Sequence[tuple[float, float]],
    surface_mm: float,
) -> NDArray[np.float64]:
    """Return the light of the paper just beside a marker."""
    square = np.array(corners)
    middle = square.mean(axis=0)
    ring = middle + (square - middle) * 1.14
    steps = np.linspace(0.0, 1.0, 9)[:-1, None]
    turned = np.roll(ring, -1, axis=0)
    path = (ring[:, None, :] + (turned - ring)[:, None, :] * steps).reshape(-1, 2)
    shade = _sampled(pixels, view.to_picture(place.to_robot(path), surface_mm))
    return np.maximum(np.median(shade, axis=0), 1.0)


def _nearest(
    whites: dict[tuple[float, float], NDArray[np.float64]], printed: PrintedSlot
) -> NDArray[np.float64]:
    x, y = printed.slot.x_mm, printed.slot.y_mm
    return whites[min(whites, key=lambda at: (at[0] - x) ** 2 + (at[1] - y) ** 2)]


def _shade(
    pixels: Pixels, view: TableView, points_mm: Points, height_mm: float
) -> NDArray[np.float64] | None:
    """Return the median light at points, None if one of them is not in the picture."""
    places = view.to_picture(points_mm, height_mm)
    height, width = pixels.shape[:2]
    inside = (places >= _EDGE_PX) & (places <= np.array([width, height]) - 1 - _EDGE_PX)
    if not inside.all():
        return None
    return np.asarray(np.median(_sampled(pixels, places), axis=0), np.float64)


def _sampled(pixels: Pixels, places: Points) -> NDArray[np.float64]:
    height, width = pixels.shape[:2]
    columns = np.clip(np.rint(places[..., 0]).astype(int), 0, width - 1)
    rows = np.clip(np.rint(places[..., 1]).astype(int), 0, height - 1)
    return np.asarray(pixels[rows, columns], np.float64)


def _disc() -> Points:
    """Return offsets (n, 2) of points spread over a disc."""
    steps = np.linspace(-1.0, 1.0, 9)
    x, y = np.meshgrid(steps, steps)
    inside = x * x + y * y <= 1.0
    return np.stack([x[inside], y[inside]], axis=-1) * _DISC_MM
