"""The SCARA arm's kinematics: the source's figures, its limits, and forward against inverse."""

from __future__ import annotations

import random
from math import dist

import pytest

from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.kinematics.scara import ELBOW_NEGATIVE, ELBOW_POSITIVE, ScaraArm

ARM = ScaraArm(
    link_mm=(400.0, 250.0),
    joint_min=(0.0, 0.0, -250.0, -180.0),
    joint_max=(200.0, 135.0, 0.0, 180.0),
    joint_speed=(45.0, 50.0, 100.0, 70.0),
    link_height_mm=200.0,
)
BOTH_ELBOWS = ScaraArm(
    link_mm=(400.0, 250.0),
    joint_min=(-180.0, -160.0, -250.0, -180.0),
    joint_max=(180.0, 160.0, 0.0, 180.0),
    joint_speed=(45.0, 50.0, 100.0, 70.0),
    link_height_mm=200.0,
)


def _accepts(arm: ArmKinematics) -> ArmKinematics:
    return arm


def test_the_arm_is_what_guard_and_emulators_need() -> None:
    assert _accepts(ARM).joint_units == ("deg", "deg", "mm", "deg")
    assert ARM.joint_speed == (45.0, 50.0, 100.0, 70.0)


@pytest.mark.parametrize(
    ("j1", "j2", "x_mm", "y_mm"), [(0, 0, 650, 0), (90, 0, 0, 650), (0, 90, 400, 250)]
)
def test_the_checks_of_the_device_facts_hold(
    j1: float, j2: float, x_mm: float, y_mm: float
) -> None:
    pose = ARM.forward(JointPositions((j1, j2, -20.0, 0.0)))
    assert (pose.x_mm, pose.y_mm) == pytest.approx((x_mm, y_mm))
    assert (pose.z_mm, pose.a_deg, pose.b_deg) == (-20.0, 180.0, 0.0)
    assert pose.c_deg == pytest.approx(j1 + j2)


@pytest.mark.parametrize("seed", range(5))
def test_inverse_undoes_forward_everywhere_within_the_limits(seed: int) -> None:
    source = random.Random(seed)
    for _ in range(400):
        joints = JointPositions(
            tuple(
                source.uniform(low, high)
                for low, high in zip(ARM.joint_min, ARM.joint_max, strict=True)
            )
        )
        found = ARM.solve(ARM.forward(joints), ELBOW_POSITIVE, joints)
        assert found.values == pytest.approx(joints.values, abs=1e-5), (seed, joints)


@pytest.mark.parametrize("seed", range(3))
def test_forward_undoes_inverse_in_both_postures(seed: int) -> None:
    source = random.Random(50 + seed)
    found = 0
    while found < 200:
        pose = Pose(
            source.uniform(-650, 650), source.uniform(-650, 650), source.uniform(-250, 0),
            180.0, 0.0, source.uniform(-179, 179),
        )  # fmt: skip
        posture = source.choice((ELBOW_POSITIVE, ELBOW_NEGATIVE))
        try:
            joints = BOTH_ELBOWS.solve(pose, posture)
        except UnreachablePose:
            continue
        found += 1
        assert joints.values[1] >= 0 if posture == ELBOW_POSITIVE else joints.values[1] <= 0
        there = BOTH_ELBOWS.forward(joints)
        assert (there.x_mm, there.y_mm, there.z_mm) == pytest.approx(
            (pose.x_mm, pose.y_mm, pose.z_mm), abs=1e-6
        ), (seed, pose)
        assert (there.c_deg - pose.c_deg + 180) % 360 - 180 == pytest.approx(0, abs=1e-6)


def test_the_programs_own_inverse_gives_the_same_joints() -> None:
    # w = (X² + Y² + 97500)/800 is the share of the way along link 1 (avrs-cell.md).
    x, y = 300.0, 350.0
    joints = ARM.solve(Pose(x, y, 0.0, 180.0, 0.0, 90.0), ELBOW_POSITIVE)
    w = (x * x + y * y + 97500.0) / 800.0
    elbow = ARM.link_points_mm(joints.values)[2]
    along = (elbow[0] * x + elbow[1] * y) / 400.0
    assert along == pytest.approx(w)


def test_links_keep_their_length_and_end_at_the_tool_point() -> None:
    joints = JointPositions((40.0, 70.0, -100.0, 20.0))
    foot, shoulder, elbow, spindle, tool = ARM.link_points_mm(joints.values)
    pose = ARM.forward(joints)
    assert dist(shoulder, elbow) == pytest.approx(400.0)
    assert dist(elbow, spindle) == pytest.approx(250.0)
    assert spindle[2] - tool[2] == pytest.approx(300.0)
    assert tool == pytest.approx((pose.x_mm, pose.y_mm, pose.z_mm))
    assert foot[:2] == shoulder[:2] == (0.0, 0.0)


@pytest.mark.parametrize(
    ("pose", "what", "value", "limit", "unit"),
    [
        (Pose(700, 0, 0, 180, 0, 0), "reach", 700.0, 650.0, "mm"),
        (Pose(100, 0, 0, 180, 0, 0), "reach", 100.0, 150.0, "mm"),
        (Pose(0, 200, 0, 180, 0, 90), "J2", 155.85, 135.0, "deg"),
        (Pose(300, 350, -260, 180, 0, 90), "J3", -260.0, -250.0, "mm"),
        (Pose(300, 350, 5, 180, 0, 90), "J3", 5.0, 0.0, "mm"),
        (Pose(300, 350, 0, 170, 0, 90), "tilt", 10.0, 0.0, "deg"),
        (Pose(500, -200, 0, 180, 0, 0), "J1", -47.7, 0.0, "deg"),
    ],
)
def test_a_pose_out_of_reach_names_what_is_in_the_way(
    pose: Pose, what: str, value: float, limit: float, unit: str
) -> None:
    with pytest.raises(UnreachablePose, match="cannot be reached") as caught:
        ARM.solve(pose, ELBOW_POSITIVE)
    error = caught.value
    assert (error.what, error.unit) == (what, unit)
    assert error.value == pytest.approx(value, abs=0.1)
    assert error.limit == limit


def test_the_roll_keeps_its_turn_near_where_it_stands() -> None:
    pose = ARM.forward(JointPositions((60.0, 60.0, 0.0, 179.9)))
    assert ARM.solve(pose, 0, JointPositions((60, 60, 0, 170))).values[3] == pytest.approx(179.9)
    edge = ARM.forward(JointPositions((60.0, 60.0, 0.0, 180.0)))
    near = JointPositions((60.0, 60.0, 0.0, -179.0))
    assert ARM.solve(edge, 0, near).values[3] == pytest.approx(-180.0)
