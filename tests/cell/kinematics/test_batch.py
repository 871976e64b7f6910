from __future__ import annotations

import numpy as np
import pytest

from cell.geometry import JointPositions, Pose, Transform
from cell.kinematics import RV_6SDL, SixAxisArm
from tests.cell.kinematics.arms import MASH, random_joints


def test_batched_forward_equals_single_forward() -> None:
    joints = random_joints(6, 300)
    matrices = MASH.forward_batch(np.array(joints))
    single = np.array([MASH.tool_matrix(angles) for angles in joints]).reshape(-1, 3, 4)
    assert np.abs(matrices[:, :3] - single).max() < 1e-9
    assert (matrices[:, 3] == [0, 0, 0, 1]).all()


def test_batched_inverse_equals_single_inverse_in_every_branch() -> None:
    # More than one block, and not a whole number of them.
    joints = random_joints(7, 1300)
    solved, allowed = MASH.inverse_batch(MASH.forward_batch(np.array(joints)))
    assert solved.shape == (1300, 8, 6)
    assert allowed.shape == (1300, 8)
    for index, angles in enumerate(joints):
        solutions = {s.posture: s for s in MASH.inverse(MASH.forward(JointPositions(angles)))}
        for posture in range(8):
            if posture not in solutions:
                assert np.isnan(solved[index, posture]).any()
                assert not allowed[index, posture]
                continue
            assert solved[index, posture] == pytest.approx(
                solutions[posture].joints.values, abs=1e-6
            )
            assert allowed[index, posture] == solutions[posture].is_allowed


def test_batched_inverse_leads_back_to_every_pose() -> None:
    joints = np.array(random_joints(8, 2000))
    matrices = MASH.forward_batch(joints)
    solved, _ = MASH.inverse_batch(matrices)
    found = ~np.isnan(solved).any(axis=2)
    assert found.sum() > 10_000
    again = MASH.forward_batch(solved[found])
    wanted = np.repeat(matrices, found.sum(axis=1), axis=0)
    assert np.abs(again - wanted).max() < 1e-6


def test_batched_inverse_puts_a_free_j4_at_zero() -> None:
    matrices = MASH.forward_batch(np.array([[20.0, 30.0, 70.0, 50.0, 0.0, 15.0]]))
    solved, allowed = MASH.inverse_batch(matrices)
    for posture in (7, 6):
        assert solved[0, posture] == pytest.approx([20, 30, 70, 0, 0, 65], abs=1e-6)
        assert allowed[0, posture]


def test_batched_inverse_out_of_reach_is_not_allowed() -> None:
    far = Transform.from_pose(Pose(2000, 0, 200)).matrix
    solved, allowed = MASH.inverse_batch(far[None])
    assert np.isnan(solved).any(axis=2).all()
    assert not allowed.any()


def test_batched_inverse_turns_j6_into_one_sided_limits() -> None:
    arm = SixAxisArm(
        RV_6SDL,
        (-170.0, -93.0, -129.0, -160.0, -100.0, 10.0),
        (170.0, 135.0, 166.0, 160.0, 100.0, 350.0),
        MASH.joint_speed_deg_s,
        MASH.tool_mm,
    )
    joints = (10.0, 30.0, 90.0, 5.0, 40.0, 300.0)
    solved, allowed = arm.inverse_batch(arm.forward_batch(np.array([joints])))
    assert solved[0, 7] == pytest.approx(joints, abs=1e-6)
    assert allowed[0, 7]
    assert arm.solve(arm.forward(JointPositions(joints)), 7).values == pytest.approx(
        joints, abs=1e-6
    )


def test_no_poses_give_no_solutions() -> None:
    solved, allowed = MASH.inverse_batch(np.empty((0, 4, 4)))
    assert solved.shape == (0, 8, 6)
    assert allowed.shape == (0, 8)
