"""Which blocks make up a patch of one colour: the known faces must tile it.

A single face is told by its bounding rectangle or circle. A patch of several blocks of one
colour that touch is searched: faces are tried with a side along each straight piece of the
outline and a corner at its end, discs where the patch is wide enough; what is placed is
taken away, until too little is left for another face. When what is left is too much, the
patch is not explained, and nobody guesses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.sight import KindShape, turned

Points = NDArray[np.float64]
Mask = NDArray[np.uint8]

_SIDE_SLACK_MM = 3.0
_FILL_SLACK = 0.11
_LEAST_ROUGH_INSIDE = 0.84
_LEAST_INSIDE = 0.92
_MOST_LEFT_SHARE = 0.10
_GOOD_SHARE = 0.035
_FACE_COST_MM2 = 20.0
_LEAST_RIM = 0.3
_LEAST_DISC_RIM = 0.62
_STRAIGHT_MM = 9.0
_BEND_MM = 1.7
_ROUGHNESS = 1.5
_MOST_CORNERS = 40
_CORNER_SLACK_MM = 2.2
_GRID_MM = 2.5
_INNER_MM = 1.2
_MOST_NODES = 30
_MOST_BRANCHES = 3
_MOST_REFINED = 10
_MOST_MOVED_MM = 3.5
_LEAST_DISC_SUPPORT = 0.7
_LEAST_BOX_SUPPORT = 0.3
# Round: a square would cut the corners of turned blocks off.
_SLIVER = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """A face where it may lie.

    Attributes:
        shape: Whose face.
        x_mm: Its middle in the frame of the patch's outline.
        y_mm: Its middle.
        angle_rad: Direction of its length.
        fit: How well it covers and is covered, 0..1.
    """

    shape: KindShape
    x_mm: float
    y_mm: float
    angle_rad: float
    fit: float


Refine = Callable[[Sequence[Placement]], Sequence[tuple[Placement, float]]]
"""Lays faces, in the outline's frame, exactly on their edges: each with its edge support."""


def single_faces(
    outline_mm: Points, grown_mm: float, kinds: Sequence[KindShape]
) -> list[Placement]:
    """Return the faces that an outline may be of when it is of one, the likeliest first.

    Args:
        outline_mm: The outline at the block tops, (n, 2).
        grown_mm: How far the true edge lies outside of it.
        kinds: The faces there are.
    """
    points = outline_mm.astype(np.float32)
    (x, y), (first, second), angle = cv2.minAreaRect(points)
    first, second = first + 2.0 * grown_mm, second + 2.0 * grown_mm
    perimeter = cv2.arcLength(points, True)
    area = cv2.contourArea(points) + grown_mm * perimeter
    long, short = max(first, second), min(first, second)
    turn = math.radians(angle if first >= second else angle + 90.0)
    found = []
    for shape in kinds:
        off = max(abs(long - shape.length_mm), abs(short - shape.width_mm))
        miss = abs(area / (long * short) - (math.pi / 4.0 if shape.is_round else 1.0))
        if off < _SIDE_SLACK_MM and miss < _FILL_SLACK:
            fit = 1.0 - miss - 0.03 * off
            found.append(Placement(shape=shape, x_mm=x, y_mm=y, angle_rad=turn, fit=fit))
    return sorted(found, key=lambda one: -one.fit)


def may_be_blocks(outline_mm: Points, kinds: Sequence[KindShape]) -> bool:
    """Return whether an outline is as smooth as that of blocks that touch can be.

    However blocks are joined, the patch has no more outline for its area than the thinnest
    of them alone.
    """
    points = outline_mm.astype(np.float32)
    area = cv2.contourArea(points)
    most = max(4.0 / min(kind.length_mm, kind.width_mm) for kind in kinds)
    return bool(area > 0.0 and cv2.arcLength(points, True) < _ROUGHNESS * most * area)


