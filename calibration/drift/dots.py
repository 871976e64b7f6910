"""Dots on the screen: where they are shown, and where a camera sees them.

The dots lie on a grid, each pushed aside by chance, so that no shift of the whole brings
them over one another. Some are hidden by blocks: those are left out, and so are blobs of
another size than a dot in that place has.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.screen.patterns import Panel

Points = NDArray[np.float64]

RADIUS_PX = 14
SPACING_PX = 96
"""Between two dots of the grid, in screen pixels: 44 mm, a block hides four at most."""

_JITTER_PX = 20
_SEED = 20
_MARGIN_PX = 40
_LEAST_LEVEL = 25.0
_BRIGHT_SHARE = 0.35
_FAINT_SHARE = 0.12
_LEAST_AREA_PX = 8
_VISIBLE_SHARE = 0.1
_VOTE_PX = 4.0
_FARTHEST_PX = 160.0
_REACH_PX = (8.0, 4.0, 2.5)
_AREA_SLACK = 0.3
_FEWEST_VOTES = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenDots:
    """Dots that a camera sees.

    Attributes:
        index: Which dots of `dot_places`, (n,).
        pixels: Where their centres appear, (n, 2).
        area_px: How many pixels each covers, (n,).
    """

    index: NDArray[np.int_]
    pixels: Points
    area_px: Points

    def __len__(self) -> int:
        return len(self.index)


@lru_cache(maxsize=4)
def dot_places(width_px: int, height_px: int) -> Points:
    """Return columns and rows (n, 2) of the dots' centres, whole numbers."""
    generator = np.random.default_rng(_SEED)
    u = np.arange(_MARGIN_PX + _JITTER_PX, width_px - _MARGIN_PX - _JITTER_PX, SPACING_PX)
    v = np.arange(_MARGIN_PX + _JITTER_PX, height_px - _MARGIN_PX - _JITTER_PX, SPACING_PX)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    places = grid + generator.integers(-_JITTER_PX, _JITTER_PX + 1, grid.shape)
    return np.asarray(places, np.float64)


def dots(panel: Panel) -> NDArray[np.uint8]:
    """Return the picture of the dots, bright on black."""
    pixels = panel.field(0)
    for column, row in dot_places(panel.width_px, panel.height_px).astype(int).tolist():
        cv2.circle(pixels, (column, row), RADIUS_PX, (panel.bright,) * 3, -1, cv2.LINE_AA)
    return pixels


def find_dots(
    lit: NDArray[np.uint8],
    dark: NDArray[np.uint8],
    expected_px: Points,
    expected_area_px: Points,
) -> SeenDots:
    """Return the dots that a camera sees.

    Args:
        lit: Picture (h, w, 3) with the dots on the screen.
        dark: The same with a black screen.
        expected_px: Where the dots of `dot_places` should appear, (n, 2).
        expected_area_px: How many pixels each should cover, (n,).
    """
    blobs, areas = _blobs(lit, dark, _VISIBLE_SHARE * float(expected_area_px.sum()))
    shift = _common_shift(expected_px, blobs)
    nothing = np.empty(0, np.int_)
    if shift is None:
        return SeenDots(index=nothing, pixels=np.empty((0, 2)), area_px=np.empty(0))
    moved = expected_px + shift
    dot, blob = nothing, nothing
    for reach_px in _REACH_PX:
        dot, blob = _nearest(moved, blobs, reach_px)
        ratio = areas[blob] / expected_area_px[dot]
        usual = float(np.median(ratio)) if len(ratio) else 1.0
        fits = np.abs(ratio / usual - 1.0) < _AREA_SLACK
        dot, blob = dot[fits], blob[fits]
        if len(dot) < _FEWEST_VOTES:
            break
        moved = expected_px + _smooth(expected_px[dot], blobs[blob] - expected_px[dot], expected_px)
    return SeenDots(index=dot, pixels=blobs[blob], area_px=areas[blob])


