from __future__ import annotations

import numpy as np

from calibration.least_squares import differences
from calibration.servo.chain import MarkerChain, turn_between
from calibration.servo.samples import BACK, TOP
from cell.kinematics.lynx import LynxArm
from tests.calibration.servo.bench import GEOMETRY

ARM = LynxArm((-180.0,) * 5, (180.0,) * 5, (1.0,) * 5, GEOMETRY)


def test_the_chain_is_the_arm_s_own_kinematics() -> None:
    joints = np.random.default_rng(1).uniform(-100, 100, (30, 5))
    for mount in (BACK, TOP):
        chain = MarkerChain(GEOMETRY, [mount.tool_from_marker] * 30)
        position, rotation, _ = chain.places(joints)
        for i in range(30):
            tool = np.eye(4)
            tool[:3] = np.array(ARM.tool_matrix(tuple(joints[i]))).reshape(3, 4)
            marker = tool @ mount.tool_from_marker.matrix
            assert np.abs(position[i] - marker[:3, 3]).max() < 1e-9
            assert np.abs(rotation[i] - marker[:3, :3]).max() < 1e-12


def test_slopes_are_those_of_finite_differences() -> None:
    joints = np.random.default_rng(2).uniform(-100, 100, (10, 5))
    chain = MarkerChain(GEOMETRY, [TOP.tool_from_marker] * 10)
    _, here, slopes = chain.places(joints)
    for i in range(10):
        one = MarkerChain(GEOMETRY, [TOP.tool_from_marker])

        def six(q: np.ndarray, one: MarkerChain = one, i: int = i) -> np.ndarray:
            position, rotation, _ = one.places(q[None])
            return np.concatenate([position[0], turn_between(rotation, here[i : i + 1])[0]])

        assert np.abs(differences(six, joints[i]) - slopes[i]).max() < 1e-6


def test_a_turn_between_frames_is_its_axis_times_its_angle() -> None:
    c, s = np.cos(0.7), np.sin(0.7)
    turned = np.array([[[c, -s, 0], [s, c, 0], [0, 0, 1]]])
    assert np.abs(turn_between(turned, np.eye(3)[None]) - [[0, 0, 0.7]]).max() < 1e-12
