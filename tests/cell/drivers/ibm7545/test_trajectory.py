"""Cubic segments through via points, their times and their speeds."""

from __future__ import annotations

from math import dist

import pytest

from cell.drivers.ibm7545.pulses import positions_of, to_joints, to_pulses, words_of
from cell.drivers.ibm7545.trajectory import Pace, Trajectory, joint_course, line_course
from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from tests.cell.drivers.ibm7545.bench import KINEMATICS

PACE = Pace((45.0, 50.0, 100.0, 70.0), 100.0, 100.0, 0.2)
_DT = 1e-5


def _speed(trajectory: Trajectory, time_s: float, joint: int) -> float:
    before, after = trajectory.at(time_s - _DT), trajectory.at(time_s + _DT)
    return (after[joint] - before[joint]) / (2 * _DT)


def test_it_passes_every_via_point_and_rests_at_both_ends() -> None:
    trajectory = Trajectory([(0.0, 5.0), (10.0, 5.0), (30.0, -5.0)], [1.0, 2.0])
    assert trajectory.at(0.0) == (0.0, 5.0)
    assert trajectory.at(1.0) == pytest.approx((10.0, 5.0))
    assert trajectory.at(3.0) == trajectory.at(99.0) == trajectory.end == (30.0, -5.0)
    for time_s in (_DT, 3.0 - _DT):
        assert _speed(trajectory, time_s, 0) == pytest.approx(0.0, abs=1e-2)


@pytest.mark.parametrize(
    ("points", "speed"),
    [((0.0, 10.0, 30.0), 10.0), ((0.0, 10.0, 0.0), 0.0), ((0.0, 10.0, 10.0), 0.0)],
)
def test_the_speed_at_a_via_point_follows_the_rule(
    points: tuple[float, float, float], speed: float
) -> None:
    # Mean slopes 10 and 10 average to 10; a change of sign or a slope of zero gives rest.
    trajectory = Trajectory([(p,) for p in points], [1.0, 2.0])
    assert _speed(trajectory, 1.0, 0) == pytest.approx(speed, abs=1e-2)


def test_speed_is_continuous_where_segments_meet() -> None:
    trajectory = Trajectory([(0.0,), (4.0,), (12.0,), (14.0,)], [0.5, 0.7, 0.4])
    for time_s in (0.5, 1.2):
        before = (trajectory.at(time_s)[0] - trajectory.at(time_s - _DT)[0]) / _DT
        after = (trajectory.at(time_s + _DT)[0] - trajectory.at(time_s)[0]) / _DT
        assert before == pytest.approx(after, abs=1e-2)


@pytest.mark.parametrize(
    ("end", "seconds"),
    [((90, 0, 0, 0), 2.2), ((0, 50, 0, 0), 1.2), ((0, 0, -200, 0), 2.2), ((45, 50, -50, 140), 2.2)],
)
def test_a_segment_takes_its_slowest_joints_time_and_a_fifth_of_a_second(
    end: tuple[float, ...], seconds: float
) -> None:
    course = joint_course(JointPositions((0.0, 0.0, 0.0, 0.0)), JointPositions(end), PACE)
    assert course.durations_s == pytest.approx((seconds,))


def test_a_line_is_straight_within_a_tenth_of_a_millimetre_between_its_via_points() -> None:
    start = JointPositions((30.0, 60.0, -50.0, 0.0))
    first = KINEMATICS.forward(start)
    target = Pose(first.x_mm - 150, first.y_mm - 120, -120, 180, 0, first.c_deg + 20)
    course = line_course(KINEMATICS, start, target, 0, PACE, via_s=0.05)
    trajectory = Trajectory([p.values for p in course.points], course.durations_s)
    a = (first.x_mm, first.y_mm, first.z_mm)
    b = (target.x_mm, target.y_mm, target.z_mm)
    length = dist(a, b)
    for index in range(401):
        joints = trajectory.at(trajectory.duration_s * index / 400)
        pose = KINEMATICS.forward(JointPositions(joints))
        p = (pose.x_mm, pose.y_mm, pose.z_mm)
        along = sum((q - r) * (s - r) for q, r, s in zip(p, a, b, strict=True)) / length
        away = max(0.0, dist(p, a) ** 2 - along**2) ** 0.5
        assert away < 0.1, index
    assert trajectory.duration_s >= 1.5 * length / PACE.linear_mm_s


def test_no_joint_is_faster_along_a_line_than_its_peak() -> None:
    start = KINEMATICS.solve(Pose(-320, 100, -50, 180, 0, 200), 0)
    target = Pose(320, 250, -50, 180, 0, 200)
    fast = Pace(PACE.joint_speed, 100.0, 400.0, 0.2)
    with pytest.raises(UnreachablePose, match="J2"):
        line_course(KINEMATICS, start, target, 0, fast, via_s=0.05)
    course = line_course(KINEMATICS, start, Pose(-300, 400, -50, 180, 0, 200), 0, fast, via_s=0.05)
    for p, q, seconds in zip(course.points, course.points[1:], course.durations_s, strict=False):
        for a, b, speed in zip(p.values, q.values, PACE.joint_speed, strict=True):
            assert abs(b - a) / seconds <= 1.5 * speed * 1.001


def test_pulses_are_the_sources_and_the_slide_counts_downwards() -> None:
    assert to_pulses((1.0, 1.0, -1.0, 1.0)) == (872.2222, 444.4444, 380.96, 227.5556)
    assert to_pulses((200.0, 135.0, -250.0, 0.0))[:2] == pytest.approx((174444.4, 60000.0), abs=1)
    joints = (12.0, 34.0, -56.0, -78.0)
    assert to_joints(to_pulses(joints)).values == pytest.approx(joints)


def test_positions_are_double_words_low_word_first() -> None:
    assert words_of((0x2B03C, -1)) == (0xB03C, 0x0002, 0xFFFF, 0xFFFF)
    for values in ((0, 1, -1, 176188), (-41187, 41187, -4361, 95621)):
        assert positions_of(words_of(values)) == values
