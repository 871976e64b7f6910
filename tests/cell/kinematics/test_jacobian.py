from __future__ import annotations

import numpy as np
import pytest

from cell.geometry import JointPositions
from tests.cell.kinematics.arms import MASH, random_joints

STEP_DEG = 1e-4


def test_jacobian_agrees_with_finite_differences() -> None:
    for joints in random_joints(5, 40):
        jacobian = MASH.jacobian(JointPositions(joints))
        for axis in range(6):
            lower, upper = list(joints), list(joints)
            lower[axis] -= STEP_DEG
            upper[axis] += STEP_DEG
            before, after = MASH.forward_batch(np.array([lower, upper]))
            velocity = (after[:3, 3] - before[:3, 3]) / (2 * STEP_DEG)
            spin = (after[:3, :3] - before[:3, :3]) @ after[:3, :3].T
            turning = np.degrees([spin[2, 1], spin[0, 2], spin[1, 0]]) / (2 * STEP_DEG)
            assert jacobian[:3, axis] == pytest.approx(velocity, abs=1e-4)
            assert jacobian[3:, axis] == pytest.approx(turning, abs=1e-4)


def test_jacobian_loses_a_rank_when_the_wrist_is_straight() -> None:
    bent = MASH.jacobian(JointPositions((0.0, 20.0, 100.0, 0.0, 60.0, 0.0)))
    straight = MASH.jacobian(JointPositions((0.0, 20.0, 100.0, 0.0, 0.0, 0.0)))
    assert np.linalg.matrix_rank(bent, tol=1e-9) == 6
    assert np.linalg.matrix_rank(straight, tol=1e-9) == 5
