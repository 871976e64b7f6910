from __future__ import annotations

import math

import pytest

from cell.twin.bodies import JointTuple
from cell.twin.emulators.melfa_r3.paths import Braking, JointCourse, PlannedPath, Trapezoid

START: JointTuple = (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)
END: JointTuple = (10.0, -5.0, 80.0, 1.0, 85.0, 40.0)


def _path(start_s: float = 2.0) -> PlannedPath:
    timing = Trapezoid(100.0, 50.0, 200.0)
    return PlannedPath(JointCourse(START, END), timing, start_s, timing.braking)


@pytest.mark.parametrize(
    ("way", "speed", "acceleration", "duration_s"),
    [
        (100.0, 50.0, 200.0, 100.0 / 50.0 + 50.0 / 200.0),
        (20.0, 250.0, 3000.0, 2 * math.sqrt(20.0 / 3000.0)),
        (12.5, 50.0, 200.0, 0.5),
    ],
    ids=["long way", "way too short for the speed", "just long enough"],
)
def test_a_trapezoid_takes_as_long_as_the_formula_says(
    way: float, speed: float, acceleration: float, duration_s: float
) -> None:
    assert Trapezoid(way, speed, acceleration).duration_s == pytest.approx(duration_s, rel=1e-12)


@pytest.mark.parametrize("way", [1.0, 12.5, 100.0])
def test_a_trapezoid_starts_and_ends_at_rest_and_never_goes_back(way: float) -> None:
    timing = Trapezoid(way, 50.0, 200.0)
    times = [timing.duration_s * i / 200 for i in range(201)]
    shares = [timing.share(time_s) for time_s in times]
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    assert timing.rate(0.0) == 0.0
    assert timing.rate(timing.duration_s) == 0.0
    assert max(timing.rate(time_s) for time_s in times) * way <= 50.0 + 1e-9


def test_the_rate_is_the_slope_of_the_share() -> None:
    timing = Trapezoid(100.0, 50.0, 200.0)
    for time_s in (0.1, 0.2, 1.0, 2.0, 2.2):
        slope = (timing.share(time_s + 1e-6) - timing.share(time_s - 1e-6)) / 2e-6
        assert timing.rate(time_s) == pytest.approx(slope, rel=1e-6)


def test_a_stretched_trapezoid_has_the_same_shape() -> None:
    timing = Trapezoid(100.0, 50.0, 200.0)
    slow = timing.stretched_to(9.0)
    assert slow.duration_s == pytest.approx(9.0, rel=1e-12)
    for share in (0.1, 0.5, 0.9):
        assert slow.share(share * 9.0) == pytest.approx(timing.share(share * timing.duration_s))


def test_a_path_ends_exactly_at_its_end_whatever_the_time_rounds_to() -> None:
    path = _path()
    assert path.at(path.end_s) is END
    assert path.at(path.end_s + 1e-9) is END
    assert path.at(1e9) is END
    assert path.at(path.start_s) is START
    assert path.at(0.0) is START


def test_a_path_is_where_its_timing_says_in_between() -> None:
    path = _path()
    middle = path.at((path.start_s + path.end_s) / 2)
    assert middle == pytest.approx([(a + b) / 2 for a, b in zip(START, END, strict=True)])


def test_a_braked_path_goes_on_from_where_the_arm_is_and_comes_to_rest() -> None:
    path = _path()
    stop_s = path.start_s + 1.0
    braked = path.braked(stop_s)
    assert braked.at(stop_s) == path.at(stop_s)
    assert braked.end_s == pytest.approx(stop_s + 0.25)
    assert braked.end_deg[0] == pytest.approx(path.at(stop_s)[0] + 10.0 * 0.5 * 0.5 * 0.25)
    assert braked.at(braked.end_s) == braked.end_deg
    before, after = path.at(stop_s - 1e-6)[0], braked.at(stop_s + 1e-6)[0]
    assert after - before == pytest.approx(2e-6 * 10.0 * 0.5, rel=1e-3)


def test_a_path_braked_before_its_start_does_not_move() -> None:
    braked = _path().braked(1.0)
    assert braked.end_deg == START
    assert braked.end_s == 1.0


def test_braking_never_goes_beyond_the_end() -> None:
    braking = Braking(0.9, 1.0, 1.0)
    assert braking.end_share == 1.0
    assert braking.share(0.5) == 1.0