def tile(
    outline_mm: Points, grown_mm: float, kinds: Sequence[KindShape], refine: Refine
) -> list[Placement] | None:
    """Return the faces that tile an outline, None when no set of them does.

    Args:
        outline_mm: The outline at the block tops, (n, 2).
        grown_mm: How far the true edge lies outside of it.
        kinds: The faces there are.
        refine: Lays faces exactly on their edges in the picture.
    """
    corner = outline_mm.min(axis=0) - 6.0
    size = np.ceil(outline_mm.max(axis=0) - corner + 6.0).astype(int)
    region = np.zeros((int(size[1]), int(size[0])), np.uint8)
    line = np.rint((outline_mm - corner) * 16.0).astype(np.int32)
    cv2.fillPoly(region, [line], 255, cv2.LINE_8, 4)
    cv2.polylines(region, [line], True, 255, max(1, round(2.0 * grown_mm)), cv2.LINE_8, 4)
    shift = (float(corner[0]), float(corner[1]))
    search = _Search(kinds, float(cv2.countNonZero(region)), refine, shift)
    found = search.solve(region)
    if found is None:
        return None
    return [
        Placement(
            shape=one.shape,
            x_mm=one.x_mm + float(corner[0]),
            y_mm=one.y_mm + float(corner[1]),
            angle_rad=one.angle_rad,
            fit=one.fit,
        )
        for one in found
    ]


