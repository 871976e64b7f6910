"""Distances between upright boxes and thick segments, in plain floats."""

from __future__ import annotations

from math import sqrt
from typing import TypeAlias

from cell.kinematics import Point

Bounds: TypeAlias = tuple[float, float, float, float, float, float]
"""Low x, y, z and high x, y, z of an upright box, in mm."""

AXES = ("x", "y", "z")


def separations(bounds: Bounds, box: Bounds) -> Bounds:
    """Return by how much `bounds` lies beyond each face of `box`, negative inside.

    The order is high x, low x, high y, low y, high z, low z. The two are apart when
    any of the six is positive.
    """
    return (
        bounds[0] - box[3], box[0] - bounds[3],
        bounds[1] - box[4], box[1] - bounds[4],
        bounds[2] - box[5], box[2] - bounds[5],
    )  # fmt: skip


def segment_distance_mm(start: Point, end: Point, box: Bounds) -> float:
    """Return the distance of a segment from a solid box, 0 where it touches or enters.

    Along the segment the squared distance is convex and made of parabolas that meet
    where a coordinate passes a face; its least value is found on the parabola whose
    slope changes sign.
    """
    low, high = box[:3], box[3:]
    delta = tuple(e - s for s, e in zip(start, end, strict=True))
    cuts = [0.0, 1.0]
    for axis in range(3):
        if abs(delta[axis]) > 1e-12:
            for face in (low[axis], high[axis]):
                cut = (face - start[axis]) / delta[axis]
                if 0.0 < cut < 1.0:
                    cuts.append(cut)
    cuts.sort()
    best = min(_squared(start, delta, cut, low, high)[0] for cut in cuts)
    for first, last in zip(cuts, cuts[1:], strict=False):
        middle = 0.5 * (first + last)
        _, slope, bend = _squared(start, delta, middle, low, high)
        if bend > 0.0:
            least = min(max(middle - slope / bend, first), last)
            best = min(best, _squared(start, delta, least, low, high)[0])
    return sqrt(best)


def _squared(
    start: Point,
    delta: tuple[float, ...],
    t: float,
    low: tuple[float, ...],
    high: tuple[float, ...],
) -> tuple[float, float, float]:
    """Return squared distance at t with its first and second derivative."""
    square = slope = bend = 0.0
    for axis in range(3):
        at = start[axis] + t * delta[axis]
        beyond = at - high[axis] if at > high[axis] else at - low[axis] if at < low[axis] else 0.0
        if beyond:
            square += beyond * beyond
            slope += 2.0 * beyond * delta[axis]
            bend += 2.0 * delta[axis] * delta[axis]
    return square, slope, bend
