"""The closed form against an independent library, fed with the published DH table."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from cell.geometry import JointPositions
from tests.cell.kinematics.arms import MASH, random_joints

# Offset in deg, d, a in mm, alpha in deg for each joint of the RV-6SDL.
DH_TABLE = (
    (0, 350, 85, -90), (-90, 0, 380, 0), (-90, 0, 100, -90),
    (0, 425, 0, 90), (180, 0, 0, 90), (0, 85, 0, 0),
)  # fmt: skip
TOOL_MM = 159.2


def placement(d: float, a: float, alpha_deg: float, offset_deg: float) -> NDArray[np.float64]:
    """Return Tz(d) · Tx(a) · Rx(alpha) · Rz(offset of the next joint)."""
    ca, sa = cos(radians(alpha_deg)), sin(radians(alpha_deg))
    co, so = cos(radians(offset_deg)), sin(radians(offset_deg))
    link = np.array([[1, 0, 0, a], [0, ca, -sa, 0], [0, sa, ca, d], [0, 0, 0, 1]], dtype=float)
    turn = np.array([[co, -so, 0, 0], [so, co, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float)
    return np.asarray(link @ turn)


@pytest.fixture(scope="module")
def model() -> pin.Model:
    model = pin.Model()
    joint = 0
    before = placement(0, 0, 0, DH_TABLE[0][0])
    for axis, (_, d, a, alpha) in enumerate(DH_TABLE):
        joint = model.addJoint(joint, pin.JointModelRZ(), pin.SE3(before), f"J{axis + 1}")
        following = DH_TABLE[axis + 1][0] if axis < 5 else 0
        before = placement(d, a, alpha, following)
    before[2, 3] += TOOL_MM
    model.addFrame(pin.Frame("tool", joint, 0, pin.SE3(before), pin.FrameType.OP_FRAME))
    return model


def test_forward_agrees(model: pin.Model) -> None:
    data = model.createData()
    for joints in random_joints(30, 500):
        pin.framesForwardKinematics(model, data, np.radians(joints))
        expected = data.oMf[model.getFrameId("tool")].homogeneous[:3].ravel()
        assert MASH.tool_matrix(joints) == pytest.approx(expected, abs=1e-9)


def test_every_solution_of_the_inverse_agrees(model: pin.Model) -> None:
    data = model.createData()
    for joints in random_joints(31, 150):
        pose = MASH.forward(JointPositions(joints))
        for solution in MASH.inverse(pose):
            pin.framesForwardKinematics(model, data, np.radians(solution.joints.values))
            reached = data.oMf[model.getFrameId("tool")].homogeneous[:3].ravel()
            assert reached == pytest.approx(MASH.tool_matrix(joints), abs=1e-6)


def test_jacobian_agrees(model: pin.Model) -> None:
    data = model.createData()
    frame = model.getFrameId("tool")
    for joints in random_joints(32, 100):
        expected = pin.computeFrameJacobian(
            model, data, np.radians(joints), frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        jacobian = MASH.jacobian(JointPositions(joints))
        assert jacobian[:3] == pytest.approx(np.radians(expected[:3]), abs=1e-9)
        assert jacobian[3:] == pytest.approx(expected[3:], abs=1e-9)
