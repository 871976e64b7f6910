from __future__ import annotations

from math import dist

import numpy as np
import pytest

from cell.errors import ProfileError
from cell.geometry import JointPositions, Pose, Transform
from cell.kinematics import RV_6SDL, SixAxisArm, SixAxisGeometry, matrix_from_pose, pose_from_matrix
from tests.cell.kinematics.arms import BARE, MASH, random_joints

# Joint angles and flange poses of the RV-6SDL as computed from its published DH table.
CHECK_POSES = [
    ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Pose(-15, 0, 1240, 0, 0, 0)),
    ((0.0, 0.0, 90.0, 0.0, 90.0, 0.0), Pose(510, 0, 745, 180, 0, 180)),
    ((30.0, 20.0, 100.0, 0.0, 60.0, 0.0), Pose(548.22, 316.51, 496.19, 180, 0, -150)),
    ((30.0, 20.0, 100.0, 40.0, 60.0, 50.0), Pose(532.02, 361.80, 511.10, 161.23, -29.44, 144.35)),
]


def fields(pose: Pose) -> tuple[float, ...]:
    return (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)


@pytest.mark.parametrize(("joints", "pose"), CHECK_POSES)
def test_flange_stands_where_the_published_table_puts_it(
    joints: tuple[float, ...], pose: Pose
) -> None:
    for flange in (MASH.flange(JointPositions(joints)), BARE.forward(JointPositions(joints))):
        assert fields(flange) == pytest.approx(fields(pose), abs=0.006)


def test_tool_point_lies_along_the_flange_axis() -> None:
    for joints in random_joints(1, 50):
        flange = Transform.from_pose(MASH.flange(JointPositions(joints)))
        tool = Transform.from_pose(MASH.forward(JointPositions(joints)))
        offset = (flange.inverse() @ tool).matrix
        assert offset[:3, 3] == pytest.approx([0, 0, 159.2], abs=1e-9)
        assert offset[:3, :3] == pytest.approx(np.eye(3), abs=1e-12)


def test_a_sideways_tool_is_reached_again_by_its_inverse() -> None:
    arm = SixAxisArm(
        RV_6SDL,
        MASH.joint_min_deg,
        MASH.joint_max_deg,
        MASH.joint_speed_deg_s,
        (30.0, -20.0, 100.0),
    )
    for joints in random_joints(2, 50):
        angles = JointPositions(joints)
        solved = arm.solve(arm.forward(angles), arm.posture(angles), near=angles)
        assert solved.values == pytest.approx(joints, abs=1e-6)


def test_links_between_points_keep_the_lengths_of_the_geometry() -> None:
    for joints in random_joints(3, 50):
        base, shoulder, elbow, axis, wrist, flange, tool = MASH.link_points_mm(joints)
        lengths = [dist(shoulder, elbow), dist(elbow, axis), dist(axis, wrist)]
        assert lengths == pytest.approx([380, 100, 425], abs=1e-9)
        assert dist(wrist, flange) == pytest.approx(85, abs=1e-9)
        assert dist(flange, tool) == pytest.approx(159.2, abs=1e-9)
        assert (base, shoulder[2]) == ((0.0, 0.0, 0.0), 350)


def test_plain_float_matrices_agree_with_transforms() -> None:
    for joints in random_joints(4, 50):
        pose = MASH.forward(JointPositions(joints))
        matrix = Transform.from_pose(pose).matrix[:3].ravel()
        assert MASH.tool_matrix(joints) == pytest.approx(matrix, abs=1e-9)
        assert matrix_from_pose(pose) == pytest.approx(matrix, abs=1e-9)


@pytest.mark.parametrize("b_deg", [90.0, -90.0])
def test_pose_at_the_gimbal_keeps_its_orientation(b_deg: float) -> None:
    pose = Pose(1, 2, 3, 20.0, b_deg, 50.0)
    again = pose_from_matrix(matrix_from_pose(pose))
    assert again.a_deg == 0.0
    assert matrix_from_pose(again) == pytest.approx(matrix_from_pose(pose), abs=1e-9)


def test_half_turns_are_written_as_plus_180() -> None:
    noisy = (-1.0, 1e-16, 0.0, 0.0, -1e-16, 1.0, -1e-17, 0.0, 0.0, -1e-17, -1.0, 0.0)
    pose = pose_from_matrix(noisy)
    assert (pose.a_deg, pose.c_deg) == (180.0, 180.0)


def test_limits_the_wrong_way_round_are_refused() -> None:
    with pytest.raises(ProfileError, match="J2"):
        SixAxisArm(
            RV_6SDL,
            (-170.0, 90.0, -129.0, -160.0, -100.0, -200.0),
            (170.0, -90.0, 166.0, 160.0, 100.0, 200.0),
            MASH.joint_speed_deg_s,
        )


def test_arm_whose_wrist_could_lie_in_its_shoulder_is_refused() -> None:
    with pytest.raises(ValueError, match="differ"):
        SixAxisGeometry(d1_mm=350, a1_mm=85, a2_mm=425, a3_mm=0, d4_mm=425, d6_mm=85)
