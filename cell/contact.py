"""Contact of fingers and blocks, seen from above: footprints, overlap, grip width.

Everything is convex and horizontal; heights are the caller's business. Points
are (x, y) in millimetres in the robot frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

Point = tuple[float, float]
Polygon = tuple[Point, ...]

_CIRCLE_CORNERS = 24


class Body(Protocol):
    """Anything that has an outline."""

    def polygon(self) -> Polygon:
        """Return the convex outline, counter-clockwise."""


@dataclass(frozen=True, slots=True)
class Outline:
    """A body of which only the convex outline is known."""

    corners: Polygon

    def polygon(self) -> Polygon:
        """Return the outline."""
        return self.corners


@dataclass(frozen=True, slots=True, kw_only=True)
class Footprint:
    """The outline of an upright body seen from above.

    Attributes:
        x_mm: Robot x of the centre.
        y_mm: Robot y of the centre.
        yaw_deg: Turn of the length axis from robot x, counter-clockwise.
        length_mm: Size along the length axis.
        width_mm: Size across it.
        is_round: Whether it is a circle of diameter `width_mm`.
    """

    x_mm: float
    y_mm: float
    yaw_deg: float
    length_mm: float
    width_mm: float
    is_round: bool = False

    def polygon(self) -> Polygon:
        """Return the outline, counter-clockwise; a circle as a circumscribed polygon."""
        if self.is_round:
            radius = 0.5 * self.width_mm / math.cos(math.pi / _CIRCLE_CORNERS)
            return tuple(
                (
                    self.x_mm + radius * math.cos(2 * math.pi * k / _CIRCLE_CORNERS),
                    self.y_mm + radius * math.sin(2 * math.pi * k / _CIRCLE_CORNERS),
                )
                for k in range(_CIRCLE_CORNERS)
            )
        cos, sin = math.cos(math.radians(self.yaw_deg)), math.sin(math.radians(self.yaw_deg))
        half_l, half_w = 0.5 * self.length_mm, 0.5 * self.width_mm
        return tuple(
            (self.x_mm + cos * u - sin * w, self.y_mm + sin * u + cos * w)
            for u, w in (
                (half_l, half_w),
                (-half_l, half_w),
                (-half_l, -half_w),
                (half_l, -half_w),
            )
        )

    @property
    def radius_mm(self) -> float:
        """Radius of a circle about the centre that holds the outline."""
        return 0.5 * math.hypot(self.length_mm, self.width_mm)

    def contains(self, x_mm: float, y_mm: float) -> bool:
        """Return whether a point lies inside."""
        dx, dy = x_mm - self.x_mm, y_mm - self.y_mm
        if self.is_round:
            return math.hypot(dx, dy) <= 0.5 * self.width_mm
        cos, sin = math.cos(math.radians(self.yaw_deg)), math.sin(math.radians(self.yaw_deg))
        along, across = cos * dx + sin * dy, -sin * dx + cos * dy
        return abs(along) <= 0.5 * self.length_mm and abs(across) <= 0.5 * self.width_mm


@dataclass(frozen=True, slots=True, kw_only=True)
class Jaw:
    """The pair of fingers seen from above.

    Attributes:
        x_mm: Robot x of the middle between the fingers.
        y_mm: Robot y of the middle between the fingers.
        axis: Unit vector along which the fingers close.
        finger_width_mm: Size of a finger across that axis.
        finger_thickness_mm: Size of a finger along that axis.
    """

    x_mm: float
    y_mm: float
    axis: Point
    finger_width_mm: float
    finger_thickness_mm: float

    @property
    def axis_deg(self) -> float:
        """Direction of the closing axis from robot x."""
        return math.degrees(math.atan2(self.axis[1], self.axis[0]))

    def fingers(self, opening_mm: float) -> tuple[Footprint, Footprint]:
        """Return both fingers' footprints at an opening."""
        offset = 0.5 * (opening_mm + self.finger_thickness_mm)
        left, right = (
            Footprint(
                x_mm=self.x_mm + side * offset * self.axis[0],
                y_mm=self.y_mm + side * offset * self.axis[1],
                yaw_deg=self.axis_deg,
                length_mm=self.finger_thickness_mm,
                width_mm=self.finger_width_mm,
            )
            for side in (1.0, -1.0)
        )
        return left, right

    def span(self, body: Body) -> tuple[float, float] | None:
        """Return from where to where a body reaches along the closing axis.

        Only the part between the fingers' sides counts.

        Returns:
            Least and greatest coordinate along the axis from the jaw's middle, in
            millimetres, or None when the body is beside the fingers' path.
        """
        half = 0.5 * self.finger_width_mm
        points = [self._to_jaw(point) for point in body.polygon()]
        points = _clip(_clip(points, half, 1.0), half, -1.0)
        if not points:
            return None
        along = [u for u, _ in points]
        return min(along), max(along)

    def _to_jaw(self, point: Point) -> Point:
        dx, dy = point[0] - self.x_mm, point[1] - self.y_mm
        ax, ay = self.axis
        return ax * dx + ay * dy, -ay * dx + ax * dy


def _clip(points: list[Point], limit: float, sign: float) -> list[Point]:
    """Clip a polygon to sign * w <= limit (Sutherland and Hodgman)."""
    kept: list[Point] = []
    for index, (u1, w1) in enumerate(points):
        u0, w0 = points[index - 1]
        inside0, inside1 = sign * w0 <= limit, sign * w1 <= limit
        if inside0 != inside1:
            share = (sign * limit - w0) / (w1 - w0)
            kept.append((u0 + share * (u1 - u0), sign * limit))
        if inside1:
            kept.append((u1, w1))
    return kept


def push_out(moved: Polygon, fixed: Polygon) -> Point | None:
    """Return the shortest shift that frees one convex outline from another.

    Separating axis test over the edge normals of both outlines.

    Returns:
        The shift of `moved` in millimetres, or None when they do not overlap.
    """
    best: Point | None = None
    best_depth = math.inf
    for nx, ny in (*_normals(moved), *_normals(fixed)):
        moved_low, moved_high = _project(moved, nx, ny)
        fixed_low, fixed_high = _project(fixed, nx, ny)
        forward, backward = fixed_high - moved_low, moved_high - fixed_low
        if forward <= 1e-9 or backward <= 1e-9:
            return None
        depth, sign = (forward, 1.0) if forward < backward else (backward, -1.0)
        if depth < best_depth:
            best_depth = depth
            best = (sign * depth * nx, sign * depth * ny)
    return best


def _normals(polygon: Polygon) -> list[Point]:
    normals = []
    for index, (x1, y1) in enumerate(polygon):
        x0, y0 = polygon[index - 1]
        length = math.hypot(x1 - x0, y1 - y0)
        normals.append(((y1 - y0) / length, (x0 - x1) / length))
    return normals


def _project(polygon: Polygon, nx: float, ny: float) -> tuple[float, float]:
    values = [x * nx + y * ny for x, y in polygon]
    return min(values), max(values)


def aligned_yaw_deg(block_yaw_deg: float, axis_deg: float) -> float:
    """Return the yaw of a box whose nearest face lies flat on closing fingers.

    The faces are parallel to the fingers when yaw and closing axis differ by a
    multiple of 90 deg.
    """
    off = (block_yaw_deg - axis_deg + 45.0) % 90.0 - 45.0
    return block_yaw_deg - off
