"""Draws solids over a backdrop: far ones first, each face in its own light.

Faces that look away are left out; what lies partly behind the camera is cut at the
near plane. Where a lit screen surrounds a block, the lens' blur carries the screen's
clipped white over the block's edge: the top face is drawn that much smaller and its
rim in the glare.

Drawing has two steps, because a fixed camera need not repeat the first for what does
not move: `sketch` works out outlines and levels, `paint` fills them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import Transform
from cell.twin.cameras.figures import Figure, middles_mm, place_all
from cell.twin.cameras.light import Lamps, ScreenGlow, shade
from cell.twin.cameras.optics import FULL_WIDTH_PX, Lens

_NEAR_MM = 12.0
_GLARE_PX = 1.1
"""Standard deviation of the blur that spreads glare, in pixels of the full picture."""

_FILL_GROWTH_PX = 0.68
"""By how much OpenCV's smooth filling of a polygon reaches past its outline (measured:
0.60 to 0.73, by direction)."""

_SHIFT = 4
_SCALE = 1 << _SHIFT
_FAR_PX = 20000.0
_CONVEX_CORNERS = 20
"""Of a notched solid, only the face with the notch has more corners than this."""

_CLIP_LEVEL = 255.0
_STANDARD = NormalDist()

Level = list[int]
Outline = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Eye:
    """Where a camera is and what its lens does."""

    lens: Lens
    robot_from_camera: Transform

    def to_camera(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return robot points (n, 3) in the camera frame."""
        rotation = self.robot_from_camera.rotation
        return np.asarray((points_mm - self.robot_from_camera.translation_mm) @ rotation)

    def pixels(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pixels (n, 2) of robot points (n, 3) in front of the camera."""
        return self.lens.project(self.to_camera(points_mm))


@dataclass(frozen=True, slots=True, eq=False)
class Brush:
    """How light becomes levels on the canvas.

    Attributes:
        expose: From light (n, 3) at pixels (n, 2) to canvas levels (n, 3), 0..255.
        glare: From the light around a block to what it exposes to, unclipped.
        glow: The screen's light.
        lamps: What the lamps give.
    """

    expose: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.uint8]]
    glare: Callable[[NDArray[np.float64]], NDArray[np.float32]]
    glow: ScreenGlow
    lamps: Lamps


@dataclass(frozen=True, slots=True, eq=False)
class Sketch:
    """A figure ready to be filled in.

    Attributes:
        distance_mm: From the camera to the figure's middle.
        fills: Outlines in sixteenths of a pixel, each with its level, in order.
    """

    distance_mm: float
    fills: list[tuple[Outline, Level]]


def paint(canvas: NDArray[np.uint8], groups: Iterable[Sequence[Sketch]]) -> None:
    """Fill groups of sketches, each group's in order, far groups first."""
    kept = [group for group in groups if group]
    kept.sort(key=lambda group: -sum(s.distance_mm for s in group) / len(group))
    for group in kept:
        for drawn in group:
            for outline, level in drawn.fills:
                if len(outline) > _CONVEX_CORNERS and not cv2.isContourConvex(outline):
                    cv2.fillPoly(canvas, [outline], level, cv2.LINE_AA, _SHIFT)
                else:
                    cv2.fillConvexPoly(canvas, outline, level, cv2.LINE_AA, _SHIFT)


def sketch(figures: Sequence[Figure], eye: Eye, brush: Brush) -> list[Sketch]:
    """Return what each figure looks like; those out of view have nothing to fill."""
    every = list(figures)
    if not every:
        return []
    middles = middles_mm(every)
    camera = eye.to_camera(middles)
    distances = np.sqrt(np.einsum("ij,ij->i", camera, camera)).tolist()
    radii = np.array([figure.solid.radius_mm for figure in every])
    chosen = np.flatnonzero(_may_be_seen(camera, radii, eye.lens)).tolist()
    fills: dict[int, list[tuple[Outline, Level]]] = {}
    if chosen:
        faces = _Faces([every[index] for index in chosen], middles[chosen], eye, brush)
        fills = {index: faces.fills(number) for number, index in enumerate(chosen)}
    return [Sketch(distance, fills.get(index, [])) for index, distance in enumerate(distances)]


def _may_be_seen(
    middles: NDArray[np.float64], radii: NDArray[np.float64], lens: Lens
) -> NDArray[np.bool_]:
    """Return which balls of the camera frame reach into the field of view."""
    wide = 0.62 * lens.width_px / lens.focal_px
    tall = 0.62 * lens.height_px / lens.focal_px
    x, y, z = middles.T
    depth = np.maximum(z, 0.0) + radii
    in_view = (np.abs(x) - radii < wide * depth) & (np.abs(y) - radii < tall * depth)
    return np.asarray((z + radii > _NEAR_MM) & in_view)


class _Faces:
    """All faces of some figures, projected and shaded together."""

    def __init__(
        self, figures: list[Figure], middles: NDArray[np.float64], eye: Eye, brush: Brush
    ) -> None:
        placed = place_all(figures)
        self._figures = figures
        self._eye = eye
        self._starts = [0, *accumulate(placed.corner_counts)]
        self._face_starts = [0, *accumulate(placed.face_counts)]
        self._camera = eye.to_camera(placed.corners_mm)
        pixels = _safe_pixels(self._camera, eye.lens)
        self._points = _fixed_point(pixels)
        around = brush.glow.around(middles)
        self._glare = self._glare_px(brush.glare(around).max(axis=1))
        self._inner = self._points
        if any(figure.takes_glare for figure in figures):
            self._inner = self._inset_points(placed.inset @ eye.robot_from_camera.rotation)
        self._shade(placed.normals, placed.centres_mm, placed.face_counts, brush)
        where = _safe_pixels(eye.to_camera(middles), eye.lens)
        self._rim_levels = brush.expose(0.5 * around, where).tolist()
        first = self._starts[:-1]
        low, high = np.minimum.reduceat(pixels, first), np.maximum.reduceat(pixels, first)
        size = (eye.lens.width_px, eye.lens.height_px)
        depth = self._camera[:, 2]
        self._is_cut = (np.minimum.reduceat(depth, first) < _NEAR_MM).tolist()
        is_out = ((high < 0) | (low > size)).any(axis=1)
        is_behind = np.maximum.reduceat(depth, first) < _NEAR_MM
        self._is_hidden = (is_behind | (is_out & ~np.array(self._is_cut))).tolist()

    def _shade(
        self,
        normals: NDArray[np.float64],
        centres: NDArray[np.float64],
        face_counts: list[int],
        brush: Brush,
    ) -> None:
        """Work out which faces look at the camera, and their levels."""
        eye, figures = self._eye, self._figures
        towards = eye.robot_from_camera.translation_mm - centres
        towards /= np.sqrt(np.einsum("ij,ij->i", towards, towards))[:, None]
        facing = np.einsum("ij,ij->i", normals, towards) > 0.0
        self._is_seen = facing.tolist()
        of_face = np.repeat(np.arange(len(figures)), face_counts)[facing]
        colours = np.array([figure.colour for figure in figures])[of_face]
        gloss = np.array([figure.gloss for figure in figures])[of_face]
        seen = centres[facing]
        light = shade(
            colours, gloss, normals[facing], seen, towards[facing], brush.glow,
            lamplight=brush.lamps,
        )  # fmt: skip
        levels = np.zeros((len(normals), 3), np.uint8)
        levels[facing] = brush.expose(light, _safe_pixels(eye.to_camera(seen), eye.lens))
        self._levels: list[Level] = levels.tolist()

    def fills(self, index: int) -> list[tuple[Outline, Level]]:
        """Return the outlines and levels of one figure."""
        if self._is_hidden[index]:
            return []
        if self._is_cut[index]:
            return self._cut(index)
        if self._figures[index].solid.is_smooth:
            return self._underlay(index) + self._whole(index)
        return self._whole(index)

    def _whole(self, index: int) -> list[tuple[Outline, Level]]:
        figure = self._figures[index]
        start, first = self._starts[index], self._face_starts[index]
        fills = []
        for number, (low, high) in enumerate(figure.solid.spans):
            if not self._is_seen[first + number]:
                continue
            level = self._levels[first + number]
            outline = self._points[start + low : start + high]
            if figure.takes_glare and figure.solid.is_top[number]:
                if self._glare[index] > 0.0:
                    both = zip(level, self._rim_levels[index], strict=True)
                    fills.append((outline, [min(255, face + rim) for face, rim in both]))
                outline = self._inner[start + low : start + high]
            fills.append((outline, level))
        return fills

    def _underlay(self, index: int) -> list[tuple[Outline, Level]]:
        """Return a round solid's silhouette, so that no seam between its facets shows."""
        first, end = self._face_starts[index], self._face_starts[index + 1]
        seen = [self._levels[face] for face in range(first, end) if self._is_seen[face]]
        if not seen:
            return []
        level = [sum(channel) // len(seen) for channel in zip(*seen, strict=True)]
        points = self._points[self._starts[index] : self._starts[index + 1]]
        return [(np.asarray(cv2.convexHull(points), np.int32), level)]

    def _cut(self, index: int) -> list[tuple[Outline, Level]]:
        """Return the parts of a figure's faces that lie in front of the near plane."""
        start, first = self._starts[index], self._face_starts[index]
        fills = []
        for number, (low, high) in enumerate(self._figures[index].solid.spans):
            if self._is_seen[first + number]:
                kept = _in_front(self._camera[start + low : start + high])
                if len(kept) > 2:
                    points = _fixed_point(self._eye.lens.project(np.array(kept)))
                    fills.append((points, self._levels[first + number]))
        return fills

    def _glare_px(self, around: NDArray[np.float32]) -> list[float]:
        """Return how many pixels of its edge each block loses to the glare around it.

        The edge appears where the blurred step from the face to the surroundings
        passes half of what the sensor can show.
        """
        scale = _GLARE_PX * self._eye.lens.width_px / FULL_WIDTH_PX
        return [
            scale * _STANDARD.inv_cdf(1.0 - 0.5 * _CLIP_LEVEL / level)
            if figure.takes_glare and level > _CLIP_LEVEL
            else 0.0
            for figure, level in zip(self._figures, around.tolist(), strict=True)
        ]

    def _inset_points(self, inset: NDArray[np.float64]) -> Outline:
        """Return all corners in fixed point, those of blocks' top faces moved inwards.

        They give way to glare, and to what filling adds.
        """
        lost_px = [
            glare_px + _FILL_GROWTH_PX if figure.takes_glare else 0.0
            for figure, glare_px in zip(self._figures, self._glare, strict=True)
        ]
        counts = np.diff(self._starts)
        depth_mm = np.maximum(self._camera[:, 2], 1.0)
        inset_mm = np.repeat(lost_px, counts) * depth_mm / self._eye.lens.focal_px
        return _fixed_point(_safe_pixels(self._camera + inset * inset_mm[:, None], self._eye.lens))


def _in_front(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return a polygon of the camera frame cut at the near plane."""
    kept: list[NDArray[np.float64]] = []
    is_front = (points[:, 2] >= _NEAR_MM).tolist()
    if not any(is_front):
        return kept
    for index, here in enumerate(points):
        after = (index + 1) % len(points)
        if is_front[index]:
            kept.append(here)
        if is_front[index] != is_front[after]:
            step = points[after] - here
            kept.append(here + step * ((_NEAR_MM - here[2]) / step[2]))
    return kept


def _safe_pixels(camera: NDArray[np.float64], lens: Lens) -> NDArray[np.float64]:
    """Project points, those behind the near plane as if they lay on it."""
    if camera[:, 2].min() < _NEAR_MM:
        camera = camera.copy()
        camera[:, 2] = np.maximum(camera[:, 2], _NEAR_MM)
    return lens.project(camera)


def _fixed_point(pixels: NDArray[np.float64]) -> Outline:
    """Return pixels in the sixteenths that OpenCV's filling takes."""
    return np.rint(np.clip(pixels, -_FAR_PX, _FAR_PX) * _SCALE).astype(np.int32)
