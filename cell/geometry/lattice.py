"""From lattice cells to millimetres on the playground and back."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LatticeMap:
    """The plane map from lattice to robot coordinates.

    x = T·l with T = (Ms·Mr·Mt)ᵀ for row vectors: scale by the step, turn by the
    angle, shift by the origin. With 90 deg and 20 mm it is
    [[0, -20, ox], [20, 0, oy], [0, 0, 1]].

    Attributes:
        step_mm: Distance of two neighbouring lattice points.
        angle_deg: Angle from robot X to lattice x, counter-clockwise.
        origin_x_mm: Robot x of lattice point (0, 0).
        origin_y_mm: Robot y of lattice point (0, 0).
    """

    step_mm: float
    angle_deg: float
    origin_x_mm: float
    origin_y_mm: float

    def to_robot(self, x: float, y: float) -> tuple[float, float]:
        """Return robot x and y in millimetres of a lattice point."""
        cos, sin = _cos_sin(self.angle_deg)
        step = self.step_mm
        return (
            step * (cos * x - sin * y) + self.origin_x_mm,
            step * (sin * x + cos * y) + self.origin_y_mm,
        )

    def to_lattice(self, x_mm: float, y_mm: float) -> tuple[float, float]:
        """Return the (fractional) lattice point of robot x and y."""
        cos, sin = _cos_sin(self.angle_deg)
        dx = (x_mm - self.origin_x_mm) / self.step_mm
        dy = (y_mm - self.origin_y_mm) / self.step_mm
        return cos * dx + sin * dy, -sin * dx + cos * dy


def _cos_sin(angle_deg: float) -> tuple[float, float]:
    """Return cosine and sine, exact at multiples of 90 deg."""
    turns = angle_deg / 90.0
    if turns == int(turns):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(turns) % 4]
    angle = math.radians(angle_deg)
    return math.cos(angle), math.sin(angle)
