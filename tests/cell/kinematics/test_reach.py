from __future__ import annotations

import pytest

from cell.geometry import Pose
from tests.cell.kinematics.arms import MASH


def test_reachable_pose_has_no_problem() -> None:
    pose = Pose(500, 0, 200)
    assert MASH.is_reachable(pose)
    assert MASH.is_reachable(pose, 7)
    assert MASH.reach_problem(pose) is None
    assert MASH.reach_problem(pose, 7) is None


def test_posture_that_breaks_a_limit_is_named() -> None:
    pose = Pose(500, 0, 200)
    assert not MASH.is_reachable(pose, 6)
    problem = MASH.reach_problem(pose, 6)
    assert problem is not None
    assert (problem.what, problem.unit) == ("J4", "deg")
    assert str(problem).endswith("with posture Right-Above-Flip")


def test_lattice_corner_of_the_other_printed_origin_is_too_far() -> None:
    problem = MASH.reach_problem(Pose(711, -600, 200))
    assert problem is not None
    assert problem.what == "reach"
    assert problem.limit == pytest.approx(816.6, abs=0.05)
    assert problem.value == pytest.approx(850.6, abs=0.05)
    assert "930.3 mm from the upright axis" in problem.text
    assert "34.0 mm too far" in problem.text


def test_without_a_posture_the_nearest_miss_is_told() -> None:
    problem = MASH.reach_problem(Pose(510, 0, 700))
    assert problem is not None
    assert problem.what == "J5"
    assert problem.value - problem.limit < 20.0


@pytest.mark.parametrize("posture", [3, 7])
def test_reach_backwards_is_shorter_by_the_shoulder_offset(posture: int) -> None:
    problem = MASH.reach_problem(Pose(920, 0, 105.8), posture)
    assert problem is not None
    assert problem.what == "reach"
    assert problem.value == pytest.approx(835 if posture == 7 else 1005)
