from __future__ import annotations

import pytest

from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics import RV_6SDL, SixAxisArm, matrix_from_pose
from tests.cell.kinematics.arms import BARE, MASH, random_joints

DOWN = Pose(500, 100, 200)


@pytest.mark.parametrize("seed", range(4))
def test_every_branch_leads_back_to_the_pose(seed: int) -> None:
    for joints in random_joints(seed, 250):
        pose = MASH.forward(JointPositions(joints))
        wanted = matrix_from_pose(pose)
        solutions = MASH.inverse(pose)
        assert len(solutions) in (4, 8)
        for solution in solutions:
            assert MASH.tool_matrix(solution.joints.values) == pytest.approx(wanted, abs=1e-6)


def test_eight_branches_have_the_eight_postures() -> None:
    assert sorted(s.posture for s in BARE.inverse(DOWN)) == list(range(8))


@pytest.mark.parametrize("seed", range(4))
def test_the_angles_a_pose_was_made_from_are_found_again(seed: int) -> None:
    for joints in random_joints(10 + seed, 250):
        angles = JointPositions(joints)
        solved = MASH.solve(MASH.forward(angles), MASH.posture(angles), near=angles)
        assert solved.values == pytest.approx(joints, abs=1e-6)


def test_flags_of_a_solution_agree_with_those_read_off_its_angles() -> None:
    for joints in random_joints(20, 500):
        for solution in MASH.inverse(MASH.forward(JointPositions(joints))):
            assert MASH.posture(solution.joints) == solution.posture
            assert MASH.turns(solution.joints) == solution.turns


def test_solve_gives_the_branch_that_inverse_lists() -> None:
    for joints in random_joints(21, 200):
        pose = MASH.forward(JointPositions(joints))
        for solution in MASH.inverse(pose):
            if solution.is_allowed:
                solved = MASH.solve(pose, solution.posture)
                assert solved.values == pytest.approx(solution.joints.values, abs=1e-9)


def test_violations_name_joint_value_and_limit() -> None:
    solutions = {s.posture: s for s in MASH.inverse(DOWN)}
    assert solutions[7].is_allowed
    flip = solutions[6].violations
    assert [(violation.joint, abs(violation.limit_deg)) for violation in flip] == [("J4", 160.0)]
    assert abs(flip[0].value_deg) == pytest.approx(180.0)
    assert flip[0].excess_deg == pytest.approx(20.0)
    assert str(flip[0]).startswith("J4 at ")


def test_solve_outside_a_joint_limit_says_by_how_much() -> None:
    with pytest.raises(UnreachablePose, match=r"J5 .* beyond its limit of 100\.00 deg") as caught:
        MASH.solve(Pose(510, 0, 700), 7)
    error = caught.value
    assert (error.what, error.limit, error.unit) == ("J5", 100.0, "deg")
    assert error.value > 100.0


def test_solve_out_of_reach_says_by_how_much() -> None:
    with pytest.raises(UnreachablePose, match="too far") as caught:
        MASH.solve(Pose(1000, 0, 200), 7)
    error = caught.value
    assert (error.what, error.unit) == ("reach", "mm")
    # Wrist at (1000, 0, 444.2), shoulder at (85, 0, 350).
    assert error.value == pytest.approx((915**2 + 94.2**2) ** 0.5, abs=1e-9)
    assert error.limit == pytest.approx(380 + (100**2 + 425**2) ** 0.5)


def test_pose_inside_the_inner_sphere_is_out_of_reach() -> None:
    wrist_in_shoulder = Pose(85, 0, 350 - 159.2 - 85)
    assert [s for s in MASH.inverse(wrist_in_shoulder) if s.posture & 4] == []
    with pytest.raises(UnreachablePose, match="too near"):
        MASH.solve(wrist_in_shoulder, 7)


def test_stretched_arm_at_the_very_edge_of_its_reach_is_solved() -> None:
    beta = 13.240519915187205
    for joints in [(0.0, 90.0, beta, 0.0, 50.0, 0.0), (40.0, 60.0, beta, 20.0, 30.0, 0.0)]:
        pose = MASH.forward(JointPositions(joints))
        solved = MASH.solve(pose, 7)
        assert MASH.tool_matrix(solved.values) == pytest.approx(matrix_from_pose(pose), abs=1e-4)


