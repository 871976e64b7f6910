"""Draws solids over a backdrop: far ones first, each face in its own light.

Faces that look away are left out; what lies partly behind the camera is cut at the
near plane. Where a lit screen surrounds a block, the lens' blur carries the screen's
clipped white over the block's edge: the top face is drawn that much smaller and its
rim in the glare.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import Transform
from cell.twin.cameras.arm_shape import Figure
from cell.twin.cameras.light import ScreenGlow, shade
from cell.twin.cameras.optics import FULL_WIDTH_PX, Lens

_NEAR_MM = 12.0
_BLUR_PX = 0.4
"""Standard deviation of the blur of lens and colour mosaic in pixels of the full picture."""

_FILL_GROWTH_PX = 0.68
"""By how much OpenCV's smooth filling of a polygon reaches past its outline (measured:
0.60 to 0.73, by direction)."""

_SHIFT = 4
_SCALE = 1 << _SHIFT
_FAR_PX = 20000.0
_NOTCHED_CORNERS = 20
"""A face with more corners than this is the one with the notch."""

_CLIP_LEVEL = 255.0
_STANDARD = NormalDist()


@dataclass(frozen=True, slots=True, eq=False)
class Eye:
    """Where a camera is and what its lens does."""

    lens: Lens
    robot_from_camera: Transform

    def to_camera(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return robot points (n, 3) in the camera frame."""
        rotation = self.robot_from_camera.rotation
        return (points_mm - self.robot_from_camera.translation_mm) @ rotation

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
        are_lights_on: Whether the lamps are on.
    """

    expose: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.uint8]]
    glare: Callable[[NDArray[np.float64]], NDArray[np.float32]]
    glow: ScreenGlow
    are_lights_on: bool


def paint(
    canvas: NDArray[np.uint8], groups: Sequence[Sequence[Figure]], eye: Eye, brush: Brush
) -> None:
    """Draw groups of figures, each group's figures in order, far groups first."""
    figures = [figure for group in groups for figure in group]
    middles = eye.to_camera(np.array([figure.middle_mm for figure in figures]))
    distances = np.linalg.norm(middles, axis=1)
    is_seen = _may_be_seen(middles, np.array([f.solid.radius_mm for f in figures]), eye.lens)
    ordered: list[tuple[float, list[Figure]]] = []
    start = 0
    for group in groups:
        end = start + len(group)
        seen = [f for f, keep in zip(group, is_seen[start:end].tolist(), strict=True) if keep]
        if seen:
            ordered.append((-float(distances[start:end].mean()), seen))
        start = end
    ordered.sort(key=lambda entry: entry[0])
    drawn = [figure for _, group in ordered for figure in group]
    if drawn:
        _Faces(drawn, eye, brush).draw(canvas)


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

    def __init__(self, figures: Sequence[Figure], eye: Eye, brush: Brush) -> None:
        self._figures = figures
        self._eye = eye
        self._starts = _offsets([len(f.corners_mm) for f in figures])
        face_counts = [len(f.normals) for f in figures]
        self._face_starts = _offsets(face_counts)
        corners = np.concatenate([f.corners_mm for f in figures])
        self._camera = eye.to_camera(corners)
        pixels = _safe_pixels(self._camera, eye.lens)
        self._points = _fixed_point(pixels)
        self._middles = np.array([f.middle_mm for f in figures])
        around = brush.glow.around(self._middles)
        self._glare = self._glare_px(brush.glare(around).max(axis=1))
        self._inner = self._inset_points()
        self._shade(figures, face_counts, brush, around)
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
        figures: Sequence[Figure],
        face_counts: list[int],
        brush: Brush,
        around: NDArray[np.float64],
    ) -> None:
        """Work out which faces look at the camera, and the levels of faces and rims."""
        eye = self._eye
        normals = np.concatenate([f.normals for f in figures])
        centres = np.concatenate([f.centres_mm for f in figures])
        towards = eye.robot_from_camera.translation_mm - centres
        towards /= np.sqrt(np.einsum("ij,ij->i", towards, towards))[:, None]
        facing = np.einsum("ij,ij->i", normals, towards) > 0.0
        self._is_seen = facing.tolist()
        colours = np.repeat(np.array([f.colour for f in figures]), face_counts, axis=0)
        gloss = np.repeat(np.array([f.gloss for f in figures]), face_counts)
        light = shade(
            colours[facing], gloss[facing], normals[facing], centres[facing], towards[facing],
            brush.glow, are_lights_on=brush.are_lights_on,
        )  # fmt: skip
        where = _safe_pixels(eye.to_camera(centres[facing]), eye.lens)
        levels = np.zeros((len(normals), 3), np.uint8)
        levels[facing] = brush.expose(light, where)
        self._levels = levels.tolist()
        where = _safe_pixels(eye.to_camera(self._middles), eye.lens)
        self._rim_levels = brush.expose(0.5 * around, where).tolist()

    def draw(self, canvas: NDArray[np.uint8]) -> None:
        """Draw the figures in their order."""
        for index, figure in enumerate(self._figures):
            if self._is_hidden[index]:
                continue
            if self._is_cut[index]:
                self._draw_cut(canvas, index)
            else:
                if figure.solid.is_smooth:
                    self._underlay(canvas, index)
                self._draw_whole(canvas, index)

    def _draw_whole(self, canvas: NDArray[np.uint8], index: int) -> None:
        figure = self._figures[index]
        start, first = self._starts[index], self._face_starts[index]
        points = self._points
        for number, (low, high) in enumerate(figure.solid.spans):
            if not self._is_seen[first + number]:
                continue
            level = self._levels[first + number]
            outline = points[start + low : start + high]
            if figure.takes_glare and figure.solid.is_top[number]:
                if self._glare[index] > 0.0:
                    both = zip(level, self._rim_levels[index], strict=True)
                    _fill(canvas, outline, [min(255, face + rim) for face, rim in both])
                outline = self._inner[start + low : start + high]
            if figure.solid.is_notched and high - low > _NOTCHED_CORNERS:
                cv2.fillPoly(canvas, [outline], level, cv2.LINE_AA, _SHIFT)
            else:
                _fill(canvas, outline, level)

    def _underlay(self, canvas: NDArray[np.uint8], index: int) -> None:
        """Fill a round solid's silhouette first, so that no seam between facets shows."""
        first, end = self._face_starts[index], self._face_starts[index + 1]
        seen = [self._levels[f] for f in range(first, end) if self._is_seen[f]]
        if seen:
            level = [sum(channel) // len(seen) for channel in zip(*seen, strict=True)]
            points = self._points[self._starts[index] : self._starts[index + 1]]
            _fill(canvas, np.asarray(cv2.convexHull(points), np.int32), level)

    def _draw_cut(self, canvas: NDArray[np.uint8], index: int) -> None:
        """Draw the parts of a figure's faces that lie in front of the near plane."""
        start, first = self._starts[index], self._face_starts[index]
        for number, (low, high) in enumerate(self._figures[index].solid.spans):
            if self._is_seen[first + number]:
                kept = _in_front(self._camera[start + low : start + high])
                if len(kept) > 2:
                    points = _fixed_point(self._eye.lens.project(np.array(kept)))
                    _fill(canvas, points, self._levels[first + number])

    def _glare_px(self, around: NDArray[np.float32]) -> list[float]:
        """Return how many pixels of its edge each block loses to the glare around it.

        The edge appears where the blurred step from the face to the surroundings
        passes half of what the sensor can show.
        """
        scale = _BLUR_PX * self._eye.lens.width_px / FULL_WIDTH_PX
        return [
            scale * _STANDARD.inv_cdf(1.0 - 0.5 * _CLIP_LEVEL / level)
            if figure.takes_glare and level > _CLIP_LEVEL
            else 0.0
            for figure, level in zip(self._figures, around.tolist(), strict=True)
        ]

    def _inset_points(self) -> NDArray[np.int32]:
        """Return all corners in fixed point, those of blocks' top faces moved inwards.

        They give way to glare, and to what filling adds.
        """
        moved = self._camera.copy()
        inverse = self._eye.robot_from_camera.rotation
        for index, (figure, glare_px) in enumerate(zip(self._figures, self._glare, strict=True)):
            if figure.takes_glare:
                part = slice(*self._starts[index : index + 2])
                depth_mm = max(float(self._camera[part.start, 2]), 1.0)
                inset_mm = (glare_px + _FILL_GROWTH_PX) * depth_mm / self._eye.lens.focal_px
                moved[part] += figure.solid.inset @ (figure.rotation.T @ inverse * inset_mm)
        return _fixed_point(_safe_pixels(moved, self._eye.lens))


def _offsets(counts: list[int]) -> list[int]:
    return [0, *accumulate(counts)]


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


def _fixed_point(pixels: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return pixels in the sixteenths that OpenCV's filling takes."""
    return np.rint(np.clip(pixels, -_FAR_PX, _FAR_PX) * _SCALE).astype(np.int32)


def _fill(canvas: NDArray[np.uint8], outline: NDArray[np.int32], level: Sequence[int]) -> None:
    cv2.fillConvexPoly(canvas, outline, level, cv2.LINE_AA, _SHIFT)
