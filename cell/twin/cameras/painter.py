"""Draws solids over a backdrop: far ones first, each face in its own light.

Faces that look away are left out; what lies partly behind the camera is cut at the
near plane. Where a lit screen surrounds a block, the lens' blur carries the screen's
clipped white over the block's edge: the top face is drawn that much smaller and its
rim in the glare.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import Transform
from cell.twin.cameras.arm_shape import Figure
from cell.twin.cameras.light import ScreenGlow, shade
from cell.twin.cameras.optics import FULL_WIDTH_PX, Lens

_NEAR_MM = 12.0
_BLUR_PX = 1.1
"""Standard deviation of the lens' blur in pixels of the full picture."""

_SHIFT = 4
_SCALE = 1 << _SHIFT
_FAR_PX = 20000.0
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
    place = eye.robot_from_camera.translation_mm
    far_first = sorted(groups, key=lambda group: -float(np.linalg.norm(_middle(group) - place)))
    figures = [f for group in far_first for f in group if _may_be_seen(f, eye)]
    if not figures:
        return
    faces = _Faces(figures, eye, brush)
    for index in range(len(figures)):
        faces.draw(canvas, index)


def _middle(group: Sequence[Figure]) -> NDArray[np.float64]:
    return group[0].middle_mm if len(group) == 1 else np.mean([f.middle_mm for f in group], axis=0)


def _may_be_seen(figure: Figure, eye: Eye) -> bool:
    """Return whether a figure's middle is near enough to the camera's field of view."""
    x, y, z = eye.to_camera(figure.middle_mm[None])[0]
    radius = float(np.abs(figure.corners_mm - figure.middle_mm).max()) * 1.75
    if z + radius < _NEAR_MM:
        return False
    lens = eye.lens
    wide = 0.62 * lens.width_px / lens.focal_px
    tall = 0.62 * lens.height_px / lens.focal_px
    depth = max(z, 0.0) + radius
    return bool(abs(x) - radius < wide * depth and abs(y) - radius < tall * depth)


