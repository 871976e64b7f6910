"""Known faces laid exactly on their edges in the picture, all of a picture's at once.

Along each side of a face the picture is sampled across the edge. How far a sample's colour
is from the face's own tells where the face ends: where it first passes half of what it is
shortly beyond. From these offsets follow shift, turn and how much smaller than life the face
appears (the glare of a lit screen eats the same from every side), by weighted least squares
with a bound on what one sample can pull. Sides without contrast, as where blocks of one
colour touch, say nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.sight import KindShape

Points = NDArray[np.float64]
Floats = NDArray[np.floating]

_REACH_MM = 2.8
_STEP_MM = 0.4
_SAMPLES_PER_SIDE = 9
_SAMPLES = 4 * _SAMPLES_PER_SIDE
_CORNER_SHARE = 0.1
_LEAST_CONTRAST = 9.0
_NOISE_FACTOR = 3.5
_PLATEAU_STEPS = 3
_PULL_MM = 0.35
_INSET_MM = 0.25
_INSET_DEVIATION_MM = 0.35
_SAMPLE_DEVIATION_MM = 0.15
_PLACE_DEVIATION_MM = 0.24
_TURN_DEVIATION_MM = 0.08
_SUPPORT_MM = 0.9
_INNER = 6
_PLACE_PER_RESIDUAL = 1.6
_OFFSETS_MM = (np.arange(round(2.0 * _REACH_MM / _STEP_MM) + 1) * _STEP_MM - _REACH_MM).astype(
    np.float32
)


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
    return _Fit(picture, starts).run() if starts else []


@dataclass(frozen=True, slots=True, eq=False)
class _Table:
    """What the fit needs of a shape, in the face's own frame, mm.

    Attributes:
        across: Points across the outline, from inside out, (36 * 15, 2).
        inner: Points inside, away from the edge, (36, 2).
        slopes: How the outline's points move outwards with x, y, turn and inset, (36, 4).
        stiffness: What is added to the normal matrix's diagonal, (4,): a disc has no turn.
    """

    across: Floats
    inner: Floats
    slopes: Floats
    stiffness: Floats


@dataclass(slots=True, eq=False)
class _Edges:
    """Where the faces end, one row a face and one column a sample.

    Attributes:
        miss: How far outside the true outline, mm.
        is_edge: Whether there is an edge at all.
        weight: What the sample counts.
    """

    miss: Floats
    is_edge: NDArray[np.bool_]
    weight: Floats


@dataclass(slots=True, eq=False)
class _Colours:
    """Colours inside the faces: means (n, 3), largest deviations (n,), uniform shares (n,)."""

    mean: Floats
    spread: Floats
    uniform: Floats


@dataclass(slots=True, eq=False)
class _Fit:
    """All faces of a picture at once: every array's first axis is the faces'."""

    picture: NDArray[np.uint8]
    starts: Sequence[Start]
    _maps: Points = field(init=False)
    _across: Floats = field(init=False)
    _inner: Floats = field(init=False)
    _slopes: Floats = field(init=False)
    _stiffness: Floats = field(init=False)

    def __post_init__(self) -> None:
        tables = [_table(start.shape) for start in self.starts]
        self._maps = np.array([start.px_from_mm for start in self.starts])
        self._across = np.array([table.across for table in tables])
        self._inner = np.array([table.inner for table in tables])
        self._slopes = np.array([table.slopes for table in tables])
        self._stiffness = np.array([table.stiffness for table in tables])

    def run(self) -> list[FittedFace]:
        """Return the fitted faces."""
        state = np.array([(s.x_mm, s.y_mm, s.angle_rad, _INSET_MM) for s in self.starts])
        colours = self._colours(state)
        edges = self._edges(state, colours)
        step, _ = self._solve(state, edges)
        state += step
        colours = self._colours(state)
        edges = self._edges(state, colours)
        step, covariance = self._solve(state, edges)
        # The last step is far below a sample's pitch: its effect on the misses is linear.
        left = edges.miss + (state[:, 3] + step[:, 3])[:, None] - self._moved(state, step)
        state += step
        return self._fitted(state, colours, edges, np.abs(left), covariance)

    def _fitted(
        self, state: Points, colours: _Colours, edges: _Edges, left: Points, covariance: Points
    ) -> list[FittedFace]:
        supported = edges.is_edge & (left < _SUPPORT_MM)
        residual = 1.48 * _masked_median(left, supported)
        support = supported.mean(axis=1)
        open_support = supported.sum(axis=1) / np.maximum(1, edges.is_edge.sum(axis=1))
        # Neighbouring samples share the lens's blur and the raster: far fewer are free, and
        # what shifts a whole side alike does not turn it.
        a, b, c = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
        worst = 0.5 * (a + c) + np.hypot(0.5 * (a - c), b)
        place = np.sqrt(worst) * np.maximum(_PLACE_PER_RESIDUAL * residual, _PLACE_DEVIATION_MM)
        turn = np.sqrt(covariance[:, 2, 2]) * np.maximum(residual, _TURN_DEVIATION_MM)
        columns = (
            self.starts, state.tolist(), residual.tolist(), support.tolist(),
            open_support.tolist(), colours.spread.tolist(), colours.mean.tolist(),
            colours.uniform.tolist(), place.tolist(), turn.tolist(),
        )  # fmt: skip
        return [
            FittedFace(
                shape=start.shape,
                x_mm=x,
                y_mm=y,
                angle_rad=angle,
                inset_mm=inset,
                residual_mm=off,
                support=all_support,
                open_support=open_,
                flatness=flat,
                mean_rgb=(mean[0], mean[1], mean[2]),
                uniform=even,
                deviation_mm=deviation,
                deviation_rad=0.0 if start.shape.is_round else turning,
            )
            for start, (x, y, angle, inset), off, all_support, open_, flat, mean, even,
            deviation, turning in zip(*columns, strict=True)
        ]  # fmt: skip

    def _sampled(self, state: Points, local: Floats) -> list[NDArray[np.uint8]]:
        """Return the picture's channels, each (n, m), at points (n, m, 2) of the faces' frames."""
        cos, sin = np.cos(state[:, 2]), np.sin(state[:, 2])
        turn = np.stack([cos, sin, -sin, cos], axis=1).reshape(-1, 2, 2)
        linear = self._maps[:, :, :2]
        transposed = turn @ linear.transpose(0, 2, 1)
        shift = (linear @ state[:, :2, None])[..., 0] + self._maps[:, :, 2]
        places = local @ transposed.astype(np.float32)
        places += shift.astype(np.float32)[:, None]
        values = cv2.remap(  # type: ignore[call-overload]
            self.picture, places, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        return list(cv2.split(values))

    def _colours(self, state: Points) -> _Colours:
        values = np.array(self._sampled(state, self._inner), np.float32)
        ordered = np.partition(values, values.shape[2] // 2, axis=2)
        middle = ordered[:, :, values.shape[2] // 2]
        off = np.abs(values - middle[..., None])
        limit = 6.0 + 0.05 * middle.max(axis=0)
        is_same = np.maximum(np.maximum(off[0], off[1]), off[2]) < limit[:, None]
        count = is_same.sum(axis=1)
        free = 1.0 / np.maximum(count, 1)
        mean = np.where(count > 3, (values * is_same).sum(axis=2) * free, middle)
        off = (values - mean[..., None]) * is_same
        spread = np.sqrt(np.square(off).sum(axis=2) * free)
        return _Colours(
            mean=mean.T.astype(np.float32),
            spread=spread.max(axis=0).astype(np.float32),
            uniform=(count / values.shape[2]).astype(np.float32),
        )

    def _edges(self, state: Points, colours: _Colours) -> _Edges:
        red, green, blue = (
            np.abs(channel.astype(np.float32) - mean[:, None])
            for channel, mean in zip(
                self._sampled(state, self._across), colours.mean.T, strict=True
            )
        )
        steps = len(_OFFSETS_MM)
        distance = np.maximum(np.maximum(red, green, out=red), blue, out=red)
        flat = distance.reshape(-1, steps)
        least = np.maximum(_LEAST_CONTRAST, _NOISE_FACTOR * colours.spread)
        least = np.repeat(least, _SAMPLES)
        beyond = flat > least[:, None]
        first = beyond.argmax(axis=1)
        rows = np.arange(len(flat))
        first[~beyond[rows, first]] = steps - 1
        plateau = flat[rows, np.minimum(first + _PLATEAU_STEPS, steps - 1)]
        half = np.maximum(0.5 * plateau, least)
        passed = flat >= half[:, None]
        found = passed.argmax(axis=1)
        is_edge = passed[rows, found] & (found > 0)
        before = np.maximum(found - 1, 0)
        low = flat[rows, before]
        high = flat[rows, found]
        share = np.clip((half - low) / np.maximum(high - low, 1e-6), 0.0, 1.0)
        miss = (_OFFSETS_MM[before] + share * _STEP_MM).reshape(-1, _SAMPLES)
        is_edge = is_edge.reshape(-1, _SAMPLES)
        pull = np.maximum(1.0, np.abs(miss + state[:, 3:4]) / _PULL_MM)
        return _Edges(miss=miss, is_edge=is_edge, weight=is_edge / np.square(pull))

    def _solve(self, state: Points, edges: _Edges) -> tuple[Points, Points]:
        """Return the step (n, 4), robot frame, and the inverse normal matrix, face frame."""
        # An edge at `miss` beyond the outline is one that the inset has not moved yet.
        wanted = edges.miss + state[:, 3:4]
        weighted = (self._slopes * edges.weight[..., None]).transpose(0, 2, 1)
        normal = weighted @ self._slopes
        right = (weighted @ wanted[..., None])[..., 0]
        prior = 1.0 / (_INSET_DEVIATION_MM / _SAMPLE_DEVIATION_MM) ** 2
        normal[:, [0, 1, 2, 3], [0, 1, 2, 3]] += self._stiffness
        right[:, 3] += prior * (_INSET_MM - state[:, 3])
        covariance = np.linalg.inv(normal)
        step = (covariance @ right[..., None])[..., 0]
        step[:, :2] = np.clip(step[:, :2], -2.0, 2.0)
        step[:, 2] = np.clip(step[:, 2], -0.2, 0.2)
        return _turned_steps(step, state[:, 2]), np.asarray(covariance, np.float64)

    def _moved(self, state: Points, step: Points) -> Points:
        """Return how far a step (n, 4) moves the outline's points outwards, inset included."""
        own = _turned_steps(step, -state[:, 2])
        return np.asarray((self._slopes @ own[..., None])[..., 0] + step[:, 3:4])


