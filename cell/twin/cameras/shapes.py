"""Solids: the convex pieces that everything above the table is drawn from.

A solid is a template in its own frame; drawing places it by a rigid transform. Its
faces are convex polygons, except a face marked as a notched one. Long edges are
divided, so that the lens can bend them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Colour = tuple[float, float, float]
"""Reflectance R G B, 0..1."""

_DIVIDE_MM = 17.0
_ROUND_FACETS = 20
_ARCH_STEPS = 10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """A template of faces.

    Attributes:
        vertices_mm: Corners, (n, 3).
        inset: Directions (n, 3) in which corners of the top face give way to the glare
            of a bright surrounding; zero for all others.
        spans: First corner of each face and the one after its last; corners go
            counter-clockwise seen from outside.
        normals: Outward unit normals, (m, 3).
        centres_mm: Centres of the faces, (m, 3).
        is_top: Faces that give way to glare.
        is_notched: Whether any face is not convex.
        is_smooth: Whether the faces approximate a round surface.
        middle_mm: Middle of the bounding box, (3,).
        radius_mm: Greatest distance of a corner from the middle.
    """

    vertices_mm: NDArray[np.float64]
    inset: NDArray[np.float64]
    spans: tuple[tuple[int, int], ...]
    normals: NDArray[np.float64]
    centres_mm: NDArray[np.float64]
    is_top: tuple[bool, ...]
    is_notched: bool
    is_smooth: bool
    middle_mm: NDArray[np.float64]
    radius_mm: float


class _Builder:
    def __init__(self) -> None:
        self.vertices: list[NDArray[np.float64]] = []
        self.inset: list[NDArray[np.float64]] = []
        self.spans: list[tuple[int, int]] = []
        self.normals: list[NDArray[np.float64]] = []
        self.is_top: list[bool] = []

    def face(
        self,
        corners: Sequence[NDArray[np.float64]],
        normal: NDArray[np.float64],
        inset: Sequence[NDArray[np.float64]] | None = None,
    ) -> None:
        first = len(self.vertices)
        self.vertices.extend(corners)
        self.inset.extend(inset if inset is not None else [np.zeros(3)] * len(corners))
        self.spans.append((first, first + len(corners)))
        self.normals.append(normal)
        self.is_top.append(inset is not None)

    def solid(self, *, is_notched: bool = False, is_smooth: bool = False) -> Solid:
        vertices = np.array(self.vertices)
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        return Solid(
            vertices_mm=vertices,
            inset=np.array(self.inset),
            spans=tuple(self.spans),
            normals=np.array(self.normals),
            centres_mm=np.array([vertices[start:end].mean(axis=0) for start, end in self.spans]),
            is_top=tuple(self.is_top),
            is_notched=is_notched,
            is_smooth=is_smooth,
            middle_mm=middle,
            radius_mm=float(np.linalg.norm(vertices - middle, axis=1).max()),
        )


def _divided(
    corners: Sequence[NDArray[np.float64]], step_mm: float = _DIVIDE_MM
) -> list[NDArray[np.float64]]:
    """Return a polygon with its edges cut into pieces of at most `step_mm`."""
    points: list[NDArray[np.float64]] = []
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        pieces = max(1, math.ceil(float(np.linalg.norm(end - start)) / step_mm))
        points.extend(start + (end - start) * (piece / pieces) for piece in range(pieces))
    return points


def _normal(corners: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    cross = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return np.asarray(cross / np.linalg.norm(cross))


def _rectangle_inset(
    points: Sequence[NDArray[np.float64]], half_x: float, half_y: float
) -> list[NDArray[np.float64]]:
    """Return inward directions for points on a rectangle's outline."""
    inset = []
    for point in points:
        on_x = abs(abs(point[0]) - half_x) < 1e-9
        on_y = abs(abs(point[1]) - half_y) < 1e-9
        inset.append(
            np.array([-np.sign(point[0]) * on_x, -np.sign(point[1]) * on_y, 0.0], np.float64)
        )
    return inset


@lru_cache(maxsize=64)
def box(length_mm: float, width_mm: float, height_mm: float, step_mm: float = _DIVIDE_MM) -> Solid:
    """Return a box centred on z, from z = 0 up; length along x, width along y."""
    x, y, z = length_mm / 2, width_mm / 2, height_mm
    low = [np.array(p) for p in ((-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0))]
    high = [p + (0.0, 0.0, z) for p in low]
    builder = _Builder()
    for side in range(4):
        after = (side + 1) % 4
        corners = [low[side], low[after], high[after], high[side]]
        builder.face(_divided(corners, step_mm), _normal(corners))
    top = _divided(high, step_mm)
    builder.face(top, np.array([0.0, 0.0, 1.0]), _rectangle_inset(top, x, y))
    bottom = _divided(low[::-1], step_mm)
    builder.face(bottom, np.array([0.0, 0.0, -1.0]))
    return builder.solid()


