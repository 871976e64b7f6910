"""The space that a chain of links takes up: a thick segment along each link.

For any arm whose kinematics tells the points along it. A link whose radius is 0 stands
still (a column, a base) and is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import dist

from cell.kinematics.arm import ArmKinematics
from cell.motion.boxes import Bounds, segment_distance_mm, separations

Point = tuple[float, float, float]
Capsule = tuple[Point, Point, float]

_GRID = 5
"""Positions of each joint at which its reach is measured, both limits among them."""
_ALLOWANCE = 1.1
"""Added to a measured reach, for what lies between the grid's positions."""
_NUDGE = 1e-4
_FAR_MM = 40.0
"""Beyond this a lower bound of a distance does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainShape:
    """How thick the links are.

    Attributes:
        radii_mm: Of each link, between one point along the arm and the next; 0 leaves it out.
        tip_mm: How far the hand reaches past the tool point, empty.
        loaded_tip_mm: The same with something between the fingers.
    """

    radii_mm: tuple[float, ...]
    tip_mm: float
    loaded_tip_mm: float


class ChainHull:
    """The bodies of one arm, and how far they move.

    Args:
        arm: The arm's kinematics.
        shape: How thick its links are.
        margin_mm: Added to every radius.

    Attributes:
        reach: How far a link's axis moves at most for a radian (or a millimetre) of each joint.
    """

    def __init__(self, arm: ArmKinematics, shape: ChainShape, *, margin_mm: float) -> None:
        self._arm = arm
        self._shape = shape
        self._margin_mm = margin_mm
        self.reach = _reach(arm)

    def bodies(self, values: tuple[float, ...], *, is_loaded: bool) -> list[Capsule]:
        """Return the bodies at joint positions; the last is the hand, whose end is cut flush.

        The round end of the hand's body reaches past the tool point by the shape's tip and
        no further.
        """
        points = self._arm.link_points_mm(values)
        tip_mm = self._shape.loaded_tip_mm if is_loaded else self._shape.tip_mm
        found = []
        for start, end, radius_mm in zip(points, points[1:], self._shape.radii_mm, strict=False):
            if radius_mm <= 0.0:
                continue
            if end is points[-1]:
                end = _drawn_back(start, end, radius_mm - tip_mm)
            found.append((start, end, radius_mm + self._margin_mm))
        return found

    def way_mm(self, first: tuple[float, ...], last: tuple[float, ...]) -> float:
        """Return how far any body moves at most between two stances, joints moving evenly."""
        return sum(abs(b - a) * reach for a, b, reach in zip(first, last, self.reach, strict=True))


def clearance_mm(body: Capsule, box: Bounds) -> float:
    """Return how far a body is from a box, negative by how deep it is in.

    Far away it is a lower bound; inside, the way out through the nearest face.
    """
    start, end, radius_mm = body
    bounds = (
        min(start[0], end[0]) - radius_mm, min(start[1], end[1]) - radius_mm,
        min(start[2], end[2]) - radius_mm, max(start[0], end[0]) + radius_mm,
        max(start[1], end[1]) + radius_mm, max(start[2], end[2]) + radius_mm,
    )  # fmt: skip
    apart = max(separations(bounds, box))
    if apart > _FAR_MM:
        return apart
    distance = segment_distance_mm(start, end, box) - radius_mm
    return distance if distance >= 0.0 else min(apart, distance)


def _drawn_back(start: Point, end: Point, by_mm: float) -> Point:
    """Return the end of a segment, drawn back towards its start but not past it."""
    length = dist(start, end)
    share = 0.0 if length <= by_mm or length == 0.0 else 1.0 - by_mm / length
    return (
        start[0] + share * (end[0] - start[0]),
        start[1] + share * (end[1] - start[1]),
        start[2] + share * (end[2] - start[2]),
    )


def _reach(arm: ArmKinematics) -> tuple[float, ...]:
    """Measure, all over the joints' ranges, how far the links move with each joint.

    Returns:
        Millimetres a unit (degree or millimetre) of each joint.
    """
    steps = [
        [low + (high - low) * index / (_GRID - 1) for index in range(_GRID)]
        for low, high in zip(arm.joint_min, arm.joint_max, strict=True)
    ]
    most = [0.0] * len(steps)
    for values in product(*steps):
        here = arm.link_points_mm(values)
        for joint in range(len(steps)):
            nudged = (*values[:joint], values[joint] + _NUDGE, *values[joint + 1 :])
            way = max(dist(p, q) for p, q in zip(here, arm.link_points_mm(nudged), strict=True))
            most[joint] = max(most[joint], way / _NUDGE)
    return tuple(_ALLOWANCE * value for value in most)
