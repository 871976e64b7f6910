"""Known faces laid exactly on their edges in the picture, all of a picture's at once.

Along each side of a face the picture is sampled across the edge. How far a sample's colour
is from the face's own tells where the face ends: where it first passes half of what it is
shortly beyond. From these offsets follow shift, turn and how much smaller than life the face
appears (the glare of a lit screen eats the same from every side), by weighted least squares
with a bound on what one sample can pull. Sides without contrast, as where blocks of one
colour touch, say nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.sight import KindShape

Points = NDArray[np.float64]

_REACH_MM = 2.8
_STEP_MM = 0.4
_SAMPLES_PER_SIDE = 9
_DISC_SAMPLES = 36
_CORNER_SHARE = 0.1
_LEAST_CONTRAST = 9.0
_NOISE_FACTOR = 3.5
_PLATEAU_STEPS = 3
_PULL_MM = 0.35
_INSET_MM = 0.25
_INSET_DEVIATION_MM = 0.35
_SAMPLE_DEVIATION_MM = 0.15
_TURN_DEVIATION_MM = 0.13
_ROUNDS = 2
_SUPPORT_MM = 0.9
_INNER = 6


@dataclass(frozen=True, slots=True, eq=False)
class FittedFace:
    """A face after the fit.

    Attributes:
        shape: Whose face.
        x_mm: Robot x of its middle.
        y_mm: Robot y of its middle.
        angle_rad: Direction of its length, robot frame.
        inset_mm: How much smaller than life it appears at each side.
        residual_mm: Robust deviation of the samples used.
        support: Share of the outline with an edge where it should be.
        open_support: The same of the outline that no other face touches.
        flatness: Largest deviation of a channel inside, grey levels.
        mean_rgb: Mean colour inside, its edge left out.
        uniform: Share of inner points whose colour is that mean.
        deviation_mm: Standard deviation of the middle along its worst direction.
        deviation_rad: Standard deviation of the angle.
    """

    shape: KindShape
    x_mm: float
    y_mm: float
    angle_rad: float
    inset_mm: float
    residual_mm: float
    support: float
    open_support: float
    flatness: float
    mean_rgb: tuple[float, float, float]
    uniform: float
    deviation_mm: float
    deviation_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a face is looked for.

    Attributes:
        shape: Whose face.
        x_mm: Robot x of its middle.
        y_mm: Robot y of its middle.
        angle_rad: Direction of its length.
        px_from_mm: Affine map (2, 3) from robot mm at the block tops to the picture, good
            around the face.
    """

    shape: KindShape
    x_mm: float
    y_mm: float
    angle_rad: float
    px_from_mm: Points


def fit_faces(picture: NDArray[np.uint8], starts: Sequence[Start]) -> list[FittedFace]:
    """Return the faces laid on their edges, in the same order.

    Args:
        picture: R G B, (h, w, 3).
        starts: Where they are, to about 2 mm.
    """
    if not starts:
        return []
    results: list[FittedFace | None] = [None] * len(starts)
    for is_round in (False, True):
        chosen = [k for k, start in enumerate(starts) if start.shape.is_round == is_round]
        if chosen:
            batch = _Batch(picture, [starts[k] for k in chosen], is_round=is_round)
            for index, fitted in zip(chosen, batch.run(), strict=True):
                results[index] = fitted
    return [fitted for fitted in results if fitted is not None]


