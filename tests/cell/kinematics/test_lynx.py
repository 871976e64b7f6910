from __future__ import annotations

import math
import random
import tomllib
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.errors import ProfileError, UnreachablePose
from cell.geometry import JointPositions, Pose, Transform
from cell.kinematics.lynx import BACKWARD, ELBOW_DOWN, ELBOW_UP, Five, LynxArm
from cell.profile import CellProfile, LynxProfile, profile_text

PROFILE = cast(LynxProfile, CellProfile.model_validate(tomllib.loads(profile_text("lynx"))).arm)
ARM = LynxArm.from_profile(PROFILE)

WITHIN = st.tuples(
    *(st.floats(low, high) for low, high in zip(ARM.joint_min, ARM.joint_max, strict=True))
)


def _dh(theta_deg: float, d_mm: float, a_mm: float, alpha_deg: float) -> list[list[float]]:
    t, w = math.radians(theta_deg), math.radians(alpha_deg)
    ct, st_, cw, sw = math.cos(t), math.sin(t), math.cos(w), math.sin(w)
    return [
        [ct, -st_ * cw, st_ * sw, a_mm * ct],
        [st_, ct * cw, -ct * sw, a_mm * st_],
        [0.0, sw, cw, d_mm],
        [0.0, 0.0, 0.0, 1.0],
    ]


def _by_dh(q: tuple[float, ...]) -> Transform:
    """The published table, row by row: offset and angle, d, a, alpha."""
    import numpy as np

    chain = Transform.identity()
    for row in (
        (q[0], 76.2, 0.0, -90.0),
        (q[1] - 90.0, 0.0, 146.05, 0.0),
        (q[2] + 90.0, 0.0, 187.325, 0.0),
        (q[3] - 90.0, 0.0, 0.0, -90.0),
        (q[4], 68.0, 0.0, 0.0),
    ):
        chain = chain @ Transform(np.array(_dh(*row)))
    return chain


def _apart_mm(first: Pose, second: Pose) -> float:
    return math.dist((first.x_mm, first.y_mm, first.z_mm), (second.x_mm, second.y_mm, second.z_mm))


def _apart_deg(first: Pose, second: Pose) -> float:
    one, other = Transform.from_pose(first).rotation, Transform.from_pose(second).rotation
    size = float(((one - other) ** 2).sum()) ** 0.5
    return math.degrees(2.0 * math.asin(min(size / math.sqrt(8.0), 1.0)))


