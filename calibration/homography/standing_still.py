"""Tells whether a camera stood still while pairs were taken.

What does not move between two pictures is everything but the object: the screen's edge, the
table, the store. The shift that brings one picture over the other is found by phase
correlation, then by Gauss-Newton on the grey values (Lucas and Kanade 1981), with the places
of the object in both left out. Correlation has wrong peaks too: a shift is believed only if
undoing it really makes the pictures alike, in the whole and in most of their parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.homography.sampling import Pair
from calibration.verdict import Finding, Grade

Grey = NDArray[np.float32]
Points = NDArray[np.float64]

SEEN_PX: Final = 0.4
"""Shifts below this are not told from noise, shadows and the object's light."""

_BAD_PX: Final = 1.0
_REALLY_LESS: Final = 0.5
"""Share of the squared difference that may be left once a shift is undone."""

_TILES: Final = (6, 8)
_MOST_TILES: Final = 0.5
_TELLING: Final = 1.0
"""Mean squared difference, in grey levels squared, from which a tile has a say."""

_AROUND: Final = 3.0
_STEPS: Final = 12
_DONE_PX: Final = 0.005
_LEAST_SLOPE: Final = 0.05
"""Mean square slope, in (grey levels a px)^2, below which a direction is not seen."""


def judge_camera(pairs: Sequence[Pair]) -> tuple[Finding, ...]:
    """Return whether the camera moved between the first pair and a later one."""
    seen = [pair for pair in pairs if pair.still is not None]
    if len(seen) < 2 or seen[0].still is None:
        return ()
    first = seen[0]
    for before, pair in zip(seen, seen[1:], strict=False):
        shift = shift_between(first, pair)
        if shift is None:
            continue
        length = float(np.hypot(*shift))
        if length > SEEN_PX:
            return (
                Finding(
                    code="camera-moved",
                    grade=Grade.BAD if length > _BAD_PX else Grade.DEGRADED,
                    text=f"between {before.label} and {pair.label} the camera moved: everything "
                    f"that stands still is seen {length:.1f} px ({shift[0]:+.1f}, {shift[1]:+.1f})"
                    " from where it was",
                    hint="tighten its mount, keep off the frame while it measures, and calibrate "
                    "again",
                    samples=tuple(one.label for one in seen[seen.index(pair) :]),
                ),
            )
    return ()


def shift_between(first: Pair, later: Pair) -> Points | None:
    """Return by how many px (u, v) the fixed scene of a later picture lies elsewhere.

    In a direction in which nothing of it has an edge the shift is 0, and so it is where no
    shift makes the pictures alike. None where there is no picture, or nothing fixed in it.
    """
    if first.still is None or later.still is None or first.still.shape != later.still.shape:
        return None
    one, other = _smooth(first.still), _smooth(later.still)
    weight = _without_object(one.shape, (first, later), first.still_scale)
    window = cv2.createHanningWindow(one.shape[::-1], cv2.CV_32F) * weight
    peak, _ = cv2.phaseCorrelate(_slopes(one) * window, _slopes(other) * window)
    tried = [_refined(one, other, weight, np.array(start)) for start in (peak, (0.0, 0.0))]
    shifts = [shift for shift in tried if shift is not None and np.isfinite(shift).all()]
    if not shifts:
        return None
    sure = [shift for shift in shifts if _is_confirmed(one, other, weight, shift)]
    if not sure:
        return np.zeros(2)
    best = min(sure, key=lambda shift: float(_differences(one, other, weight, shift)[0].mean()))
    return best * first.still_scale


def _is_confirmed(one: Grey, other: Grey, weight: Grey, shift: Points) -> bool:
    """Tell whether undoing a shift makes the pictures alike, in the whole and in most tiles."""
    left, seen = _differences(one, other, weight, shift)
    was = np.where(seen, weight * (other - one) ** 2, 0.0)
    if float(left.sum()) > _REALLY_LESS * float(was.sum()):
        return False
    before, after = _tiled(was), _tiled(left)
    has_say = (np.maximum(before, after) > _TELLING) & (_tiled(weight * seen) > 0.5)
    if not has_say.any():
        return True
    agree = after[has_say] <= _REALLY_LESS * before[has_say]
    return float(agree.mean()) > _MOST_TILES


def _differences(
    one: Grey, other: Grey, weight: Grey, shift: Points
) -> tuple[Points, NDArray[np.bool_]]:
    """Return squared differences once a shift is undone, and which pixels both pictures show."""
    seen = _moved(np.ones_like(weight), shift, cv2.BORDER_CONSTANT) > 0.99
    miss = _moved(other, shift, cv2.BORDER_REPLICATE) - one
    return np.where(seen, weight * miss**2, 0.0), seen


def _tiled(values: NDArray[np.floating]) -> Points:
    """Return the mean of each tile."""
    tiles = cv2.resize(np.asarray(values, np.float64), _TILES[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(tiles, np.float64)


def _moved(grey: Grey, shift: Points, border: int) -> Grey:
    back = np.array([[1.0, 0.0, shift[0]], [0.0, 1.0, shift[1]]])
    moved = cv2.warpAffine(
        grey, back, grey.shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=border,
    )  # fmt: skip
    return np.asarray(moved, np.float32)


def _smooth(grey: Grey) -> Grey:
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), 1.5), np.float32)


def _slopes(grey: Grey) -> Grey:
    across, down = (cv2.Sobel(grey, cv2.CV_32F, *axes, scale=0.125) for axes in ((1, 0), (0, 1)))
    return np.asarray(cv2.magnitude(across, down), np.float32)


def _without_object(shape: tuple[int, ...], pairs: tuple[Pair, Pair], scale: float) -> Grey:
    """Return 1 where neither picture shows the object, its side or its shadow."""
    weight = np.ones(shape, np.float32)
    for pair in pairs:
        radius_px = pair.seen.radius_px if pair.seen is not None else 0.0
        centre = (round(pair.pixel[0] / scale), round(pair.pixel[1] / scale))
        cv2.circle(weight, centre, round(_AROUND * radius_px / scale), 0.0, -1)
    return weight


def _refined(one: Grey, other: Grey, weight: Grey, start: Points) -> Points | None:
    across, down = (cv2.Sobel(one, cv2.CV_32F, *axes, scale=0.125) for axes in ((1, 0), (0, 1)))
    slopes = np.stack([across, down]) * weight
    square = np.einsum("ahw,bhw->ab", slopes, slopes, dtype=np.float64)
    strength, axes = np.linalg.eigh(square / float(weight.sum()))
    is_seen = strength > _LEAST_SLOPE
    if not is_seen.any():
        return None
    inverse = (axes[:, is_seen] / strength[is_seen]) @ axes[:, is_seen].T / float(weight.sum())
    shift = axes[:, is_seen] @ (axes[:, is_seen].T @ start)
    for _ in range(_STEPS):
        moved = _moved(other, shift, cv2.BORDER_REPLICATE)
        step = -inverse @ np.einsum("ahw,hw->a", slopes, moved - one, dtype=np.float64)
        shift = shift + step
        if float(np.hypot(*step)) < _DONE_PX:
            break
    return shift