@lru_cache(maxsize=64)
def frustum(
    lower_mm: float, upper_mm: float, height_mm: float, facets: int = _ROUND_FACETS
) -> Solid:
    """Return a round frustum about z from z = 0 up, with the given radii."""
    angles = 2 * np.pi * np.arange(facets) / facets
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(facets)], axis=1)
    low, high = ring * lower_mm, ring * upper_mm + (0.0, 0.0, height_mm)
    builder = _Builder()
    for side in range(facets):
        after = (side + 1) % facets
        corners = [low[side], low[after], high[after], high[side]]
        builder.face(corners, _normal(corners))
    builder.face(list(high), np.array([0.0, 0.0, 1.0]), list(-ring))
    builder.face(list(low[::-1]), np.array([0.0, 0.0, -1.0]))
    return builder.solid(is_smooth=True)


@lru_cache(maxsize=64)
def taper(
    lower_mm: tuple[float, float],
    upper_mm: tuple[float, float],
    height_mm: float,
    chamfer: float = 0.3,
) -> Solid:
    """Return a tapered bar about z with chamfered edges: the shape of a cast arm link.

    Args:
        lower_mm: Width along x and y at z = 0.
        upper_mm: Width along x and y at z = `height_mm`.
        height_mm: Length along z.
        chamfer: Share of the half width that the chamfer takes.
    """
    keep = 1.0 - chamfer
    outline = np.array(
        [
            (1, -keep), (1, keep), (keep, 1), (-keep, 1),
            (-1, keep), (-1, -keep), (-keep, -1), (keep, -1),
        ]
    )  # fmt: skip
    low = np.c_[outline * lower_mm, np.zeros(8)] * (0.5, 0.5, 1.0)
    high = np.c_[outline * upper_mm, np.full(8, height_mm)] * (0.5, 0.5, 1.0)
    builder = _Builder()
    for side in range(8):
        after = (side + 1) % 8
        corners = [low[side], low[after], high[after], high[side]]
        builder.face(_divided(corners, 60.0), _normal(corners))
    builder.face(list(high), np.array([0.0, 0.0, 1.0]))
    builder.face(list(low[::-1]), np.array([0.0, 0.0, -1.0]))
    return builder.solid()


def _on_sphere(tilt_rad: float, turn_rad: float) -> NDArray[np.float64]:
    cos = math.cos(tilt_rad)
    return np.array([cos * math.cos(turn_rad), cos * math.sin(turn_rad), math.sin(tilt_rad)])


@lru_cache(maxsize=8)
def ball(radius_mm: float) -> Solid:
    """Return a ball about the origin."""
    bands, facets = 6, 12
    tilt = np.pi * (np.arange(bands + 1) / bands - 0.5)
    turn = 2 * np.pi * np.arange(facets) / facets
    builder = _Builder()
    for band in range(bands):
        for side in range(facets):
            after = turn[(side + 1) % facets]
            lower, upper = tilt[band], tilt[band + 1]
            places = ((lower, turn[side]), (lower, after), (upper, after), (upper, turn[side]))
            corners = [radius_mm * _on_sphere(t, a) for t, a in places]
            centre = sum(corners) / 4.0
            builder.face(corners, np.asarray(centre / np.linalg.norm(centre)))
    return builder.solid(is_smooth=True)


@lru_cache(maxsize=16)
def bridge(length_mm: float, width_mm: float, height_mm: float, arch_mm: float) -> Solid:
    """Return a box with a round opening of radius `arch_mm` along y, at the bottom's middle.

    The inside of the opening comes first, so that the faces drawn after it cover what
    they hide.
    """
    x, y, z = length_mm / 2, width_mm / 2, height_mm
    angles = np.pi * np.arange(_ARCH_STEPS + 1) / _ARCH_STEPS
    arch = np.stack([arch_mm * np.cos(angles), arch_mm * np.sin(angles)], axis=1)
    builder = _Builder()
    for start, end in zip(arch[:-1], arch[1:], strict=True):
        corners = [
            np.array([start[0], -y, start[1]]),
            np.array([start[0], y, start[1]]),
            np.array([end[0], y, end[1]]),
            np.array([end[0], -y, end[1]]),
        ]
        inward = -(start + end) / np.linalg.norm(start + end)
        builder.face(corners, np.array([inward[0], 0.0, inward[1]]))
    outline = [(-x, 0.0), *map(tuple, arch[::-1]), (x, 0.0), (x, z), (-x, z)]
    front = [np.array([px, -y, pz]) for px, pz in outline]
    back = [np.array([px, y, pz]) for px, pz in outline[::-1]]
    builder.face(_divided(front), np.array([0.0, -1.0, 0.0]))
    builder.face(_divided(back), np.array([0.0, 1.0, 0.0]))
    for sign in (-1.0, 1.0):
        corners = [
            np.array([sign * x, -sign * y, 0.0]),
            np.array([sign * x, sign * y, 0.0]),
            np.array([sign * x, sign * y, z]),
            np.array([sign * x, -sign * y, z]),
        ]
        builder.face(_divided(corners), np.array([sign, 0.0, 0.0]))
    top = _divided([np.array(p) for p in ((-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z))])
    builder.face(top, np.array([0.0, 0.0, 1.0]), _rectangle_inset(top, x, y))
    return builder.solid(is_notched=True)