class _Batch:
    """Faces with the same number of samples: all boxes, or all discs."""

    def __init__(
        self, picture: NDArray[np.uint8], starts: Sequence[Start], *, is_round: bool
    ) -> None:
        self._picture = picture
        self._starts = starts
        self._is_round = is_round
        edges = [_edge_points(start.shape) for start in starts]
        self._points = np.stack([points for points, _ in edges])
        self._normals = np.stack([normals for _, normals in edges])
        self._inner = np.stack([_inner_points(start.shape) for start in starts])
        self._maps = np.stack([start.px_from_mm for start in starts])
        self._offsets = np.arange(-_REACH_MM, _REACH_MM + _STEP_MM / 2.0, _STEP_MM)

    def run(self) -> list[FittedFace]:
        """Return the fitted faces."""
        state = np.array([(s.x_mm, s.y_mm, s.angle_rad, _INSET_MM) for s in self._starts])
        mean, spread = self._colours(state)
        for _ in range(_ROUNDS):
            miss, is_edge, weight = self._misses(state, mean, spread)
            step, covariance = self._solve(state, miss, weight)
            state += step
        mean, spread = self._colours(state)
        uniform = self._uniform
        miss, is_edge, weight = self._misses(state, mean, spread)
        left = miss + state[:, 3:4]
        supported = is_edge & (np.abs(left) < _SUPPORT_MM)
        residual = 1.48 * _masked_median(np.abs(left), supported)
        _, covariance = self._solve(state, miss, weight)
        results = []
        for k, start in enumerate(self._starts):
            x, y, angle, inset = state[k].tolist()
            # Neighbouring samples share the lens's blur and the raster: far fewer are free.
            scale = max(residual[k], _SAMPLE_DEVIATION_MM) * 2.0
            # What shifts a whole side alike does not turn it.
            turn_scale = max(residual[k], _TURN_DEVIATION_MM)
            place = covariance[k, :2, :2] * scale**2
            red, green, blue = mean[k].tolist()
            results.append(
                FittedFace(
                    shape=start.shape,
                    x_mm=x,
                    y_mm=y,
                    angle_rad=angle,
                    inset_mm=inset,
                    residual_mm=float(residual[k]),
                    support=float(supported[k].mean()),
                    open_support=float(supported[k].sum() / max(1, is_edge[k].sum())),
                    flatness=float(spread[k].max()),
                    mean_rgb=(red, green, blue),
                    uniform=float(uniform[k]),
                    deviation_mm=math.sqrt(float(np.linalg.eigvalsh(place)[-1])),
                    deviation_rad=0.0
                    if self._is_round
                    else math.sqrt(float(covariance[k, 2, 2])) * turn_scale,
                )
            )
        return results

    def _placed(self, state: Points, local: Points) -> Points:
        """Return robot points (n, m, 2) of points in the faces' own frames."""
        return np.asarray(_turn(state[:, 2], local) + state[:, None, :2])

    def _sampled(self, points_mm: Points) -> Points:
        """Return the picture's colours (n, ..., 3) at robot points (n, ..., 2)."""
        flat = points_mm.reshape(len(points_mm), -1, 2)
        pixels = flat @ np.swapaxes(self._maps[:, :, :2], 1, 2) + self._maps[:, None, :, 2]
        places = np.ascontiguousarray(pixels, np.float32)
        values = cv2.remap(  # type: ignore[call-overload]
            self._picture, places, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(values, np.float64).reshape(*points_mm.shape[:-1], 3)

    def _colours(self, state: Points) -> tuple[Points, Points]:
        """Return mean and deviation (n, 3) of the faces' inner colours."""
        values = self._sampled(self._placed(state, self._inner))
        middle = np.median(values, axis=1)
        off = np.abs(values - middle[:, None]).max(axis=2)
        limit = 6.0 + 0.05 * middle.max(axis=1)
        is_same = off < limit[:, None]
        self._uniform = is_same.mean(axis=1)
        count = np.maximum(is_same.sum(axis=1), 1)[:, None]
        mean = (values * is_same[..., None]).sum(axis=1) / count
        spread = np.sqrt(
            (np.square(values - mean[:, None]) * is_same[..., None]).sum(axis=1) / count
        )
        return np.where(count > 3, mean, middle), spread

    def _misses(
        self, state: Points, mean: Points, spread: Points
    ) -> tuple[Points, NDArray[np.bool_], Points]:
        """Return where the edges are outside the true outline (n, m), which there are, weights."""
        normals = _turn(state[:, 2], self._normals)
        base = self._placed(state, self._points)
        places = base[:, :, None] + self._offsets[:, None] * normals[:, :, None]
        values = self._sampled(places)
        distance = np.abs(values - mean[:, None, None]).max(axis=3)
        least = np.maximum(_LEAST_CONTRAST, _NOISE_FACTOR * spread.max(axis=1))[:, None]
        beyond = distance > least[..., None]
        last = len(self._offsets) - 1
        first = np.where(beyond.any(axis=2), beyond.argmax(axis=2), last)
        at = np.minimum(first + _PLATEAU_STEPS, last)
        plateau = np.take_along_axis(distance, at[..., None], axis=2)
        half = np.maximum(plateau / 2.0, least[..., None])
        passed = distance >= half
        found = passed.argmax(axis=2)
        is_edge = passed.any(axis=2) & (found > 0)
        before = np.maximum(found - 1, 0)
        low = np.take_along_axis(distance, before[..., None], axis=2)[..., 0]
        high = np.take_along_axis(distance, found[..., None], axis=2)[..., 0]
        share = np.clip((half[..., 0] - low) / np.maximum(high - low, 1e-6), 0.0, 1.0)
        miss = self._offsets[before] + share * _STEP_MM
        left = miss + state[:, 3:4]
        weight = is_edge / np.maximum(1.0, np.abs(left) / _PULL_MM) ** 2
        return miss, is_edge, weight

    def _solve(self, state: Points, miss: Points, weight: Points) -> tuple[Points, Points]:
        """Return the step (n, 4) and the inverse of the normal matrix (n, 4, 4)."""
        normals = _turn(state[:, 2], self._normals)
        lever = self._points[:, :, 0] * self._normals[:, :, 1]
        lever = lever - self._points[:, :, 1] * self._normals[:, :, 0]
        slopes = np.concatenate([normals, lever[..., None], -np.ones((*lever.shape, 1))], axis=2)
        # An edge at `miss` beyond the outline is one that the inset has not moved yet.
        wanted = miss + state[:, 3:4]
        weighted = np.swapaxes(slopes * weight[..., None], 1, 2)
        normal = weighted @ slopes
        right = (weighted @ wanted[..., None])[..., 0]
        prior = 1.0 / (_INSET_DEVIATION_MM / _SAMPLE_DEVIATION_MM) ** 2
        normal[:, 3, 3] += prior
        right[:, 3] += prior * (_INSET_MM - state[:, 3])
        stiff = np.array([1e-3, 1e-3, 1e-1, 0.0])
        normal += np.diag(stiff)
        if self._is_round:
            normal[:, 2, 2] += 1e9
        covariance = np.linalg.inv(normal)
        step = np.einsum("nij,nj->ni", covariance, right)
        step[:, :2] = np.clip(step[:, :2], -2.0, 2.0)
        step[:, 2] = np.clip(step[:, 2], -0.2, 0.2)
        return step, covariance


def _turn(angles_rad: Points, vectors: Points) -> Points:
    """Return vectors (n, m, 2) turned, each group by its own angle."""
    cos, sin = np.cos(angles_rad)[:, None], np.sin(angles_rad)[:, None]
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


@lru_cache(maxsize=32)
def _edge_points(shape: KindShape) -> tuple[Points, Points]:
    """Return points on a face's outline and the outward normals there, both (m, 2)."""
    if shape.is_round:
        turn = 2.0 * np.pi * np.arange(_DISC_SAMPLES) / _DISC_SAMPLES
        normals = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return normals * shape.length_mm / 2.0, normals
    shares = np.linspace(_CORNER_SHARE, 1.0 - _CORNER_SHARE, _SAMPLES_PER_SIDE)[:, None]
    corners = shape.outline_mm
    points: list[Points] = []
    across: list[Points] = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        points.append(start + shares * (end - start))
        across.append(np.tile([along[1], -along[0]], (_SAMPLES_PER_SIDE, 1)))
    return np.concatenate(points), np.concatenate(across)


@lru_cache(maxsize=32)
def _inner_points(shape: KindShape) -> Points:
    """Return points inside a face, away from its edge, (36, 2)."""
    share = np.linspace(-0.8, 0.8, _INNER)
    x, y = np.meshgrid(share, share)
    if shape.is_round:
        # The square grid drawn onto the disc.
        radius = np.maximum(np.abs(x), np.abs(y))
        turn = np.arctan2(y, x)
        x, y = radius * np.cos(turn), radius * np.sin(turn)
    grid = np.stack([x.ravel() * shape.length_mm / 2.0, y.ravel() * shape.width_mm / 2.0], axis=1)
    return np.asarray(grid)


def _masked_median(values: Points, is_used: NDArray[np.bool_]) -> Points:
    """Return the median of each row's used values, 0 for none."""
    hidden = np.where(is_used, values, np.inf)
    ordered = np.sort(hidden, axis=1)
    count = is_used.sum(axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.where(count > 0, middle, 0.0)
