"""The guard of any chain: its words, and by brute force that nothing accepted violates anything.

The brute-force check shares with the guard only the arm's kinematics: it samples the motion
finely, fills the bodies with points and looks where they are.
"""

from __future__ import annotations

import random
import tomllib
from functools import partial
from importlib import resources

import numpy as np
import pytest

from cell.drivers.ssc32.line import straight_line
from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import ArmKinematics
from cell.kinematics.line import joints_along_line
from cell.kinematics.lynx import LynxArm
from cell.kinematics.scara import ScaraArm
from cell.motion.chain_guard import ChainGuard, LineLaw
from cell.motion.chain_hull import ChainShape
from cell.motion.guard import Guard, GuardedMove
from cell.motion.motion_guard import MotionGuard
from cell.profile import BoxProfile, CellProfile, load_profile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.lynx import LynxProfile


def _cell(name: str) -> CellProfile:
    text = (resources.files("cell") / "profiles" / f"{name}.toml").read_text("utf-8")
    return CellProfile.model_validate(tomllib.loads(text))


_avrs, _lynx = _cell("avrs").arm, _cell("lynx").arm
if not (isinstance(_avrs, Ibm7545Profile) and isinstance(_lynx, LynxProfile)):
    raise TypeError("the shipped profiles have other arms")
SCARA = ScaraArm.from_profile(_avrs)
LYNX = LynxArm.from_profile(_lynx)
SCARA_SHAPE = ChainShape(radii_mm=(0.0, 80.0, 80.0, 45.0), tip_mm=0.0, loaded_tip_mm=10.0)
LYNX_SHAPE = ChainShape(radii_mm=(0.0, 35.0, 35.0, 30.0), tip_mm=15.0, loaded_tip_mm=25.0)
WORK = (-650.0, -386.0, -260.0, 650.0, 650.0, 10.0)
NARROW = (-650.0, -300.0, -260.0, 650.0, 650.0, 10.0)
TABLE = BoxProfile(name="table", min_mm=(-800, -800, -900), max_mm=(800, 800, -231.7))
POST = BoxProfile(name="post", min_mm=(-20, 480, -231.7), max_mm=(20, 520, 400))


def scara_guard(boxes: list[BoxProfile], *, work: tuple[float, ...] | None = WORK) -> ChainGuard:
    space = None if work is None else (work[0], work[1], work[2], work[3], work[4], work[5])
    return ChainGuard(
        SCARA, SCARA_SHAPE, partial(joints_along_line, SCARA),
        boxes=boxes, max_linear_speed_mm_s=400.0, work_space=space,
    )  # fmt: skip


def lynx_guard(boxes: list[BoxProfile]) -> ChainGuard:
    line: LineLaw = partial(straight_line, LYNX)
    return ChainGuard(LYNX, LYNX_SHAPE, line, boxes=boxes, max_linear_speed_mm_s=200.0)


def standing(*values: float) -> JointPositions:
    return JointPositions(values)


def violations(
    arm: ArmKinematics,
    shape: ChainShape,
    values: tuple[float, ...],
    boxes: list[BoxProfile],
    work: tuple[float, ...] | None,
) -> list[str]:
    found = [
        f"J{axis + 1}"
        for axis, value in enumerate(values)
        if not arm.joint_min[axis] - 0.02 <= value <= arm.joint_max[axis] + 0.02
    ]
    points = np.array(arm.link_points_mm(values))
    tool = points[-1]
    if work is not None and (
        (tool < np.array(work[:3]) - 0.6).any() or (tool > np.array(work[3:]) + 0.6).any()
    ):
        found.append("work space")
    share = np.linspace(0.0, 1.0, 21)[:, None]
    for index, radius in enumerate(shape.radii_mm):
        if not radius:
            continue
        start, end = points[index], points[index + 1]
        if index + 1 == len(points) - 1:
            length = np.linalg.norm(end - start)
            end = start + (end - start) * max(0.0, 1.0 - (radius - shape.tip_mm) / length)
        axis_points = start + (end - start) * share
        for box in boxes:
            low, high = np.array(box.min_mm), np.array(box.max_mm)
            gap = np.linalg.norm(axis_points - np.clip(axis_points, low, high), axis=1).min()
            if gap < radius:
                found.append(box.name)
    return found


def samples(guard: ChainGuard, move: GuardedMove, line: LineLaw) -> list[tuple[float, ...]]:
    """Return stances much finer than the guard's, as the driver would take them."""
    if move.interpolation == "linear":
        stances = line(move.start, move.end_pose, move.posture, step_mm=0.9, step_deg=0.7)
        return [move.start.values, *(joints.values for joints in stances)]
    start, end = np.array(move.start.values), np.array(move.end.values)
    return [tuple(float(v) for v in start + (end - start) * i / 300) for i in range(301)]


