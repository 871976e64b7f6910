"""What the guard turns down, and the figures it gives."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cell.errors import MotionRefused
from cell.geometry import JointPositions, LatticeMap, Pose
from cell.motion.guard import Guard, GuardedMove
from cell.profile import BoxProfile
from tests.cell.motion.cells import ARM, GUARD, POST, REST, TABLE, guard_with, standing

OVER = standing(510, -100, 200)
LOW = standing(510, -100, 60)
BEYOND = Pose(950, -80, 136.5)
DEEP = Pose(510, -100, 40)
LEVEL = JointPositions((0.0, 60.0, 110.0, 0.0, -80.0, 0.0))


def line(
    guard: Guard, start: JointPositions, target: Pose, **more: bool
) -> Callable[[], GuardedMove]:
    return lambda: guard.check_linear(start, target, posture=7, speed_mm_s=100, **more)


def curve(
    guard: Guard, start: JointPositions, target: Pose, **more: bool
) -> Callable[[], GuardedMove]:
    return lambda: guard.check_pose_joint(start, target, posture=7, percent=30, **more)


def turn(guard: Guard, start: JointPositions, *target: float) -> Callable[[], GuardedMove]:
    return lambda: guard.check_joint(start, JointPositions(target), percent=30)


REFUSED = {
    # name: move, what, value, limit, nearest, unit, words
    "fingers into the table along a line": (
        line(GUARD, OVER, DEEP), "tool z", 40, 50.5, 50.45, "mm", "the hand into the table"),
    "fingers into the table along a curve": (
        curve(GUARD, OVER, DEEP), "tool z", 40, 50.5, 50.45, "mm", "the hand into the table"),
    "held block into the table": (
        line(GUARD, LOW, DEEP.at_height(50), holds_block=True),
        "tool z", 50, 55, 54.95, "mm", "the hand into the table"),
    "target out of reach along a line": (
        line(GUARD, OVER, BEYOND), "reach", 868.9, 816.6, 816.6, "mm", "is not enough for"),
    "target out of reach along a curve": (
        curve(GUARD, OVER, BEYOND), "reach", 868.9, 816.6, 816.6, "mm", "is not enough for"),
    "target that folds the elbow too far": (
        curve(GUARD, OVER, Pose(250, 0, 136.5)), "J3", 170.9, 166, 166, "deg", "cannot turn"),
    "target that bends the wrist too far": (
        line(GUARD, OVER, Pose(510, -100, 900)),
        "reach", 905.4, 816.6, 701.7, "mm", "is not enough"),
    "joint past its upper limit": (
        turn(GUARD, OVER, 0, 20, 100, 0, 120, 0), "J5", 120, 100, 100, "deg", "pass its limit"),
    "joint past its lower limit": (
        turn(GUARD, REST, -175, -30, 120, 0, 90, 0), "J1", -175, -170, -170, "deg", "pass its"),
    "flange too low": (
        lambda: guard_with([]).check_linear(
            LEVEL, ARM.forward(LEVEL).at_height(30), posture=6, speed_mm_s=100),
        "flange", 30, 50, 50, "mm", "lowest height"),
    "hand into a box on the way of a line": (
        line(guard_with([TABLE, POST]), standing(510, -150, 120), Pose(510, 150, 120)),
        "tool y", 150, -60, -60, "mm", "the hand into the post"),
    "arm into a box": (
        turn(guard_with([BoxProfile(name="shelf", min_mm=(200, 200, 400), max_mm=(400, 400, 900))]),
             JointPositions((0, 20, 100, 0, 60, 0)), 90, 20, 100, 0, 60, 90),
        "tool x", 0, 611.6, 611.6, "mm",
        "the arm into the shelf"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusal_tells_what_the_value_the_limit_and_the_nearest_allowed(name: str) -> None:
    move, what, value, limit, nearest, unit, words = REFUSED[name]
    with pytest.raises(MotionRefused) as caught:
        move()
    refusal = caught.value
    assert (refusal.what, refusal.unit) == (what, unit)
    assert words in str(refusal)
    for figure, expected in ((refusal.value, value), (refusal.limit, limit)):
        if expected is not None:
            assert figure == pytest.approx(expected, abs=0.5)
            assert f"{figure:.1f} {unit}" in str(refusal)
    if nearest is not None:
        assert refusal.nearest == pytest.approx(nearest, abs=0.5)
    assert refusal.nearest_point_mm is not None
    assert "the way is free up to" in str(refusal)


@pytest.mark.parametrize(
    ("start", "target"),
    [
        (OVER, DEEP),
        (OVER, DEEP.at_height(-300)),
        (OVER, BEYOND),
        (OVER, Pose(250, 0, 136.5)),
        (OVER, Pose(510, -100, 900)),
        (standing(700, 0, 120), Pose(700, 900, 120)),
    ],
)
def test_the_way_really_is_free_up_to_the_nearest_point(
    start: JointPositions, target: Pose
) -> None:
    with pytest.raises(MotionRefused) as caught:
        GUARD.check_linear(start, target, posture=7, speed_mm_s=20)
    point = caught.value.nearest_point_mm
    assert point is not None
    x, y, z = point
    allowed = GUARD.check_linear(start, Pose(x, y, z), posture=7, speed_mm_s=20)
    # And it is the last one: a millimetre further is refused.
    here = ARM.forward(allowed.start)
    way = ((target.x_mm - here.x_mm), (target.y_mm - here.y_mm), (target.z_mm - here.z_mm))
    size = sum(part * part for part in way) ** 0.5
    beyond = Pose(x + way[0] / size, y + way[1] / size, z + way[2] / size)
    with pytest.raises(MotionRefused):
        GUARD.check_linear(start, beyond, posture=7, speed_mm_s=20)


@pytest.mark.parametrize(
    ("speed", "limit", "nearest"), [(1500.0, 1000.0, 1000.0), (0.0, 0.0, 1.0), (-5.0, 0.0, 1.0)]
)
def test_linear_speed_out_of_range_is_refused(speed: float, limit: float, nearest: float) -> None:
    with pytest.raises(MotionRefused, match="linear speed") as caught:
        GUARD.check_linear(OVER, Pose(510, -80, 200), posture=7, speed_mm_s=speed)
    assert (caught.value.limit, caught.value.nearest) == (limit, nearest)


@pytest.mark.parametrize(("percent", "nearest"), [(0.0, 1.0), (-1.0, 1.0), (101.0, 100.0)])
def test_joint_speed_out_of_range_is_refused(percent: float, nearest: float) -> None:
    with pytest.raises(MotionRefused, match="joint speed") as caught:
        GUARD.check_joint(OVER, REST, percent=percent)
    assert caught.value.nearest == nearest


def test_speed_that_a_joint_cannot_follow_names_one_that_it_can() -> None:
    # Close to the upright axis J1 has to turn quickly.
    start, target = standing(200, -330, 400), Pose(200, 330, 400)
    with pytest.raises(MotionRefused, match=r"is more than J\d can follow") as caught:
        GUARD.check_linear(start, target, posture=7, speed_mm_s=1000)
    allowed = caught.value.nearest
    assert 50 < allowed < 1000
    assert GUARD.check_linear(start, target, posture=7, speed_mm_s=allowed).duration_s > 0
    with pytest.raises(MotionRefused):
        GUARD.check_linear(start, target, posture=7, speed_mm_s=allowed * 1.3)


def test_line_may_not_begin_in_another_posture() -> None:
    start = ARM.inverse(ARM.forward(JointPositions((0.0, 60.0, 60.0, 0.0, 60.0, 0.0))))
    below = next(solution for solution in start if solution.posture == 5)
    with pytest.raises(MotionRefused, match="does not stand in posture Right-Above-NonFlip"):
        GUARD.check_linear(below.joints, Pose(600, 0, 400), posture=7, speed_mm_s=100)


def test_line_through_a_straight_wrist_is_refused() -> None:
    # J5 would pass zero, where J4 has to turn by half a turn at once.
    start = JointPositions((0.0, 20.0, 60.0, 0.0, 10.0, 0.0))
    end = JointPositions((0.0, 20.0, 60.0, 0.0, -10.0, 0.0))
    with pytest.raises(MotionRefused) as caught:
        guard_with([]).check_linear(start, ARM.forward(end), posture=7, speed_mm_s=10)
    assert caught.value.what in ("J4", "J6")


@pytest.mark.parametrize("corner", [(0, 0), (11, 0)])
def test_lattice_at_the_origin_of_the_text_is_refused_for_its_reach(
    corner: tuple[int, int],
) -> None:
    lattice = LatticeMap(step_mm=20, angle_deg=90, origin_x_mm=711, origin_y_mm=-600)
    target = Pose(*lattice.to_robot(*corner), 200)
    if corner == (11, 0):
        GUARD.check_pose_joint(REST, target, posture=7, percent=30)
        return
    with pytest.raises(MotionRefused) as caught:
        GUARD.check_pose_joint(REST, target, posture=7, percent=30)
    assert caught.value.what == "reach"
    assert caught.value.value - caught.value.limit == pytest.approx(34.0, abs=0.1)


def test_curve_that_passes_through_a_box_is_refused_though_both_ends_are_free() -> None:
    guard = guard_with([TABLE, POST])
    start = standing(510, -150, 120)
    with pytest.raises(MotionRefused, match="into the post"):
        guard.check_pose_joint(start, Pose(510, 150, 120), posture=7, percent=30)
    high = guard.check_linear(start, Pose(510, -150, 330), posture=7, speed_mm_s=100)
    guard.check_pose_joint(high.end, Pose(510, 150, 330), posture=7, percent=30)


def test_a_thin_plate_between_two_samples_is_not_stepped_over() -> None:
    plate = BoxProfile(name="plate", min_mm=(400, -0.5, 38.5), max_mm=(620, 0.5, 90))
    guard = guard_with([TABLE, plate])
    for reach in (60.0, 100.0, 137.0, 150.0):
        with pytest.raises(MotionRefused, match="into the plate"):
            guard.check_linear(
                standing(510, -reach, 80), Pose(510, reach, 80), posture=7, speed_mm_s=100
            )


def test_refused_motion_leaves_the_guard_as_it_was() -> None:
    before = GUARD.check_linear(OVER, Pose(510, -80, 200), posture=7, speed_mm_s=250)
    with pytest.raises(MotionRefused):
        GUARD.check_linear(OVER, DEEP, posture=7, speed_mm_s=250)
    assert GUARD.check_linear(OVER, Pose(510, -80, 200), posture=7, speed_mm_s=250) == before
