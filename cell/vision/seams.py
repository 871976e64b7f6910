"""In which order blocks lie that are flush in one row: told by their seams, or not at all.

A bridge and a cube of one colour, end to end, have the outline of a cube and a bridge. Only
the seam between them tells the orders apart. When no order's seams are clearly better seen
than those of every other, the row is ambiguous.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.tiling import Placement

Points = NDArray[np.float64]

_ALIGNED_RAD = math.radians(4.0)
_ASIDE_MM = 1.5
_APART_MM = 2.5
_LEAST_MARGIN_LEVELS = 2.0
_REACH_MM = 4.0
_STEP_MM = 0.4
_SEAM_MM = 1.2
_ACROSS = 25
_ACROSS_SHARE = 0.7
_MOST_IN_ROW = 5


@dataclass(frozen=True, slots=True, eq=False)
class _Box:
    """A placement along a row: its middle and length there."""

    index: int
    middle_mm: float
    length_mm: float


def in_seen_order(
    placements: Sequence[Placement], picture: NDArray[np.uint8], px_from_mm: Points
) -> list[Placement] | None:
    """Return the placements with flush rows in the order that their seams tell.

    Args:
        placements: Faces that tile one patch.
        picture: R G B (h, w, 3).
        px_from_mm: Affine map (2, 3) from robot mm at the block tops, good around the patch.

    Returns:
        The placements, None when the order of a row cannot be told.
    """
    placed = list(placements)
    for row, angle_rad in _rows(placements):
        lengths = [box.length_mm for box in row]
        first = placed[row[0].index]
        half_width = 0.5 * _size_across(first, angle_rad)
        along = np.array([math.cos(angle_rad), math.sin(angle_rad)])
        base = np.array([first.x_mm, first.y_mm]) - along * row[0].middle_mm
        start = row[0].middle_mm - 0.5 * lengths[0]

        def seen(at_mm: float, *, base: Points = base, along: Points = along,
                 half: float = half_width) -> float:  # fmt: skip
            return _seam_levels(picture, px_from_mm, base + at_mm * along, along, half)

        best = _best_order(lengths, start, seen)
        if best is None:
            return None
        offset = start
        for k in best:
            box = row[k]
            shift = offset + 0.5 * box.length_mm - box.middle_mm
            one = placed[box.index]
            placed[box.index] = replace(
                one, x_mm=one.x_mm + shift * along[0], y_mm=one.y_mm + shift * along[1]
            )
            offset += box.length_mm
    return placed


def _best_order(
    lengths: Sequence[float], start: float, seen: Callable[[float], float]
) -> tuple[int, ...] | None:
    """Return the order of boxes whose seams are seen best, None when two are seen alike."""
    orders = {
        tuple(round(lengths[k]) for k in order): order
        for order in reversed(list(itertools.permutations(range(len(lengths)))))
    }
    places = {
        order: [start + sum(lengths[k] for k in order[:n]) for n in range(1, len(order))]
        for order in orders.values()
    }
    levels = {round(at): seen(at) for seams in places.values() for at in seams}
    # All orders have as many seams: a sum compares them fairly.
    scores = sorted(
        ((sum(levels[round(at)] for at in seams), order) for order, seams in places.items()),
        reverse=True,
    )
    if len(scores) > 1 and scores[0][0] - scores[1][0] < _LEAST_MARGIN_LEVELS:
        return None
    return scores[0][1]


def _rows(placements: Sequence[Placement]) -> Iterator[tuple[list[_Box], float]]:
    """Yield boxes that lie flush, end to end, and are not all of one length; and the direction."""
    seen: set[frozenset[int]] = set()
    for one in placements:
        if one.shape.is_round:
            continue
        for angle_rad in (one.angle_rad, one.angle_rad + math.pi / 2.0):
            row = _row_of(one, angle_rad, placements)
            members = frozenset(box.index for box in row)
            lengths = {round(box.length_mm) for box in row}
            if 2 <= len(row) <= _MOST_IN_ROW and len(lengths) > 1 and members not in seen:
                seen.add(members)
                yield row, angle_rad


def _row_of(one: Placement, angle_rad: float, placements: Sequence[Placement]) -> list[_Box]:
    along = np.array([math.cos(angle_rad), math.sin(angle_rad)])
    aside = np.array([-along[1], along[0]])
    aligned = []
    for index, other in enumerate(placements):
        turn = (other.angle_rad - angle_rad + math.pi / 4.0) % (math.pi / 2.0) - math.pi / 4.0
        if other.shape.is_round or abs(turn) > _ALIGNED_RAD:
            continue
        off = np.array([other.x_mm - one.x_mm, other.y_mm - one.y_mm])
        widths = _size_across(one, angle_rad), _size_across(other, angle_rad)
        if abs(off @ aside) < _ASIDE_MM and abs(widths[0] - widths[1]) < _ASIDE_MM:
            length = _size_across(other, angle_rad + math.pi / 2.0)
            aligned.append(_Box(index, float(off @ along), length))
    aligned.sort(key=lambda box: box.middle_mm)
    at = next(k for k, box in enumerate(aligned) if placements[box.index] is one)
    low = high = at
    while low > 0 and _gap(aligned[low - 1], aligned[low]) < _APART_MM:
        low -= 1
    while high + 1 < len(aligned) and _gap(aligned[high], aligned[high + 1]) < _APART_MM:
        high += 1
    return aligned[low : high + 1]


def _gap(before: _Box, after: _Box) -> float:
    return after.middle_mm - before.middle_mm - 0.5 * (before.length_mm + after.length_mm)


def _size_across(one: Placement, angle_rad: float) -> float:
    """Return a box's size square to a direction that one of its sides has."""
    is_along = abs(math.cos(one.angle_rad - angle_rad)) > math.sqrt(0.5)
    return one.shape.width_mm if is_along else one.shape.length_mm


def _seam_levels(
    picture: NDArray[np.uint8], px_from_mm: Points, middle: Points, along: Points, half_mm: float
) -> float:
    """Return how far the colour on a line across a row is from that around it, grey levels."""
    offsets = np.arange(-_REACH_MM, _REACH_MM + _STEP_MM / 2.0, _STEP_MM)
    shares = np.linspace(-_ACROSS_SHARE, _ACROSS_SHARE, _ACROSS) * half_mm
    aside = np.array([-along[1], along[0]])
    points = middle + offsets[:, None, None] * along + shares[:, None] * aside
    places = points @ px_from_mm[:, :2].T + px_from_mm[:, 2]
    values = cv2.remap(  # type: ignore[call-overload]
        picture, places.astype(np.float32), None, cv2.INTER_LINEAR
    )
    profile = np.asarray(values, np.float64).mean(axis=1)
    is_near = np.abs(offsets) <= _SEAM_MM
    around = np.median(profile[~is_near], axis=0)
    return float(np.abs(profile[is_near] - around).max())
