"""Targets beyond all reach are refused at once, in the usual words, by either guard."""

from __future__ import annotations

import math

import pytest

from cell.errors import MotionRefused
from cell.geometry import JointPositions, Pose
from cell.motion.bounds import FAR_MM
from cell.motion.motion_guard import MotionGuard
from tests.cell.motion.cells import GUARD, REST
from tests.cell.motion.test_chain_guard import TABLE, lynx_guard, scara_guard

SIX = (GUARD, REST)
SCARA = (scara_guard([TABLE]), JointPositions((0.0, 90.0, 0.0, 0.0)))
LYNX = (lynx_guard([]), JointPositions((0.0, 90.0, -90.0, 0.0, 0.0)))
CELLS = pytest.mark.parametrize(
    ("guard", "start"), [SIX, SCARA, LYNX], ids=["six axes", "scara", "lynx"]
)
HUGE = [1e5, 1e20, -1e20, 1e300, -1e308, 1.7e308, math.inf, -math.inf, math.nan]


def _check(guard: MotionGuard, start: JointPositions, target: Pose, *, is_line: bool) -> None:
    if is_line:
        guard.check_linear(start, target, posture=7, speed_mm_s=100.0)
    else:
        guard.check_pose_joint(start, target, posture=7, percent=50.0)


@CELLS
@pytest.mark.parametrize("value", HUGE)
@pytest.mark.parametrize("name", ["x", "y", "z"])
@pytest.mark.parametrize("is_line", [True, False])
def test_a_place_that_is_absurdly_far_is_refused(
    guard: MotionGuard, start: JointPositions, value: float, name: str, is_line: bool
) -> None:
    here = guard.arm.forward(start)
    figures = {"x": here.x_mm, "y": here.y_mm, "z": here.z_mm, name: value}
    target = Pose(figures["x"], figures["y"], figures["z"], here.a_deg, here.b_deg, here.c_deg)
    with pytest.raises(MotionRefused) as refused:
        _check(guard, start, target, is_line=is_line)
    assert refused.value.what == f"tool {name}"
    assert refused.value.value == value or math.isnan(value)
    assert abs(refused.value.nearest) < FAR_MM
    assert refused.value.nearest_point_mm is not None
    assert len(str(refused.value)) < 250


@CELLS
@pytest.mark.parametrize("value", HUGE)
def test_a_joint_that_is_absurdly_far_is_refused(
    guard: MotionGuard, start: JointPositions, value: float
) -> None:
    target = JointPositions((*start.values[:3], value, *start.values[4:]))
    with pytest.raises(MotionRefused, match=r"^J4 .* nearest allowed -?\d+\.\d "):
        guard.check_joint(start, target, percent=50.0)


@CELLS
@pytest.mark.parametrize("angle_deg", [361.0, -361.0, 1e9, -1e300, math.inf, math.nan])
@pytest.mark.parametrize("is_line", [True, False])
def test_a_tool_turned_by_more_than_a_whole_turn_is_refused(
    guard: MotionGuard, start: JointPositions, angle_deg: float, is_line: bool
) -> None:
    here = guard.arm.forward(start)
    target = Pose(here.x_mm, here.y_mm, here.z_mm, here.a_deg, here.b_deg, angle_deg)
    with pytest.raises(MotionRefused, match="tool c is turned by more than a whole turn"):
        _check(guard, start, target, is_line=is_line)


def test_a_whole_turn_is_the_same_as_none() -> None:
    here = GUARD.arm.forward(REST)
    target = Pose(here.x_mm, here.y_mm, here.z_mm, here.a_deg, here.b_deg, here.c_deg - 360.0)
    GUARD.check_pose_joint(REST, target, posture=7, percent=50.0)