def _blobs(
    lit: NDArray[np.uint8], dark: NDArray[np.uint8], least_px: float
) -> tuple[Points, Points]:
    """Return centres (m, 2) and areas (m,) of what is brighter with the dots on.

    At least `least_px` pixels are taken to see dots whole: so many are as bright as the
    level that parts dots from the rest is reckoned from.
    """
    level = cv2.cvtColor(cv2.subtract(lit, dark), cv2.COLOR_RGB2GRAY)
    histogram = np.bincount(level.ravel(), minlength=256)
    brighter = np.cumsum(histogram[::-1])[::-1]
    peak = float(np.flatnonzero(brighter >= least_px)[-1])
    if peak < _LEAST_LEVEL:
        return np.empty((0, 2)), np.empty(0)
    bright = (level > _BRIGHT_SHARE * peak).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(bright, connectivity=8)
    sizes = stats[:, cv2.CC_STAT_AREA]
    keep = np.flatnonzero(sizes >= _LEAST_AREA_PX)
    keep = keep[keep > 0]
    grown = cv2.dilate(labels.astype(np.float32), np.ones((3, 3), np.uint8)).astype(np.int32)
    weight = np.maximum(level.astype(np.float64) - _FAINT_SHARE * peak, 0.0)
    rows, columns = np.nonzero(grown)
    label, weight = grown[rows, columns], weight[rows, columns]
    total, along, below = (
        np.bincount(label, k, minlength=count) for k in (weight, weight * columns, weight * rows)
    )
    centres = np.stack([along[keep] / total[keep], below[keep] / total[keep]], axis=1)
    return centres, sizes[keep].astype(np.float64)


def _common_shift(expected: Points, blobs: Points) -> Points | None:
    """Return the shift that brings most expected dots over a blob, None if none stands out."""
    if not len(blobs):
        return None
    apart = (blobs[None, :, :] - expected[:, None, :]).reshape(-1, 2)
    apart = apart[(np.abs(apart) < _FARTHEST_PX).all(axis=1)]
    edges = np.arange(-_FARTHEST_PX, _FARTHEST_PX + 1e-9, _VOTE_PX)
    votes, _, _ = np.histogram2d(apart[:, 0], apart[:, 1], bins=[edges, edges])
    around = np.asarray(
        cv2.boxFilter(votes, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    )
    column, row = np.unravel_index(int(around.argmax()), around.shape)
    middle = np.array([edges[column], edges[row]]) + 0.5 * _VOTE_PX
    near = apart[(np.abs(apart - middle) < 1.5 * _VOTE_PX).all(axis=1)]
    return np.median(near, axis=0) if len(near) >= _FEWEST_VOTES else None


def _nearest(
    expected: Points, blobs: Points, reach_px: float
) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Return dots and blobs that are each other's nearest, within reach."""
    apart = np.linalg.norm(expected[:, None, :] - blobs[None, :, :], axis=2)
    blob = apart.argmin(axis=1)
    dot = np.arange(len(expected))
    is_mutual = apart.argmin(axis=0)[blob] == dot
    good = is_mutual & (apart[dot, blob] < reach_px)
    return dot[good], blob[good]


def _smooth(at: Points, shifts: Points, wanted: Points) -> Points:
    """Return a shift that changes linearly over the picture, least absolute deviations."""
    middle, size = at.mean(axis=0), 500.0
    basis = np.column_stack([np.ones(len(at)), (at - middle) / size])
    weight = np.ones(len(at))
    solved = np.zeros((3, 2))
    for _ in range(8):
        root = np.sqrt(weight)[:, None]
        solved, *_ = np.linalg.lstsq(basis * root, shifts * root, rcond=None)
        off = np.linalg.norm(shifts - basis @ solved, axis=1)
        weight = 1.0 / np.maximum(off, 0.05)
    return np.asarray(np.column_stack([np.ones(len(wanted)), (wanted - middle) / size]) @ solved)