def _accepts(guard: MotionGuard) -> MotionGuard:
    return guard


def test_both_guards_are_what_the_cell_asks_for() -> None:
    assert _accepts(scara_guard([])).arm is SCARA
    assert _accepts(Guard.from_profile(load_profile("mash"))) is not None


def test_a_free_joint_move_ends_where_it_was_asked_to() -> None:
    start, end = standing(45, 105, 0, 0), standing(60, 60, -100, 20)
    move = scara_guard([TABLE]).check_joint(start, end, percent=50)
    assert (move.start, move.end, move.interpolation) == (start, end, "joint")
    assert move.end_pose == SCARA.forward(end)
    assert move.duration_s == pytest.approx(2 * 1.0)


def test_a_free_line_says_how_long_it_takes() -> None:
    start = standing(45, 105, -50, 0)
    target = SCARA.forward(start).at_height(-150)
    move = scara_guard([TABLE]).check_linear(start, target, posture=0, speed_mm_s=80)
    assert move.end_pose == target
    assert move.end.values == pytest.approx((45, 105, -150, 0))
    assert move.duration_s == pytest.approx(100 / 80)


def test_a_way_down_through_the_table_is_refused_and_says_how_far_it_is_free() -> None:
    start = standing(45, 105, -50, 0)
    target = SCARA.forward(start).at_height(-245)
    with pytest.raises(MotionRefused, match="would bring the hand into the table") as caught:
        scara_guard([TABLE]).check_linear(start, target, posture=0, speed_mm_s=80)
    error = caught.value
    assert (error.what, error.value, error.unit) == ("tool z", -245.0, "mm")
    assert error.nearest == pytest.approx(-231.7, abs=0.6)
    assert error.nearest_point_mm is not None
    assert error.nearest_point_mm[2] == pytest.approx(error.nearest)


def test_a_swing_through_a_post_whose_ends_are_free_is_refused() -> None:
    start, end = standing(40, 30, -100, 0), standing(130, 30, -100, 0)
    for clear in (start, end):
        assert violations(SCARA, SCARA_SHAPE, clear.values, [POST], None) == []
    with pytest.raises(MotionRefused, match="into the post"):
        scara_guard([POST], work=None).check_joint(start, end, percent=100)


def test_leaving_the_work_space_names_the_side() -> None:
    guard = scara_guard([], work=NARROW)
    with pytest.raises(MotionRefused, match="leave the work space") as caught:
        guard.check_joint(standing(180, 90, 0, 0), standing(200, 70, 0, 0), percent=100)
    error = caught.value
    assert (error.what, error.limit) == ("tool y", -300.0)
    assert error.value == pytest.approx(-386.8, abs=0.1)
    assert error.nearest == pytest.approx(-300.0, abs=1.0)


@pytest.mark.parametrize(
    ("target", "what", "words"),
    [
        (Pose(700, 0, -50, 180, 0, 0), "reach", "is not possible for"),
        (Pose(0, 200, -50, 180, 0, 90), "J2", "cannot go far enough for"),
        (Pose(300, 350, -300, 180, 0, 90), "J3", "cannot go far enough for"),
    ],
)
def test_a_pose_out_of_reach_is_refused_by_name(target: Pose, what: str, words: str) -> None:
    with pytest.raises(MotionRefused, match=words) as caught:
        scara_guard([]).check_pose_joint(standing(45, 60, -50, 0), target, posture=0, percent=50)
    assert caught.value.what == what
    assert caught.value.nearest_point_mm is not None


def test_joints_past_a_limit_are_refused_with_the_limit() -> None:
    with pytest.raises(MotionRefused, match="J2 would pass its limit") as caught:
        scara_guard([]).check_joint(standing(45, 60, 0, 0), standing(45, 140, 0, 0), percent=50)
    error = caught.value
    assert (error.value, error.limit, error.unit) == (140.0, 135.0, "deg")
    assert error.nearest == pytest.approx(135.0, abs=0.2)


@pytest.mark.parametrize(("speed", "nearest"), [(0.0, 1.0), (-4.0, 1.0), (500.0, 400.0)])
def test_a_speed_out_of_range_is_refused(speed: float, nearest: float) -> None:
    start = standing(45, 60, -50, 0)
    with pytest.raises(MotionRefused, match="linear speed") as caught:
        scara_guard([]).check_linear(start, SCARA.forward(start), posture=0, speed_mm_s=speed)
    assert caught.value.nearest == nearest


def test_a_line_that_a_joint_cannot_follow_names_joint_and_speed() -> None:
    start = standing(45, 60, -10, 0)
    target = SCARA.forward(start).at_height(-200)
    guard = scara_guard([])
    with pytest.raises(MotionRefused, match=r"J3 can follow \(100 mm/s\)") as caught:
        guard.check_linear(start, target, posture=0, speed_mm_s=300)
    assert caught.value.nearest == pytest.approx(100.0)
    guard.check_linear(start, target, posture=0, speed_mm_s=caught.value.nearest * 0.999)


