"""Physical facts of the blocks, and the room they need.

Lattice axes: x to the right, along which the fingers close; y up, along which a
block's length lies. Figures in millimetres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

LATTICE_STEP_MM = 20.0
"""Distance of two neighbouring lattice points (section 2.4.2 of the source)."""

FINGER_REACH_MM = 38.0
"""How far from a block's centre a finger reaches while it opens: half of the opening of
60 mm on approach and a finger of 8 mm."""

FINGER_WIDTH_MM = 20.0
"""Size of a finger along the face it grips."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of block at yaw 0.

    Attributes:
        name: Such as `cube`.
        length_mm: Size along lattice y.
        width_mm: Size along lattice x, across which it is gripped.
    """

    name: str
    length_mm: float
    width_mm: float


KINDS = {
    kind.name: kind
    for kind in (
        Kind("cube", 33.0, 33.0),
        Kind("cylinder", 33.0, 33.0),
        Kind("bridge", 100.0, 33.0),
    )
}
COLOURS = ("red", "green", "blue", "yellow", "natural")
BACKGROUNDS = ("black", "white", "mash", "water", "forest")
VIEW_SIZES = ((640, 480), (800, 600), (1024, 768), (1280, 960))
VIEW_FORMATS = ("mif", "ppm", "pgm", "png", "jpeg")

Clash = Literal["overlap", "fingers"]

_Shape = tuple[str, bool]
_Rectangle = tuple[float, float, float, float]


def shape_of(kind: str, yaw_deg: float) -> _Shape:
    """Return what the room of a block depends on: its kind and whether it lies across."""
    return kind, yaw_deg % 180.0 == 90.0


@lru_cache(maxsize=64)
def border_steps(shape: _Shape) -> tuple[int, int]:
    """Return how many lattice steps a block must keep from the world's border, in x and y.

    The playground reaches one step past the outermost lattice points, and a block must
    not stick out of it: a cube may lie on any point, a bridge two steps from its ends.
    """
    half_x, half_y = _half_sizes(shape)
    return (
        max(math.ceil(half_x / LATTICE_STEP_MM - 1), 0),
        max(math.ceil(half_y / LATTICE_STEP_MM - 1), 0),
    )


@lru_cache(maxsize=4096)
def clash(first: _Shape, second: _Shape, dx_mm: float, dy_mm: float) -> Clash | None:
    """Say whether two blocks get in each other's way.

    Args:
        first: Shape of the one.
        second: Shape of the other.
        dx_mm: Its centre's distance from the first one's along lattice x.
        dy_mm: The same along lattice y.

    Returns:
        `overlap` if the blocks would lie in each other, `fingers` if one lies where a
        finger must stand to grip the other, else None.
    """
    here, there = _body(first, 0.0, 0.0), _body(second, dx_mm, dy_mm)
    if _meet(here, there):
        return "overlap"
    if any(_meet(zone, there) for zone in _finger_zones(first, 0.0, 0.0)):
        return "fingers"
    if any(_meet(zone, here) for zone in _finger_zones(second, dx_mm, dy_mm)):
        return "fingers"
    return None


def _half_sizes(shape: _Shape) -> tuple[float, float]:
    kind, is_across = shape
    half_x, half_y = KINDS[kind].width_mm / 2, KINDS[kind].length_mm / 2
    return (half_y, half_x) if is_across else (half_x, half_y)


def _body(shape: _Shape, x: float, y: float) -> _Rectangle:
    half_x, half_y = _half_sizes(shape)
    return x - half_x, y - half_y, x + half_x, y + half_y


def _finger_zones(shape: _Shape, x: float, y: float) -> tuple[_Rectangle, _Rectangle]:
    kind, is_across = shape
    edge, half = KINDS[kind].width_mm / 2, FINGER_WIDTH_MM / 2
    if is_across:
        return (
            (x - half, y - FINGER_REACH_MM, x + half, y - edge),
            (x - half, y + edge, x + half, y + FINGER_REACH_MM),
        )
    return (
        (x - FINGER_REACH_MM, y - half, x - edge, y + half),
        (x + edge, y - half, x + FINGER_REACH_MM, y + half),
    )


def _meet(a: _Rectangle, b: _Rectangle) -> bool:
    """Whether two rectangles share an area; touching is allowed."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