def _turned_steps(steps: Points, angles_rad: Points) -> Points:
    """Return steps (n, 4) with their x, y turned."""
    cos, sin = np.cos(angles_rad), np.sin(angles_rad)
    out = steps.copy()
    out[:, 0] = cos * steps[:, 0] - sin * steps[:, 1]
    out[:, 1] = sin * steps[:, 0] + cos * steps[:, 1]
    return out


@lru_cache(maxsize=32)
def _table(shape: KindShape) -> _Table:
    points, normals = _edge_points(shape)
    lever = points[:, 0] * normals[:, 1] - points[:, 1] * normals[:, 0]
    across = points[:, None] + _OFFSETS_MM[:, None] * normals[:, None]
    prior = 1.0 / (_INSET_DEVIATION_MM / _SAMPLE_DEVIATION_MM) ** 2
    return _Table(
        across=across.reshape(-1, 2).astype(np.float32),
        inner=_inner_points(shape).astype(np.float32),
        slopes=np.concatenate([normals, lever[:, None], -np.ones((len(lever), 1))], axis=1).astype(
            np.float64
        ),
        stiffness=np.array([1e-3, 1e-3, 1e9 if shape.is_round else 1e-1, prior]),
    )


def _edge_points(shape: KindShape) -> tuple[Points, Points]:
    """Return points on a face's outline and the outward normals there, both (m, 2)."""
    if shape.is_round:
        turn = 2.0 * np.pi * np.arange(_SAMPLES) / _SAMPLES
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
