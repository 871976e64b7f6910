"""An arm that stands where it may not can still be brought back, and only back."""

from __future__ import annotations

import pytest

from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose
from cell.profile import BoxProfile
from tests.cell.motion.cells import ARM, GUARD, POST, REST, TABLE, guard_with, standing

SUNK = standing(510, -100, 45)
"""Fingertips 5.5 mm inside the table."""
TWISTED = JointPositions((0.0, 20.0, 100.0, 0.0, 104.0, 0.0))
"""J5 is 4 deg past its limit."""


def test_fingers_in_the_table_may_be_lifted() -> None:
    move = GUARD.check_linear(SUNK, Pose(510, -100, 200), posture=7, speed_mm_s=100)
    assert ARM.forward(move.end).z_mm == pytest.approx(200)


def test_fingers_in_the_table_may_be_lifted_a_little() -> None:
    GUARD.check_linear(SUNK, Pose(510, -100, 48), posture=7, speed_mm_s=100)


@pytest.mark.parametrize("target", [Pose(510, -100, 44), Pose(510, -100, -100)])
def test_fingers_in_the_table_may_not_go_deeper(target: Pose) -> None:
    with pytest.raises(MotionRefused, match="the hand into the table") as caught:
        GUARD.check_linear(SUNK, target, posture=7, speed_mm_s=100)
    assert caught.value.nearest == pytest.approx(45.0)


def test_once_out_the_fingers_may_not_go_in_again() -> None:
    guard = guard_with([TABLE, POST])
    sunk = standing(510, -100, 45)
    with pytest.raises(MotionRefused, match="into the post"):
        guard.check_linear(sunk, Pose(510, 100, 100), posture=7, speed_mm_s=100)


def test_joint_past_its_limit_may_turn_back() -> None:
    back = JointPositions((*TWISTED.values[:4], 60.0, 0.0))
    assert GUARD.check_joint(TWISTED, back, percent=10).end == back
    part = JointPositions((*TWISTED.values[:4], 102.0, 0.0))
    assert GUARD.check_joint(TWISTED, part, percent=10).end == part


def test_joint_past_its_limit_may_not_turn_further() -> None:
    further = JointPositions((*TWISTED.values[:4], 106.0, 0.0))
    with pytest.raises(MotionRefused, match="J5 would pass its limit") as caught:
        GUARD.check_joint(TWISTED, further, percent=10)
    assert caught.value.value == pytest.approx(106)
    assert caught.value.limit == 100


def test_leaving_one_violation_may_not_enter_another() -> None:
    wall = BoxProfile(name="wall", min_mm=(400, -90, 38.5), max_mm=(620, -40, 300))
    guard = guard_with([TABLE, wall])
    sunk = standing(510, -140, 45)
    with pytest.raises(MotionRefused, match="into the wall"):
        guard.check_linear(sunk, Pose(510, -60, 50), posture=7, speed_mm_s=100)


def test_reading_noise_of_the_controller_is_no_violation() -> None:
    rounded = JointPositions(tuple(round(angle, 2) for angle in standing(510, -100, 55).values))
    GUARD.check_linear(rounded, Pose(510, -100, 200), posture=7, speed_mm_s=250, holds_block=True)
    at_limit = JointPositions((170.004, *REST.values[1:]))
    GUARD.check_joint(at_limit, REST, percent=30)
