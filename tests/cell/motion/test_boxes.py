from __future__ import annotations

import random
from math import dist

import pytest

from cell.kinematics import Point
from cell.motion.boxes import Bounds, segment_distance_mm, separations

BOX: Bounds = (-10.0, -20.0, -30.0, 10.0, 20.0, 30.0)


@pytest.mark.parametrize(
    ("start", "end", "expected"),
    [
        ((0.0, 0.0, 40.0), (5.0, 5.0, 50.0), 10.0),
        ((-50.0, 0.0, 0.0), (50.0, 0.0, 0.0), 0.0),
        ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 0.0),
        ((13.0, 24.0, -100.0), (13.0, 24.0, 100.0), 5.0),
        ((20.0, -100.0, 40.0), (20.0, 100.0, 40.0), 200**0.5),
        ((13.0, 24.0, 42.0), (13.0, 24.0, 42.0), 13.0),
        ((30.0, 20.0, 0.0), (10.0, 40.0, 0.0), 200**0.5),
    ],
)
def test_distance_of_a_segment_is_that_of_its_nearest_point(
    start: Point, end: Point, expected: float
) -> None:
    assert segment_distance_mm(start, end, BOX) == pytest.approx(expected, abs=1e-9)
    assert segment_distance_mm(end, start, BOX) == pytest.approx(expected, abs=1e-9)


def test_distance_agrees_with_dense_sampling() -> None:
    source = random.Random(11)

    def point() -> Point:
        return (source.uniform(-60, 60), source.uniform(-60, 60), source.uniform(-60, 60))

    for _ in range(300):
        start, end = point(), point()
        sampled = min(
            point_distance(
                tuple(s + (e - s) * i / 500 for s, e in zip(start, end, strict=True)), BOX
            )
            for i in range(501)
        )
        exact = segment_distance_mm(start, end, BOX)
        assert exact <= sampled + 1e-9
        assert exact == pytest.approx(sampled, abs=dist(start, end) / 500)


def test_separations_tell_each_face() -> None:
    beside: Bounds = (12.0, -5.0, -5.0, 20.0, 5.0, 5.0)
    assert separations(beside, BOX) == (2.0, -30.0, -25.0, -25.0, -35.0, -35.0)
    inside: Bounds = (-1.0, -1.0, -1.0, 1.0, 1.0, 1.0)
    assert max(separations(inside, BOX)) < 0.0


def point_distance(point: tuple[float, ...], box: Bounds) -> float:
    nearest = [
        min(max(at, low), high) for at, low, high in zip(point, box[:3], box[3:], strict=True)
    ]
    return dist(point, nearest)
