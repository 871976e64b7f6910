from __future__ import annotations

import pytest

from cell.geometry import JointPositions, Pose
from cell.recovery.whereabouts import (
    away_from_joint_path_deg,
    away_from_line_mm,
    strays_from_stand,
)

START, END = Pose(0.0, 0.0, 100.0), Pose(200.0, 0.0, 100.0)


@pytest.mark.parametrize(
    ("here", "off_mm"),
    [
        (Pose(50.0, 0.0, 100.0), 0.0),
        (Pose(50.0, 3.0, 104.0), 5.0),
        (Pose(-10.0, 0.0, 100.0), 10.0),
        (Pose(230.0, 0.0, 100.0), 30.0),
    ],
)
def test_the_distance_from_a_line_ends_at_its_ends(here: Pose, off_mm: float) -> None:
    assert away_from_line_mm(here, START, END) == pytest.approx(off_mm)


def test_a_line_of_no_length_is_a_point() -> None:
    assert away_from_line_mm(Pose(0.0, 4.0, 103.0), START, START) == pytest.approx(5.0)


def joints(*values: float) -> JointPositions:
    return JointPositions(tuple(values) + (0.0,) * (6 - len(values)))


def test_joints_at_the_same_share_of_their_way_are_on_the_path() -> None:
    assert away_from_joint_path_deg(joints(20, 5), joints(0, 0), joints(80, 20)) == 0.0


def test_a_joint_ahead_of_the_others_is_off_the_path() -> None:
    off = away_from_joint_path_deg(joints(20, 9), joints(0, 0), joints(80, 20))
    assert off == pytest.approx(4.0)


def test_an_arm_that_stood_is_where_it_stood() -> None:
    assert strays_from_stand(joints(10.4), joints(10)) == ""
    assert "3.0 deg" in strays_from_stand(joints(13), joints(10))