def test_a_start_inside_a_box_may_be_left_upwards_but_not_deeper() -> None:
    guard = scara_guard([TABLE])
    inside = standing(45, 105, -240, 0)
    here = SCARA.forward(inside)
    with pytest.raises(MotionRefused, match="table"):
        guard.check_linear(inside, here.at_height(-245), posture=0, speed_mm_s=50)
    move = guard.check_linear(inside, here.at_height(-200), posture=0, speed_mm_s=50)
    assert move.end.values[2] == pytest.approx(-200)


def test_what_is_held_makes_the_hand_longer() -> None:
    guard = scara_guard([TABLE])
    start = standing(45, 105, -150, 0)
    target = SCARA.forward(start).at_height(-225)
    guard.check_linear(start, target, posture=0, speed_mm_s=50)
    with pytest.raises(MotionRefused, match="hand into the table"):
        guard.check_linear(start, target, posture=0, speed_mm_s=50, holds_block=True)


def _scara_boxes(source: random.Random) -> list[BoxProfile]:
    boxes = [TABLE]
    for index in range(3):
        x, y = source.uniform(-450, 500), source.uniform(150, 500)
        boxes.append(
            BoxProfile(
                name=f"box {index}",
                min_mm=(x, y, -231.7),
                max_mm=(
                    x + source.uniform(2, 80),
                    y + source.uniform(2, 80),
                    source.uniform(-150, 150),
                ),
            )
        )
    return boxes


def _random_joints(arm: ArmKinematics, source: random.Random) -> JointPositions:
    return JointPositions(
        tuple(
            source.uniform(low - 3, high + 3)
            for low, high in zip(arm.joint_min, arm.joint_max, strict=True)
        )
    )


@pytest.mark.parametrize("seed", range(4))
def test_no_accepted_move_of_the_scara_violates_anything_on_its_way(seed: int) -> None:
    source = random.Random(seed)
    line = partial(joints_along_line, SCARA)
    accepted = refused = 0
    while accepted < 25 or refused < 10:
        boxes = _scara_boxes(source)
        guard = scara_guard(boxes)
        here = _random_joints(SCARA, source)
        if violations(SCARA, SCARA_SHAPE, here.values, boxes, WORK):
            continue
        for _ in range(8):
            target = _random_joints(SCARA, source)
            try:
                if source.random() < 0.5:
                    move = guard.check_joint(here, target, percent=50)
                else:
                    speed = source.uniform(20, 120)
                    move = guard.check_linear(
                        here, SCARA.forward(target), posture=0, speed_mm_s=speed
                    )
            except MotionRefused:
                refused += 1
                continue
            accepted += 1
            for values in samples(guard, move, line):
                assert violations(SCARA, SCARA_SHAPE, values, boxes, WORK) == [], (seed, move)
            here = move.end


@pytest.mark.parametrize("seed", range(3))
def test_no_accepted_move_of_the_lynx_violates_anything_on_its_way(seed: int) -> None:
    source = random.Random(100 + seed)
    line: LineLaw = partial(straight_line, LYNX)
    accepted = refused = 0
    while accepted < 20 or refused < 10:
        x, y = source.uniform(120, 300), source.uniform(-200, 200)
        boxes = [
            BoxProfile(name="table", min_mm=(-600, -600, -800), max_mm=(600, 600, 0)),
            BoxProfile(
                name="tower",
                min_mm=(x, y, 0),
                max_mm=(x + 40, y + 40, source.uniform(60, 250)),
            ),
        ]
        guard = lynx_guard(boxes)
        here = _random_joints(LYNX, source)
        if violations(LYNX, LYNX_SHAPE, here.values, boxes, None):
            continue
        for _ in range(6):
            target = _random_joints(LYNX, source)
            try:
                if source.random() < 0.6:
                    move = guard.check_joint(here, target, percent=50)
                else:
                    move = guard.check_linear(
                        here, LYNX.forward(target), posture=LYNX.posture(target), speed_mm_s=60
                    )
            except MotionRefused:
                refused += 1
                continue
            accepted += 1
            for values in samples(guard, move, line):
                assert violations(LYNX, LYNX_SHAPE, values, boxes, None) == [], (seed, move)
            here = move.end


def test_the_brute_force_check_sees_each_kind_of_violation() -> None:
    shape = SCARA_SHAPE
    assert violations(SCARA, shape, (45, 105, -240, 0), [TABLE], None) == ["table"]
    assert violations(SCARA, shape, (45, 136, 0, 0), [], None) == ["J2"]
    assert violations(SCARA, shape, (200, 70, 0, 0), [], NARROW) == ["work space"]
    assert set(violations(SCARA, shape, (90, 0, 0, 0), [POST], None)) == {"post"}
