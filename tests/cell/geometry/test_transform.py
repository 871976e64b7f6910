from __future__ import annotations

import random

import numpy as np
import pytest

from cell.geometry import JointPositions, Pose, Transform


def random_poses(seed: int, count: int) -> list[Pose]:
    source = random.Random(seed)
    return [
        Pose(
            source.uniform(-900, 900),
            source.uniform(-900, 900),
            source.uniform(-900, 900),
            source.uniform(-180, 180),
            source.uniform(-89, 89),
            source.uniform(-180, 180),
        )
        for _ in range(count)
    ]


def about(axis: str, angle_deg: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis], dtype=np.float64)


def test_orientation_is_rotation_about_fixed_x_then_y_then_z() -> None:
    for pose in random_poses(1, 20):
        expected = about("z", pose.c_deg) @ about("y", pose.b_deg) @ about("x", pose.a_deg)
        assert Transform.from_pose(pose).rotation == pytest.approx(expected, abs=1e-12)


def test_pose_and_transform_convert_both_ways() -> None:
    for pose in random_poses(2, 50):
        again = Transform.from_pose(pose).to_pose()
        for name in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"):
            assert getattr(again, name) == pytest.approx(getattr(pose, name), abs=1e-9)


def test_gripper_down_points_tool_z_at_the_floor_and_tool_y_along_robot_y() -> None:
    rotation = Transform.from_pose(Pose(1, 2, 3)).rotation
    assert rotation == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=1e-12)


@pytest.mark.parametrize("b_deg", [90.0, -90.0])
def test_gimbal_keeps_the_orientation_and_puts_a_at_zero(b_deg: float) -> None:
    transform = Transform.from_pose(Pose(0, 0, 0, 25.0, b_deg, 70.0))
    pose = transform.to_pose()
    assert pose.a_deg == 0.0
    assert Transform.from_pose(pose).matrix == pytest.approx(transform.matrix, abs=1e-9)


def test_inverse_undoes_and_chains_cancel() -> None:
    first, second = (Transform.from_pose(pose) for pose in random_poses(3, 2))
    assert (first @ first.inverse()).matrix == pytest.approx(np.eye(4), abs=1e-9)
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 600.0]])
    assert (first @ second).apply(points) == pytest.approx(first.apply(second.apply(points)))
    assert Transform.identity().apply(points) == pytest.approx(points)


def test_matrix_is_read_only_and_must_be_four_by_four() -> None:
    transform = Transform(np.eye(4))
    with pytest.raises(ValueError, match="read-only"):
        transform.matrix[0, 0] = 2.0
    with pytest.raises(ValueError, match="4 x 4"):
        Transform(np.eye(3))


def test_poses_and_joint_angles_are_written_with_two_decimals() -> None:
    assert str(Pose(1, 2.5, 3)) == "(1.00, 2.50, 3.00) mm (180.00, 0.00, 180.00) deg"
    assert str(JointPositions((1.0, -2.5))) == "(1.00, -2.50)"


def test_pose_at_another_height_changes_nothing_else() -> None:
    assert Pose(1, 2, 3, 4, 5, 6).at_height(9) == Pose(1, 2, 9, 4, 5, 6)