class _Faces:
    """All faces of some figures, projected and shaded together."""

    def __init__(self, figures: Sequence[Figure], eye: Eye, brush: Brush) -> None:
        self._figures = figures
        self._eye = eye
        counts = [len(f.corners_mm) for f in figures]
        self._starts = np.concatenate([[0], np.cumsum(counts)]).tolist()
        face_counts = [len(f.normals) for f in figures]
        self._face_starts = np.concatenate([[0], np.cumsum(face_counts)]).tolist()
        corners = np.concatenate([f.corners_mm for f in figures])
        camera = eye.to_camera(corners)
        self._depth = camera[:, 2]
        self._camera = camera
        self._pixels = _safe_pixels(camera, eye.lens)
        self._glare = [self._glare_px(f, brush) for f in figures]
        self._inner = self._inset_pixels(corners)
        normals = np.concatenate([f.normals for f in figures])
        centres = np.concatenate([f.centres_mm for f in figures])
        towards = eye.robot_from_camera.translation_mm - centres
        towards /= np.linalg.norm(towards, axis=1)[:, None]
        self._is_seen = (np.einsum("ij,ij->i", normals, towards) > 0.0).tolist()
        colours = np.repeat(np.array([f.colour for f in figures]), face_counts, axis=0)
        gloss = np.repeat(np.array([f.gloss for f in figures]), face_counts)
        light = shade(
            colours, gloss, normals, centres, towards, brush.glow,
            are_lights_on=brush.are_lights_on,
        )  # fmt: skip
        where = _safe_pixels(eye.to_camera(centres), eye.lens)
        self._levels = brush.expose(light, where).tolist()
        middles = np.array([f.middle_mm for f in figures])
        rim = 0.5 * brush.glow.around(middles)
        where = _safe_pixels(eye.to_camera(middles), eye.lens)
        self._rim_levels = brush.expose(rim, where).astype(int).tolist()
        low = np.minimum.reduceat(self._pixels, self._starts[:-1])
        high = np.maximum.reduceat(self._pixels, self._starts[:-1])
        size = (eye.lens.width_px, eye.lens.height_px)
        near = np.minimum.reduceat(self._depth, self._starts[:-1])
        self._is_cut = (near < _NEAR_MM).tolist()
        self._is_out = (((high < 0) | (low > size)).any(axis=1)).tolist()

    def draw(self, canvas: NDArray[np.uint8], index: int) -> None:
        """Draw one figure."""
        figure = self._figures[index]
        is_cut = self._is_cut[index]
        if self._is_out[index] and not is_cut:
            return
        start, first = self._starts[index], self._face_starts[index]
        if figure.solid.is_smooth and not is_cut:
            self._underlay(canvas, index)
        for number, face in enumerate(figure.solid.faces):
            if not self._is_seen[first + number]:
                continue
            level = self._levels[first + number]
            corners = slice(start + face[0], start + face[-1] + 1)
            if is_cut:
                self._draw_cut(canvas, corners, level)
                continue
            outline = self._pixels[corners]
            if figure.solid.is_top[number] and self._glare[index] > 0.0:
                rim = [min(255, a + b) for a, b in zip(level, self._rim_levels[index], strict=True)]
                _fill(canvas, outline, rim)
                outline = self._inner[corners]
            if figure.solid.is_notched and len(face) > 20:
                _fill_notched(canvas, outline, level)
            else:
                _fill(canvas, outline, level)

    def _underlay(self, canvas: NDArray[np.uint8], index: int) -> None:
        """Fill a round solid's silhouette first, so that no seam between facets shows."""
        first, end = self._face_starts[index], self._face_starts[index + 1]
        seen = [self._levels[f] for f in range(first, end) if self._is_seen[f]]
        if not seen:
            return
        level = [sum(channel) // len(seen) for channel in zip(*seen, strict=True)]
        points = self._pixels[self._starts[index] : self._starts[index + 1]]
        hull = cv2.convexHull(points.astype(np.float32))[:, 0]
        _fill(canvas, np.asarray(hull, np.float64), level)

    def _draw_cut(self, canvas: NDArray[np.uint8], corners: slice, level: list[int]) -> None:
        """Draw the part of a face that lies in front of the near plane."""
        points = self._camera[corners]
        kept: list[NDArray[np.float64]] = []
        for here, after in zip(points, np.roll(points, -1, axis=0), strict=True):
            if here[2] >= _NEAR_MM:
                kept.append(here)
            if (here[2] >= _NEAR_MM) != (after[2] >= _NEAR_MM):
                kept.append(here + (after - here) * ((_NEAR_MM - here[2]) / (after[2] - here[2])))
        if len(kept) > 2:
            _fill(canvas, self._eye.lens.project(np.array(kept)), level)

    def _glare_px(self, figure: Figure, brush: Brush) -> float:
        """Return how many pixels of its edge a block loses to the glare around it.

        The edge appears where the blurred step from the face to the surroundings
        passes half of what the sensor can show.
        """
        if not figure.takes_glare:
            return 0.0
        around = float(brush.glare(brush.glow.around(figure.middle_mm[None])).max())
        if around <= _CLIP_LEVEL:
            return 0.0
        lens_scale = self._eye.lens.width_px / FULL_WIDTH_PX
        return _BLUR_PX * lens_scale * _STANDARD.inv_cdf(1.0 - 0.5 * _CLIP_LEVEL / around)

    def _inset_pixels(self, corners: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pixels of all corners with those of glared top faces moved inwards."""
        if not any(self._glare):
            return self._pixels
        moved = corners.copy()
        for index, glare_px in enumerate(self._glare):
            if glare_px > 0.0:
                figure, part = self._figures[index], slice(*self._starts[index : index + 2])
                mm = glare_px * max(float(self._depth[part].mean()), 1.0) / self._eye.lens.focal_px
                moved[part] += figure.solid.inset @ figure.rotation.T * mm
        return _safe_pixels(self._eye.to_camera(moved), self._eye.lens)


def _safe_pixels(camera: NDArray[np.float64], lens: Lens) -> NDArray[np.float64]:
    """Project points, those behind the near plane as if they lay on it."""
    safe = camera.copy()
    safe[:, 2] = np.maximum(safe[:, 2], _NEAR_MM)
    return np.clip(lens.project(safe), -_FAR_PX, _FAR_PX)


def _fill(canvas: NDArray[np.uint8], outline: NDArray[np.float64], level: Sequence[int]) -> None:
    points = np.rint(np.clip(outline, -_FAR_PX, _FAR_PX) * _SCALE).astype(np.int32)
    cv2.fillConvexPoly(canvas, points, level, cv2.LINE_AA, _SHIFT)


def _fill_notched(
    canvas: NDArray[np.uint8], outline: NDArray[np.float64], level: Sequence[int]
) -> None:
    points = np.rint(np.clip(outline, -_FAR_PX, _FAR_PX) * _SCALE).astype(np.int32)
    cv2.fillPoly(canvas, [points], level, cv2.LINE_AA, _SHIFT)