def test_at_zero_the_tool_points_forward_where_the_figures_say() -> None:
    pose = ARM.forward(JointPositions((0.0,) * 5))
    assert (pose.x_mm, pose.y_mm, pose.z_mm) == pytest.approx((255.325, 0.0, 222.25))
    assert Transform.from_pose(pose).rotation[:, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_the_second_check_pose_comes_out() -> None:
    pose = ARM.forward(JointPositions((30.0, 20.0, -10.0, 15.0, 0.0)))
    assert (pose.x_mm, pose.y_mm, pose.z_mm) == pytest.approx((256.40, 148.03, 152.18), abs=0.005)


@given(WITHIN)
def test_forward_is_the_published_table(q: tuple[float, ...]) -> None:
    chain = _by_dh(q)
    pose = ARM.forward(JointPositions(q))
    assert Transform.from_pose(pose).matrix == pytest.approx(chain.matrix, abs=1e-9)


@given(WITHIN)
def test_link_points_end_at_the_tool_point_and_keep_the_lengths(q: tuple[float, ...]) -> None:
    points = ARM.link_points_mm(q)
    lengths = [math.dist(a, b) for a, b in zip(points, points[1:], strict=False)]
    assert lengths == pytest.approx([76.2, 146.05, 187.325, 68.0])
    pose = ARM.forward(JointPositions(q))
    assert points[-1] == pytest.approx((pose.x_mm, pose.y_mm, pose.z_mm))


@given(WITHIN)
def test_solving_a_forward_pose_in_its_posture_comes_back(q: tuple[float, ...]) -> None:
    joints = JointPositions(q)
    pose = ARM.forward(joints)
    try:
        found = ARM.solve(pose, ARM.posture(joints), joints)
    except UnreachablePose:
        # Only rounding at a border of two postures may turn it down.
        if abs(abs(q[2]) - 90.0) < 0.01 or math.hypot(pose.x_mm, pose.y_mm) < 0.01:
            return
        raise
    again = ARM.forward(found)
    assert _apart_mm(again, pose) < 1e-5
    assert _apart_deg(again, pose) < 0.011


def test_a_thousand_seeded_stances_come_back_joint_by_joint() -> None:
    source = random.Random(5)
    for _ in range(1000):
        q = tuple(
            source.uniform(low, high)
            for low, high in zip(ARM.joint_min, ARM.joint_max, strict=True)
        )
        joints = JointPositions(q)
        found = ARM.solve(ARM.forward(joints), ARM.posture(joints), joints)
        assert found.values == pytest.approx(q, abs=1e-4), f"seed 5, joints {q}"


@given(
    st.floats(-180.0, 180.0),
    st.floats(120.0, 240.0),
    st.floats(10.0, 120.0),
    st.floats(-70.0, 70.0),
)
def test_gripper_down_is_a_180_0_c_pose_at_any_c(
    c_deg: float, reach_mm: float, z_mm: float, direction_deg: float
) -> None:
    heading = math.radians(direction_deg)
    pose = Pose(reach_mm * math.cos(heading), reach_mm * math.sin(heading), z_mm, 180.0, 0.0, c_deg)
    try:
        joints = ARM.solve(pose, ELBOW_UP)
    except UnreachablePose as error:
        if error.what in {"J2", "J3", "J4", "J5", "reach"}:
            return
        raise
    assert sum(joints.values[1:4]) == pytest.approx(90.0)
    assert (joints.values[0] - joints.values[4] - c_deg + 180.0) % 360.0 == pytest.approx(180.0)


@pytest.mark.parametrize("point", [(200.0, -100.0), (100.0, -150.0), (150.0, -100.0)])
def test_the_goal_poses_of_the_cell_are_in_reach(point: tuple[float, float]) -> None:
    heading = math.degrees(math.atan2(point[1], point[0]))
    pose = Pose(*point, 111.22, 180.0, 0.0, heading)
    assert _apart_mm(ARM.forward(ARM.solve(pose, ELBOW_UP)), pose) < 1e-6


@given(st.floats(0.5, 89.0), st.floats(-60.0, 60.0), st.booleans())
def test_a_hand_out_of_the_plane_is_refused_with_how_far_and_the_nearest(
    lean_deg: float, direction_deg: float, is_left: bool
) -> None:
    heading = math.radians(direction_deg)
    flat = Pose(180 * math.cos(heading), 180 * math.sin(heading), 90.0, 180.0, 0.0, 0.0)
    # Turning a hand that points down about the plane's own level line tips it out sideways.
    ahead = Pose(0.0, 0.0, 0.0, lean_deg if is_left else -lean_deg, 0.0, 0.0)
    turn = Transform.from_pose(Pose(0.0, 0.0, 0.0, 0.0, 0.0, direction_deg))
    tipped = turn @ Transform.from_pose(ahead) @ turn.inverse()
    down = Transform.from_pose(Pose(0.0, 0.0, 0.0, 180.0, 0.0, 20.0))
    turned = (tipped @ down).to_pose()
    pose = Pose(flat.x_mm, flat.y_mm, flat.z_mm, turned.a_deg, turned.b_deg, turned.c_deg)
    with pytest.raises(UnreachablePose, match="five joints.*nearest") as caught:
        ARM.solve(pose, ELBOW_UP)
    assert caught.value.what == "lean"
    assert caught.value.value == pytest.approx(lean_deg, abs=1e-6)
    assert ARM.lean_deg(pose) == pytest.approx(lean_deg, abs=1e-6)
    nearest = ARM.nearest_pose(pose)
    assert ARM.lean_deg(nearest) < 1e-6
    assert _apart_deg(nearest, pose) == pytest.approx(lean_deg, abs=1e-6)
    assert _apart_mm(nearest, pose) < 1e-9


def test_a_hand_straight_out_of_the_plane_still_has_a_nearest() -> None:
    sideways = Pose(180.0, 0.0, 90.0, -90.0, 0.0, 0.0)
    assert ARM.lean_deg(sideways) == pytest.approx(90.0)
    assert ARM.lean_deg(ARM.nearest_pose(sideways)) < 1e-6


def test_too_far_and_too_near_are_told_in_millimetres() -> None:
    with pytest.raises(UnreachablePose, match="too far") as caught:
        ARM.solve(Pose(600.0, 0.0, 100.0, 180.0, 0.0, 0.0), ELBOW_UP)
    assert (caught.value.what, caught.value.unit) == ("reach", "mm")
    assert caught.value.limit == pytest.approx(146.05 + 187.325)
    with pytest.raises(UnreachablePose, match="too near"):
        ARM.solve(Pose(20.0, 0.0, 8.2, 180.0, 0.0, 0.0), ELBOW_UP)


def test_a_joint_beyond_its_limit_is_named_with_how_far() -> None:
    with pytest.raises(UnreachablePose, match="J1.*beyond its limit") as caught:
        ARM.solve(Pose(0.0, 200.0, 60.0, 180.0, 0.0, 90.0), ELBOW_UP)
    assert (caught.value.what, caught.value.limit) == ("J1", 80.21)
    assert caught.value.value == pytest.approx(90.0)


def test_both_elbows_and_backwards_reach_the_same_pose_where_limits_allow() -> None:
    free = LynxArm((-360.0,) * 5, (360.0,) * 5, (100.0,) * 5)
    pose = Pose(-120.0, 40.0, 150.0, 180.0, 0.0, 30.0)
    found: list[Five] = []
    for posture in (ELBOW_UP, ELBOW_DOWN, BACKWARD | ELBOW_UP, BACKWARD | ELBOW_DOWN):
        joints = free.solve(pose, posture)
        assert free.posture(joints) == posture
        assert _apart_mm(free.forward(joints), pose) < 1e-6
        found.append(cast(Five, joints.values))
    assert len({tuple(round(value, 3) for value in joints) for joints in found}) == 4


def test_an_unknown_posture_is_refused() -> None:
    with pytest.raises(UnreachablePose, match="posture 7"):
        ARM.solve(Pose(180.0, 0.0, 60.0), 7)


def test_where_the_first_joint_is_free_it_keeps_its_angle() -> None:
    free = LynxArm((-360.0,) * 5, (360.0,) * 5, (100.0,) * 5)
    pose = Pose(0.0, 0.0, 250.0, 180.0, 0.0, 10.0)
    near = JointPositions((33.0, 0.0, 0.0, 0.0, 0.0))
    assert free.solve(pose, ELBOW_UP, near).values[0] == pytest.approx(33.0)
    assert free.solve(pose, ELBOW_UP).values[0] == 0.0


def test_limits_the_wrong_way_round_are_a_profile_error() -> None:
    with pytest.raises(ProfileError, match="J2"):
        LynxArm((-1.0, 5.0, -1.0, -1.0, -1.0), (1.0,) * 5, (1.0,) * 5)