class _Search:
    """Depth first, the most certain face first, within a bounded number of steps.

    Of all sets of faces that leave too little for another face, the one counts that leaves
    least of the patch uncovered; each face more has to earn its place.
    """

    def __init__(
        self,
        kinds: Sequence[KindShape],
        area_mm2: float,
        refine: Refine,
        shift_mm: tuple[float, float],
    ) -> None:
        self._kinds = kinds
        self._refine = refine
        self._shift = shift_mm
        self._least = min(kind.area_mm2 for kind in kinds)
        self._area = area_mm2
        self._nodes = 0
        self._best: list[Placement] | None = None
        self._best_cost = math.inf

    def solve(self, region: Mask) -> list[Placement] | None:
        """Return the placements that leave next to nothing of a region."""
        self._descend(region, [])
        return self._best

    def _descend(self, region: Mask, placed: list[Placement]) -> None:
        self._nodes += 1
        left_mm2 = float(cv2.countNonZero(region))
        cost = left_mm2 + _FACE_COST_MM2 * len(placed)
        if placed and left_mm2 < _MOST_LEFT_SHARE * self._area and cost < self._best_cost:
            self._best, self._best_cost = placed, cost
        is_done = self._best_cost < _GOOD_SHARE * self._area + _FACE_COST_MM2 * len(placed)
        if self._nodes > _MOST_NODES or is_done or left_mm2 < 0.5 * self._least:
            return
        left = cv2.morphologyEx(region, cv2.MORPH_OPEN, _SLIVER)
        tried = sorted(self._candidates(np.asarray(left, np.uint8)), key=lambda one: -one.fit)
        for one in self._exact(region, _distinct(tried)):
            rest = region.copy()
            outline = turned(one.shape.outline_mm, one.angle_rad) + (one.x_mm, one.y_mm)
            line = np.rint(outline * 16.0).astype(np.int32)
            cv2.fillConvexPoly(rest, line, 0, cv2.LINE_8, 4)
            self._descend(rest, [*placed, one])

    def _exact(self, region: Mask, rough: Sequence[Placement]) -> list[Placement]:
        """Return the best placements, laid on their edges, the best first."""
        x, y = self._shift
        moved = [replace(one, x_mm=one.x_mm + x, y_mm=one.y_mm + y) for one in rough]
        kept = []
        for one, (exact, support) in zip(rough, self._refine(moved), strict=True):
            here = replace(exact, x_mm=exact.x_mm - x, y_mm=exact.y_mm - y)
            if math.hypot(here.x_mm - one.x_mm, here.y_mm - one.y_mm) > _MOST_MOVED_MM:
                continue
            inner, _ = _samples(one.shape)
            place = np.array([here.x_mm, here.y_mm])
            inside = _looked_up(region, turned(inner, here.angle_rad) + place) > 0
            share = float(inside.mean())
            least = _LEAST_DISC_SUPPORT if one.shape.is_round else _LEAST_BOX_SUPPORT
            if share < _LEAST_INSIDE or support < least:
                continue
            bonus = 0.05 * one.shape.area_mm2 / max(kind.area_mm2 for kind in self._kinds)
            kept.append(replace(here, fit=0.4 * share + 0.6 * support + bonus))
        return _distinct(sorted(kept, key=lambda one: -one.fit))[:_MOST_BRANCHES]

    def _candidates(self, region: Mask) -> Iterator[Placement]:
        contours, _ = cv2.findContours(region, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        blurred = cv2.distanceTransform(cv2.bitwise_not(_rim(region)), cv2.DIST_L2, 3)
        for contour in contours:
            if cv2.contourArea(contour) < 0.5 * min(kind.area_mm2 for kind in self._kinds):
                continue
            polygon = _straightened(np.asarray(contour, np.int32).reshape(-1, 2))
            yield from self._flush(region, np.asarray(blurred), polygon)
        yield from self._discs(region, np.asarray(blurred))

    def _flush(
        self, region: Mask, to_rim: NDArray[np.float32], polygon: Points
    ) -> Iterator[Placement]:
        """Yield boxes with a side along a piece of the outline and a corner at its end."""
        ends = np.roll(polygon, -1, axis=0)
        lengths = np.linalg.norm(ends - polygon, axis=1)
        if len(polygon) > _MOST_CORNERS or not (lengths > _STRAIGHT_MM).any():
            return
        kept = lengths > _STRAIGHT_MM
        starts, ends = polygon[kept], ends[kept]
        along = (ends - starts) / lengths[kept, None]
        inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
        angles = np.arctan2(along[:, 1], along[:, 0])
        for shape in self._kinds:
            if shape.is_round:
                continue
            sizes = {(shape.length_mm, shape.width_mm), (shape.width_mm, shape.length_mm)}
            for x, y in sizes:
                turns = angles if x == shape.length_mm else angles + math.pi / 2.0
                middles = [
                    origin + sign * along * x / 2.0 + side * inward * y / 2.0
                    for origin, sign in ((starts, 1.0), (ends, -1.0))
                    for side in (1.0, -1.0)
                ]
                yield from self._judged(
                    region, to_rim, shape, np.concatenate(middles), np.tile(turns, 4)
                )

    def _discs(self, region: Mask, to_rim: NDArray[np.float32]) -> Iterator[Placement]:
        depth = np.asarray(cv2.distanceTransform(region, cv2.DIST_L2, 5))
        for shape in self._kinds:
            if not shape.is_round:
                continue
            radius = shape.length_mm / 2.0
            wide = (depth > radius - _CORNER_SLACK_MM).astype(np.uint8)
            count, _, _, middles = cv2.connectedComponentsWithStats(wide)
            if count > 1:
                found = np.asarray(middles[1:count], np.float64)
                yield from self._judged(region, to_rim, shape, found, np.zeros(count - 1))

    def _judged(
        self,
        region: Mask,
        to_rim: NDArray[np.float32],
        shape: KindShape,
        middles: Points,
        angles_rad: Points,
    ) -> Iterator[Placement]:
        """Yield the faces at places (n, 2) and angles (n,) that fit in roughly."""
        inner, rim = _samples(shape)
        cos, sin = np.cos(angles_rad)[:, None], np.sin(angles_rad)[:, None]

        def placed(local: Points) -> Points:
            x, y = local[:, 0], local[:, 1]
            both = np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)
            return np.asarray(both + middles[:, None])

        shares = (_looked_up(region, placed(inner)) > 0).mean(axis=1)
        outlines = (_looked_up(to_rim, placed(rim)) < _CORNER_SLACK_MM).mean(axis=1)
        least = _LEAST_DISC_RIM if shape.is_round else _LEAST_RIM
        # A large face that fits explains more than a small one that fits as well.
        bonus = 0.05 * shape.area_mm2 / max(kind.area_mm2 for kind in self._kinds)
        for k in np.flatnonzero((shares > _LEAST_ROUGH_INSIDE) & (outlines > least)).tolist():
            yield Placement(
                shape=shape,
                x_mm=float(middles[k, 0]),
                y_mm=float(middles[k, 1]),
                angle_rad=float(angles_rad[k]),
                fit=0.5 * float(shares[k]) + 0.5 * float(outlines[k]) + bonus,
            )


