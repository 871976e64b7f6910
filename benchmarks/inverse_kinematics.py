"""What kinematics and the guard cost, beside pinocchio and bare arrays.

Poses are made from seeded joint angles within the mash arm's limits, so every one
has a solution. pinocchio gets the same arm from its DH table.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import count
from math import cos, radians, sin

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from benchmarks.measure import Result, median_s
from cell.geometry import JointPositions, Pose
from cell.kinematics import SixAxisArm
from cell.motion.guard import Guard
from cell.profile import load_profile

SEED = 1
SINGLE_POSES = 200
BATCH_POSES = 50_000

_DH_TABLE = (
    (0, 350, 85, -90), (-90, 0, 380, 0), (-90, 0, 100, -90),
    (0, 425, 0, 90), (180, 0, 0, 90), (0, 85, 0, 0),
)  # fmt: skip
"""Offset in deg, d, a in mm, alpha in deg of each joint."""


def run() -> list[Result]:
    guard = Guard.from_profile(load_profile("mash"))
    return [*_single(guard.arm), *_batched(guard.arm), *_guard(guard)]


def _single(arm: SixAxisArm) -> list[Result]:
    joints = [JointPositions(tuple(angles)) for angles in _joints(arm, SINGLE_POSES).tolist()]
    poses = [arm.forward(angles) for angles in joints]
    cases = [(pose, arm.posture(angles)) for pose, angles in zip(poses, joints, strict=True)]
    iterative_us = _micro(_clik(joints), SINGLE_POSES)

    def inverse_all() -> None:
        for pose in poses:
            arm.inverse(pose)

    def solve_all() -> None:
        for pose, posture in cases:
            arm.solve(pose, posture)

    def forward_all() -> None:
        for angles in joints:
            arm.chain(angles.values)

    library = "pinocchio, one solution by iteration"
    return [
        Result(
            name="inverse kinematics, one pose, all branches",
            value=_micro(inverse_all, SINGLE_POSES), unit="us",
            peer=library, peer_value=iterative_us, target=40.0,
        ),
        Result(
            name="inverse kinematics, one pose, one posture",
            value=_micro(solve_all, SINGLE_POSES), unit="us",
            peer=library, peer_value=iterative_us, target=12.0,
        ),
        Result(
            name="forward kinematics, link points and tool",
            value=_micro(forward_all, SINGLE_POSES), unit="us",
            peer="pinocchio (C++), frames", peer_value=_micro(_pin_forward(joints), SINGLE_POSES),
        ),
    ]  # fmt: skip


def _batched(arm: SixAxisArm) -> list[Result]:
    joints = _joints(arm, BATCH_POSES)
    matrices = arm.forward_batch(joints)
    # The least that any solver of all branches must do: 19 arc tangents and the result.
    column, out = np.ascontiguousarray(joints[:, 0]), np.empty((BATCH_POSES, 8, 6))

    def bare() -> None:
        for _ in range(19):
            np.arctan2(column, 2.0)
        out[:] = 0.0

    batch_s = median_s(lambda: arm.inverse_batch(matrices))
    return [
        Result(
            name="inverse kinematics, batched, all branches",
            value=BATCH_POSES / batch_s, unit="poses/s",
            peer="bare numpy: 19 arc tangents a pose", peer_value=BATCH_POSES / median_s(bare),
            target=200_000.0, target_is="at least",
        )
    ]  # fmt: skip


def _guard(guard: Guard) -> list[Result]:
    arm = guard.arm
    start, over = arm.solve(Pose(510, -100, 136.5), 7), Pose(510, -80, 136.5)
    far, slot = arm.solve(Pose(710, -265, 200), 7), Pose(-195, 650, 200)
    # The guard remembers the lines it has passed; each of these is a little different.
    fresh = (Pose(510, -80 + 1e-6 * k, 136.5) for k in count())
    step = _micro(lambda: guard.check_linear(start, next(fresh), posture=7, speed_mm_s=250), 1, 200)
    again = _micro(lambda: guard.check_linear(start, over, posture=7, speed_mm_s=250), 1, 200)
    curve = _micro(lambda: guard.check_pose_joint(far, slot, posture=7, percent=30), 1, 100)
    alone = _micro(lambda: arm.solve(over, 7, start), 1, 200)
    peer = "the target's inverse alone"
    return [
        Result(
            name="guard, line of 20 mm", value=step, unit="us",
            peer=peer, peer_value=alone, target=90.0,
        ),
        Result(
            name="guard, a line passed before", value=again, unit="us",
            peer=peer, peer_value=alone,
        ),
        Result(
            name="guard, curve from playground to store", value=curve, unit="us",
            peer=peer, peer_value=alone,
        ),
    ]  # fmt: skip


def _joints(arm: SixAxisArm, count: int) -> NDArray[np.float64]:
    return np.random.default_rng(SEED).uniform(arm.joint_min_deg, arm.joint_max_deg, (count, 6))


def _micro(job: Callable[[], object], calls: int, number: int = 1) -> float:
    return median_s(job, number=number) / calls * 1e6


def _model() -> pin.Model:
    model = pin.Model()
    joint, before = 0, _placement(0, 0, 0, _DH_TABLE[0][0])
    for axis, (_, d, a, alpha) in enumerate(_DH_TABLE):
        joint = model.addJoint(joint, pin.JointModelRZ(), pin.SE3(before), f"J{axis + 1}")
        before = _placement(d, a, alpha, _DH_TABLE[axis + 1][0] if axis < 5 else 0)
    model.addFrame(pin.Frame("flange", joint, 0, pin.SE3(before), pin.FrameType.OP_FRAME))
    return model


def _placement(d: float, a: float, alpha_deg: float, offset_deg: float) -> NDArray[np.float64]:
    """Return Tz(d) · Tx(a) · Rx(alpha) · Rz(offset of the next joint), in metres."""
    ca, sa = cos(radians(alpha_deg)), sin(radians(alpha_deg))
    co, so = cos(radians(offset_deg)), sin(radians(offset_deg))
    return np.array(
        [
            [co, -so, 0, a / 1000],
            [ca * so, ca * co, -sa, 0],
            [sa * so, sa * co, ca, d / 1000],
            [0, 0, 0, 1],
        ]
    )


def _pin_forward(joints: list[JointPositions]) -> Callable[[], None]:
    model = _model()
    data = model.createData()
    angles = [np.radians(one.values) for one in joints]

    def job() -> None:
        for q in angles:
            pin.framesForwardKinematics(model, data, q)

    return job


def _clik(joints: list[JointPositions]) -> Callable[[], None]:
    """Return closed-loop inverse kinematics, started 0.2 rad off, to 1e-6 (m, rad)."""
    model = _model()
    data = model.createData()
    frame = model.getFrameId("flange")
    source = random.Random(SEED)
    cases = []
    for one in joints:
        q = np.radians(one.values)
        pin.framesForwardKinematics(model, data, q)
        seed = q + np.array([source.uniform(-0.2, 0.2) for _ in range(6)])
        cases.append((data.oMf[frame].copy(), seed))

    def job() -> None:
        for target, seed in cases:
            q = seed
            for _ in range(100):
                pin.framesForwardKinematics(model, data, q)
                error = pin.log6(data.oMf[frame].actInv(target)).vector
                if np.abs(error).max() < 1e-6:
                    break
                jacobian = pin.computeFrameJacobian(model, data, q, frame)
                damped = jacobian @ jacobian.T + 1e-9 * np.eye(6)
                q = q + jacobian.T @ np.linalg.solve(damped, error)

    return job
