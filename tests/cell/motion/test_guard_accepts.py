"""Everything the mash cell has to do is allowed."""

from __future__ import annotations

from itertools import pairwise

import pytest

from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose
from cell.motion.guard import Guard
from cell.motion.hull import GRIPPER_RADIUS_MM, LINK_RADIUS_MM, WRIST_RADIUS_MM
from tests.cell.motion.cells import ARM, CORNERS, GUARD, LATTICE, PROFILE, REST, SLOTS, standing


@pytest.mark.parametrize("place", [*CORNERS, *SLOTS])
@pytest.mark.parametrize("height_mm", [55.0, 98.0, 136.5, 200.0])
def test_every_corner_and_slot_is_reached_from_rest(place: str, height_mm: float) -> None:
    x, y = (CORNERS | SLOTS)[place]
    pose = Pose(x, y, 200.0)
    move = GUARD.check_pose_joint(REST, pose, posture=7, percent=30)
    assert move.interpolation == "joint"
    assert ARM.posture(move.end) == move.posture == 7
    down = GUARD.check_linear(move.end, pose.at_height(height_mm), posture=7, speed_mm_s=250)
    reached = ARM.forward(down.end)
    assert (reached.x_mm, reached.y_mm, reached.z_mm) == pytest.approx((x, y, height_mm))
    back = GUARD.check_linear(down.end, pose, posture=7, speed_mm_s=250)
    home = GUARD.check_joint(back.end, REST, percent=30)
    assert home.end == REST


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("corner", CORNERS)
def test_a_block_is_carried_between_every_slot_and_corner(slot: str, corner: str) -> None:
    there, here = Pose(*CORNERS[corner], 200.0), Pose(*SLOTS[slot], 200.0)
    joints = standing(*SLOTS[slot], 55.0)
    for target in (here, there):
        if target is there:
            move = GUARD.check_pose_joint(joints, there, posture=7, percent=30, holds_block=True)
        else:
            move = GUARD.check_linear(joints, here, posture=7, speed_mm_s=250, holds_block=True)
        joints = move.end
    low = there.at_height(55.0)
    joints = GUARD.check_linear(joints, low, posture=7, speed_mm_s=250, holds_block=True).end
    joints = GUARD.check_linear(joints, there, posture=7, speed_mm_s=250).end
    GUARD.check_pose_joint(joints, here, posture=7, percent=100)


@pytest.mark.parametrize("height_mm", [55.0, 98.0, 136.5, 200.0])
def test_every_step_between_neighbours_is_allowed(height_mm: float) -> None:
    rows = [[(x, y) for x in range(12)][:: 1 if y % 2 == 0 else -1] for y in range(12)]
    columns = [[(x, y) for y in range(12)][:: 1 if x % 2 == 0 else -1] for x in range(12)]
    for walk in (sum(rows, []), sum(columns, [])):
        joints = standing(*LATTICE.to_robot(*walk[0]), height_mm)
        for before, after in pairwise(walk):
            target = Pose(*LATTICE.to_robot(*after), height_mm)
            move = GUARD.check_linear(joints, target, posture=7, speed_mm_s=250)
            assert move.duration_s == pytest.approx(20 / 250), (before, after)
            assert move.end_pose == target
            joints = move.end


def test_the_watchdogs_motion_is_allowed_both_ways() -> None:
    out = GUARD.check_pose_joint(REST, Pose(600, 0, 300), posture=7, percent=30)
    there = GUARD.check_linear(out.end, Pose(500, 0, 300), posture=7, speed_mm_s=250)
    assert there.duration_s == pytest.approx(0.4)
    back = GUARD.check_linear(there.end, Pose(600, 0, 300), posture=7, speed_mm_s=250)
    assert back.end.values == pytest.approx(out.end.values, abs=1e-6)


def test_posture_7_is_the_only_one_that_reaches_every_place() -> None:
    places = [*CORNERS.values(), *SLOTS.values()]
    everywhere = [
        posture
        for posture in range(8)
        if all(ARM.is_reachable(Pose(x, y, z), posture) for x, y in places for z in (55.0, 200.0))
    ]
    assert everywhere == [7]


def test_rest_hides_nothing_from_the_top_camera() -> None:
    camera = PROFILE.twin.cameras["top"].position_mm
    surface_mm = PROFILE.heights.surface_mm
    screen = PROFILE.display
    near, left = screen.corner_x_mm, screen.corner_y_mm + screen.width_px * screen.pixel_mm
    points = ARM.link_points_mm(REST.values)
    radii = [LINK_RADIUS_MM] * 4 + [WRIST_RADIUS_MM, GRIPPER_RADIUS_MM]
    for start, end, radius in zip(points, points[1:], radii, strict=False):
        for part in range(21):
            x, y, z = (s + (e - s) * part / 20 for s, e in zip(start, end, strict=True))
            grow = (camera[2] - surface_mm) / (camera[2] - z)
            shadow_x = camera[0] + (x - camera[0]) * grow
            shadow_y = camera[1] + (y - camera[1]) * grow
            assert shadow_x + radius * grow < near or shadow_y - radius * grow > left


def test_joint_move_lasts_as_long_as_its_slowest_joint() -> None:
    target = JointPositions((REST.values[0] - 50.0, *REST.values[1:5], REST.values[5] + 20.0))
    move = GUARD.check_joint(REST, target, percent=50)
    assert move.duration_s == pytest.approx(50 / (250 * 0.5))
    assert move.end == target
    assert move.end_pose == ARM.forward(target)


def test_turning_on_the_spot_takes_time_too() -> None:
    joints = standing(500, 0, 300)
    turned = Pose(500, 0, 300, 180, 0, 120)
    move = GUARD.check_linear(joints, turned, posture=7, speed_mm_s=250)
    assert move.duration_s == pytest.approx(60 / 120)
    assert ARM.forward(move.end).c_deg == pytest.approx(120)


def test_staying_where_it_is_is_allowed_and_takes_no_time() -> None:
    joints = standing(500, 0, 300)
    still = GUARD.check_linear(joints, Pose(500, 0, 300), posture=7, speed_mm_s=250)
    assert still.duration_s == pytest.approx(0, abs=1e-9)
    assert GUARD.check_joint(joints, joints, percent=30).duration_s == 0


def test_turns_of_j6_are_told_with_the_move() -> None:
    start = JointPositions((0.0, 20.0, 100.0, 0.0, 60.0, 150.0))
    target = JointPositions((0.0, 20.0, 100.0, 0.0, 60.0, 195.0))
    assert GUARD.check_joint(start, target, percent=30).turns == 0x00100000
    along = GUARD.check_linear(start, ARM.forward(target), posture=7, speed_mm_s=250)
    assert along.end.values[5] == pytest.approx(195.0)
    assert along.turns == 0x00100000


def test_a_line_passed_once_is_not_swept_again_and_another_is() -> None:
    guard = Guard.from_profile(PROFILE)
    start = guard.arm.solve(Pose(510, -100, 136.5), 7)
    first = guard.check_linear(start, Pose(510, -80, 136.5), posture=7, speed_mm_s=250)
    again = guard.check_linear(start, Pose(510, -80, 136.5), posture=7, speed_mm_s=250)
    assert again is first
    held = guard.check_linear(
        start, Pose(510, -80, 136.5), posture=7, speed_mm_s=250, holds_block=True
    )
    assert held is not first
    with pytest.raises(MotionRefused):
        guard.check_linear(start, Pose(510, -80, 136.5), posture=7, speed_mm_s=5000)