@pytest.mark.parametrize("j4", [0.0, 35.0, -120.0])
def test_straight_wrist_keeps_the_angle_of_j4_that_is_near(j4: float) -> None:
    joints = JointPositions((20.0, 30.0, 70.0, j4, 0.0, 15.0))
    pose = MASH.forward(joints)
    assert MASH.solve(pose, 7, near=joints).values == pytest.approx(joints.values, abs=1e-6)
    assert MASH.solve(pose, 6, near=joints).values == pytest.approx(joints.values, abs=1e-6)
    assert sorted(s.posture for s in MASH.inverse(pose, near=joints)) == [4, 5, 7]
    assert MASH.is_reachable(pose, 7)
    assert MASH.is_reachable(pose, 6)


def test_straight_wrist_without_a_hint_puts_j4_at_zero() -> None:
    pose = MASH.forward(JointPositions((20.0, 30.0, 70.0, 50.0, 0.0, 15.0)))
    solved = MASH.solve(pose, 7)
    assert solved.values[3] == 0.0
    assert solved.values[5] == pytest.approx(65.0, abs=1e-6)


def test_wrist_on_the_upright_axis_keeps_the_angle_of_j1_that_is_near() -> None:
    # Left of the axis by exactly the shoulder's offset: q1 is free.
    joints = JointPositions((77.0, *_over_the_axis(), 10.0, 40.0, 5.0))
    pose = MASH.forward(joints)
    posture = MASH.posture(joints)
    postures = [s for s in BARE_WITH_TOOL.inverse(pose, near=joints) if s.posture == posture | 4]
    assert postures
    for solution in BARE_WITH_TOOL.inverse(pose, near=joints):
        assert solution.joints.values[0] == pytest.approx(77.0)
        assert MASH.tool_matrix(solution.joints.values) == pytest.approx(
            matrix_from_pose(pose), abs=1e-4
        )


BARE_WITH_TOOL = SixAxisArm(
    RV_6SDL, (-360.0,) * 6, (360.0,) * 6, MASH.joint_speed_deg_s, MASH.tool_mm
)


def _over_the_axis() -> tuple[float, float]:
    """Return J2 and J3 with the wrist on the J1 axis, found by halving J2."""
    low, high = -60.0, 0.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if MASH.link_points_mm((0.0, middle, 20.0, 0.0, 0.0, 0.0))[4][0] > 0.0:
            high = middle
        else:
            low = middle
    return high, 20.0


@pytest.mark.parametrize(
    ("near6", "expected"), [(0.0, 170.0), (-150.0, -190.0), (150.0, 170.0), (-195.0, -190.0)]
)
def test_j6_takes_the_turn_nearest_to_the_hint(near6: float, expected: float) -> None:
    joints = JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, 170.0))
    near = JointPositions((*joints.values[:5], near6))
    assert MASH.solve(MASH.forward(joints), 7, near=near).values[5] == pytest.approx(expected)


def test_j6_stays_within_its_limits_when_the_nearest_turn_leaves_them() -> None:
    joints = JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, -150.0))
    near = JointPositions((*joints.values[:5], 195.0))
    assert MASH.solve(MASH.forward(joints), 7, near=near).values[5] == pytest.approx(-150.0)
    followed = MASH.follow(MASH.tool_matrix(joints.values), 7, near.values)
    assert followed[5] == pytest.approx(210.0)


@pytest.mark.parametrize(("turns", "expected"), [(0, 170.0), (0x00F00000, -190.0)])
def test_turn_flag_picks_the_turn_of_j6(turns: int, expected: float) -> None:
    joints = JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, 170.0))
    solved = MASH.solve(MASH.forward(joints), 7, turns=turns)
    assert solved.values[5] == pytest.approx(expected)
    assert MASH.turns(solved) == turns


def test_turn_flag_beyond_the_limits_of_j6_is_refused() -> None:
    pose = MASH.forward(JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, 90.0)))
    with pytest.raises(UnreachablePose, match="J6"):
        MASH.solve(pose, 7, turns=0x00100000)


def test_equivalents_list_every_turn_of_j6_within_its_limits() -> None:
    joints = JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, 170.0))
    assert [e.values[5] for e in MASH.equivalents(joints)] == pytest.approx([-190.0, 170.0])
    middle = JointPositions((10.0, 30.0, 90.0, 5.0, 40.0, 20.0))
    assert [e.values[5] for e in MASH.equivalents(middle)] == pytest.approx([20.0])


def test_following_a_line_never_jumps() -> None:
    near = MASH.solve(Pose(300, -500, 200), 7).values
    for step in range(1, 201):
        matrix = matrix_from_pose(Pose(300 + step, -500 + 5 * step, 200))
        joints = MASH.follow(matrix, 7, near)
        assert max(abs(a - b) for a, b in zip(joints, near, strict=True)) < 2.0
        near = joints
