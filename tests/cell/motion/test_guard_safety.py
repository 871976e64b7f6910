"""No accepted move violates anything anywhere on its way, checked by brute force.

The check below shares nothing with the guard but the arm's kinematics: it samples
the motion finely, fills each body with points and looks where they are.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
from numpy.typing import NDArray

from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose, Transform
from cell.kinematics import Joints, Matrix34
from cell.motion.guard import Guard, GuardedMove
from cell.profile import BoxProfile
from tests.cell.motion.cells import ARM, PROFILE, REST, TABLE, guard_with, standing

MARGIN_MM = 0.06
MARGIN_DEG = 0.02
FLANGE_MIN_Z_MM = 50.0


def random_boxes(source: random.Random) -> list[BoxProfile]:
    boxes = [TABLE]
    for index in range(3):
        x, y = source.uniform(250, 800), source.uniform(-500, 500)
        boxes.append(
            BoxProfile(
                name=f"box {index}",
                min_mm=(x, y, 38.5),
                max_mm=(
                    x + source.uniform(5, 120),
                    y + source.uniform(5, 120),
                    source.uniform(60, 500),
                ),
            )
        )
    return boxes


def random_pose(source: random.Random, *, is_upright: bool) -> Pose:
    place = (source.uniform(250, 750), source.uniform(-550, 550), source.uniform(52, 450))
    if is_upright:
        return Pose(*place, 180, 0, source.uniform(-180, 180))
    return Pose(*place, 180 + source.uniform(-40, 40), source.uniform(-40, 40), 180)


def samples(move: GuardedMove, count: int) -> list[Joints]:
    start, end = np.array(move.start.values), np.array(move.end.values)
    if move.interpolation == "joint":
        return [six(start + (end - start) * i / count) for i in range(count + 1)]
    first = Transform.from_pose(ARM.forward(move.start)).matrix
    last = Transform.from_pose(move.end_pose).matrix
    near = six(start)
    found = []
    for i in range(count + 1):
        matrix = np.eye(4)
        matrix[:3, :3] = slerp(first[:3, :3], last[:3, :3], i / count)
        matrix[:3, 3] = first[:3, 3] + (last[:3, 3] - first[:3, 3]) * i / count
        near = ARM.follow(twelve(matrix), move.posture, near)
        found.append(near)
    return found


def slerp(first: NDArray[np.float64], last: NDArray[np.float64], t: float) -> NDArray[np.float64]:
    """Return the rotation a share of the way, by the power of the relative rotation."""
    values, vectors = np.linalg.eig(last @ first.T)
    part = vectors @ np.diag(np.exp(1j * np.angle(values) * t)) @ np.linalg.inv(vectors)
    return np.asarray(part.real @ first)


def six(values: NDArray[np.float64]) -> Joints:
    j1, j2, j3, j4, j5, j6 = (float(value) for value in values)
    return (j1, j2, j3, j4, j5, j6)


def twelve(matrix: NDArray[np.float64]) -> Matrix34:
    a, b, c, x, d, e, f, y, g, h, i, z = (float(value) for value in matrix[:3].ravel())
    return (a, b, c, x, d, e, f, y, g, h, i, z)


def violations(joints: Joints, boxes: list[BoxProfile]) -> list[str]:
    found = [
        f"J{axis + 1}"
        for axis in range(6)
        if not ARM.joint_min_deg[axis] - MARGIN_DEG
        <= joints[axis]
        <= ARM.joint_max_deg[axis] + MARGIN_DEG
    ]
    points = np.array(ARM.link_points_mm(joints))
    if points[5][2] < FLANGE_MIN_Z_MM - MARGIN_MM:
        found.append("flange")
    matrix = np.array(ARM.tool_matrix(joints)).reshape(3, 4)
    share = np.linspace(0.0, 1.0, 13)[:, None]
    top = matrix[:, 3] - 60.0 * matrix[:, 2]
    capsules = [
        (points[1], points[2], 90.0), (points[2], points[3], 90.0), (points[3], points[4], 90.0),
        (points[4], points[5], 60.0), (points[5], top, 50.0),
    ]  # fmt: skip
    gripper = PROFILE.gripper
    half_y = gripper.stroke_mm / 2 + gripper.finger_thickness_mm
    grid = np.array(
        np.meshgrid(
            np.linspace(-gripper.finger_width_mm / 2, gripper.finger_width_mm / 2, 3),
            np.linspace(-half_y, half_y, 9),
            np.linspace(-60.0, gripper.tip_below_tool_mm, 9),
        )
    ).reshape(3, -1)
    fingers = (matrix[:, :3] @ grid).T + matrix[:, 3]
    for box in boxes:
        low, high = np.array(box.min_mm), np.array(box.max_mm)
        for start, end, radius in capsules:
            axis = start + (end - start) * share
            gap = np.linalg.norm(axis - np.clip(axis, low, high), axis=1).min()
            if gap < radius - MARGIN_MM:
                found.append(box.name)
        if ((fingers > low + MARGIN_MM) & (fingers < high - MARGIN_MM)).all(axis=1).any():
            found.append(box.name)
    return found


def try_move(guard: Guard, start: JointPositions, source: random.Random) -> GuardedMove | None:
    target = random_pose(source, is_upright=source.random() < 0.6)
    try:
        if source.random() < 0.5:
            return guard.check_linear(start, target, posture=7, speed_mm_s=source.uniform(20, 400))
        return guard.check_pose_joint(start, target, posture=7, percent=30)
    except MotionRefused:
        return None


@pytest.mark.parametrize("seed", range(6))
def test_no_accepted_move_violates_anything_on_its_way(seed: int) -> None:
    source = random.Random(seed)
    accepted = refused = 0
    while accepted < 20 or refused < 10:
        boxes = random_boxes(source)
        guard = guard_with(boxes)
        here = REST
        for _ in range(12):
            move = try_move(guard, here, source)
            if move is None:
                refused += 1
                continue
            accepted += 1
            for joints in samples(move, 60):
                assert violations(joints, boxes) == [], (seed, move, joints)
            here = move.end


@pytest.mark.parametrize("seed", range(3))
def test_no_accepted_line_is_faster_than_its_joints(seed: int) -> None:
    source = random.Random(100 + seed)
    guard = guard_with([TABLE])
    accepted = 0
    while accepted < 15:
        start = random_pose(source, is_upright=True)
        if not ARM.is_reachable(start, 7):
            continue
        target = random_pose(source, is_upright=True)
        try:
            move = guard.check_linear(
                ARM.solve(start, 7), target, posture=7, speed_mm_s=source.uniform(200, 1000)
            )
        except MotionRefused:
            continue
        accepted += 1
        way = np.abs(np.diff(np.array(samples(move, 400)), axis=0))
        speeds = way / (move.duration_s / 400)
        assert (speeds <= np.array(ARM.joint_speed_deg_s) * 1.1).all(), (seed, move)


def test_the_brute_force_check_sees_each_kind_of_violation() -> None:
    deep = standing(510, -100, 45).values
    assert violations(six(np.array(deep)), [TABLE]) == ["table"]
    assert violations((0, 20, 100, 0, 104, 0), [TABLE]) == ["J5"]
    assert "flange" in violations((0, 110, 60, 0, -60, 0), [])
    wall = BoxProfile(name="wall", min_mm=(200, -500, 300), max_mm=(300, 500, 900))
    assert violations((0, 20, 100, 0, 60, 0), [wall]) == ["wall"] * 3


@pytest.mark.parametrize("seed", range(3))
def test_no_accepted_turn_bulges_into_a_wall_between_its_ends(seed: int) -> None:
    source = random.Random(200 + seed)
    accepted = refused = 0
    for _ in range(60):
        half, lean, bend = source.uniform(10, 30), source.uniform(10, 40), source.uniform(40, 70)
        shape = (lean, 180.0 - lean - bend, 0.0, bend, source.uniform(-90, 90))
        start, middle, end = (JointPositions((j1, *shape)) for j1 in (-half, 0.0, half))
        x = ARM.link_points_mm(middle.values)[4][0] + source.uniform(60, 160)
        wall = BoxProfile(name="wall", min_mm=(x, -60, 38.5), max_mm=(x + 100, 60, 1000))
        if violations(six(np.array(end.values)), [TABLE, wall]):
            continue
        try:
            move = guard_with([TABLE, wall]).check_joint(start, end, percent=30)
        except MotionRefused:
            refused += 1
            continue
        accepted += 1
        for joints in samples(move, 60):
            assert violations(joints, [TABLE, wall]) == [], (seed, move, joints)
    assert min(accepted, refused) > 3


def test_turn_that_bulges_into_a_wall_between_its_ends_is_refused() -> None:
    start, end = (JointPositions((j1, 35.0, 95.0, 0.0, 50.0, 0.0)) for j1 in (-25.0, 25.0))
    reach = ARM.link_points_mm((0.0, *start.values[1:]))[4][0]
    ends = ARM.link_points_mm(end.values)[4][0] + 60.0
    gap = 0.5 * (reach + 60.0 - ends)
    wall = BoxProfile(
        name="wall", min_mm=(ends + gap, -50, 38.5), max_mm=(ends + gap + 100, 50, 1000)
    )
    guard = guard_with([TABLE, wall])
    assert violations((0.0, 35.0, 95.0, 0.0, 50.0, 0.0), [wall]) != []
    assert violations(six(np.array(end.values)), [wall]) == []
    with pytest.raises(MotionRefused, match="into the wall"):
        guard.check_joint(start, end, percent=30)