def _straightened(contour: NDArray[np.int32]) -> Points:
    """Return the corners (n, 2) of an outline: where lines fitted to its pieces cross."""
    rough = np.asarray(cv2.approxPolyDP(contour[:, None], _BEND_MM, True)).reshape(-1, 2)
    count, size = len(rough), len(contour)
    if count < 3:
        return rough.astype(np.float64)
    at = [int(np.flatnonzero((contour == corner).all(axis=1))[0]) for corner in rough]
    lines = []
    for here, after in zip(at, at[1:] + at[:1], strict=True):
        steps = (after - here) % size
        trim = min(3, steps // 4)
        piece = contour[(here + trim + np.arange(max(2, steps - 2 * trim + 1))) % size]
        u, v, x, y = np.asarray(
            cv2.fitLine(piece.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01), np.float64
        ).ravel()
        lines.append((np.array([-v, u]), v * x - u * y))
    corners = []
    for k in range(count):
        (first, a), (second, b) = lines[k - 1], lines[k]
        matrix = np.stack([first, second])
        corner = rough[k].astype(np.float64)
        if abs(float(np.linalg.det(matrix))) > 0.3:
            crossing = np.linalg.solve(matrix, [-a, -b])
            if np.linalg.norm(crossing - corner) < 2.0 * _BEND_MM:
                corner = crossing
        corners.append(corner)
    return np.array(corners)


def _rim(region: Mask) -> Mask:
    """Return the outermost pixels of a region."""
    return np.asarray(cv2.subtract(region, cv2.erode(region, np.ones((3, 3), np.uint8))), np.uint8)


@lru_cache(maxsize=32)
def _samples(shape: KindShape) -> tuple[Points, Points]:
    """Return points all over a face, just inside its edge at the outermost, and on its edge."""
    half_x, half_y = shape.length_mm / 2.0 - _INNER_MM, shape.width_mm / 2.0 - _INNER_MM
    x = np.linspace(-half_x, half_x, math.ceil(2.0 * half_x / _GRID_MM) + 1)
    y = np.linspace(-half_y, half_y, math.ceil(2.0 * half_y / _GRID_MM) + 1)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    if shape.is_round:
        grid = grid[np.hypot(grid[:, 0], grid[:, 1]) <= half_x]
    corners = shape.outline_mm
    shares = np.linspace(0.0, 1.0, 12 if not shape.is_round else 3, endpoint=False)[:, None, None]
    rim = (corners + shares * (np.roll(corners, -1, axis=0) - corners)).reshape(-1, 2)
    return grid, rim


def _looked_up(raster: NDArray[np.number], places: Points) -> NDArray[np.float64]:
    """Return the raster's values at the places (..., 2); its first value, a margin, outside."""
    height, width = raster.shape
    column, row = np.moveaxis(np.rint(places).astype(np.intp), -1, 0)
    is_in = (column >= 0) & (row >= 0) & (column < width) & (row < height)
    return np.asarray(raster[np.where(is_in, row, 0), np.where(is_in, column, 0)], np.float64)


def _distinct(placements: Sequence[Placement]) -> list[Placement]:
    """Return placements without those that say nearly the same as a better one."""
    kept: list[Placement] = []
    for one in placements:
        is_new = all(
            one.shape is not other.shape
            or math.hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm) > 2.5
            for other in kept
        )
        if is_new:
            kept.append(one)
        if len(kept) >= _MOST_REFINED:
            break
    return kept
