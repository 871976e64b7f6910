"""Grips: what the fingers can do beside blocks, held against the fingers' own outlines."""

from __future__ import annotations

import math

import pytest

from benchmarks.messes import mess, store
from cell.cleaning.grips import Grip, GripPlanner, beside, folded, plan_removal
from cell.cleaning.sight import LyingBlock, body_of
from cell.contact import Jaw, push_out
from cell.profile import load_profile
from cell.store import TablePlace

PROFILE = load_profile("mash")
PLANNER = GripPlanner(PROFILE.gripper)


def lying(
    x: float, y: float, yaw_deg: float = 0.0, kind: str = "cube", colour: str = "red"
) -> LyingBlock:
    return LyingBlock(kind=kind, colour=colour, body=body_of(PROFILE.blocks, kind, x, y, yaw_deg))


def jaw_of(grip: Grip) -> Jaw:
    tool = grip.tool_place
    turn = math.radians(tool.yaw_deg + 90.0)
    return Jaw(
        x_mm=tool.x_mm,
        y_mm=tool.y_mm,
        axis=(math.cos(turn), math.sin(turn)),
        finger_width_mm=PROFILE.gripper.finger_width_mm,
        finger_thickness_mm=PROFILE.gripper.finger_thickness_mm,
    )


def test_a_block_alone_is_gripped_at_its_middle() -> None:
    grip = PLANNER.best(lying(500, 0, 20.0), [])
    assert grip is not None
    assert grip.along_mm == 0.0
    assert grip.opening_mm <= PROFILE.gripper.open_mm


def test_a_cube_in_a_row_is_gripped_across_the_row() -> None:
    row = [lying(500 + 33.1 * i, 0) for i in range(3)]
    grip = PLANNER.best(row[1], [row[0].body, row[2].body])
    assert grip is not None
    assert folded(grip.place.yaw_deg) == pytest.approx(0.0)


def test_four_cubes_in_a_square_leave_no_room() -> None:
    square = [lying(500 + 33.1 * i, 33.1 * j) for i in range(2) for j in range(2)]
    plan = plan_removal(square, [], PLANNER)
    assert plan.steps == ()
    assert len(plan.stuck) == 4


def test_a_bridge_with_a_cube_at_its_middle_is_gripped_beside_it() -> None:
    bridge, cube = lying(500, 0, 30.0, "bridge"), lying(500, 0, 30.0)
    side = math.radians(120.0)
    cube = cube.moved((33.2 * math.cos(side), 33.2 * math.sin(side)))
    grip = PLANNER.best(bridge, [cube.body])
    assert grip is not None
    assert abs(grip.along_mm) > 20.0


def test_taking_one_block_makes_room_for_the_next() -> None:
    stack = [lying(500, 33.1 * i, 0.0, "bridge") for i in range(2)]
    plan = plan_removal([*stack, lying(500, 80, 0.0)], [], PLANNER)
    assert [step.block.kind for step in plan.steps] == ["cube"]
    assert len(plan.stuck) == 2
    ends = [lying(566.6, 0), lying(600.2, 0), lying(500, 0, 0.0, "bridge")]
    assert len(plan_removal(ends, [], PLANNER).steps) == 3


def test_a_poorly_known_block_needs_more_room() -> None:
    sure = lying(500, 0)
    unsure = LyingBlock(kind="cube", colour="red", body=sure.body, deviation_mm=3.0)
    walls = [lying(500, y).body for y in (46.5, -46.5)] + [lying(x, 0).body for x in (453, 547)]
    assert PLANNER.best(sure, walls) is not None
    assert PLANNER.best(unsure, walls) is None


def test_what_the_arm_cannot_reach_is_not_gripped() -> None:
    planner = GripPlanner(PROFILE.gripper, lambda place: False)
    assert planner.best(lying(500, 0), []) is None
    assert planner.fits(lying(500, 0), [])


def test_a_way_along_a_turned_place_follows_the_turn_of_the_tool() -> None:
    at = beside(TablePlace(x_mm=0.0, y_mm=0.0, yaw_deg=170.0), 10.0)
    assert (at.x_mm, at.y_mm) == pytest.approx(
        (10.0 * math.cos(math.radians(-10.0)), 10.0 * math.sin(math.radians(-10.0)))
    )


@pytest.mark.parametrize("part", range(4))
def test_in_no_mess_a_finger_comes_down_on_or_closes_against_another_block(part: int) -> None:
    plan = store()
    for seed in range(1000 + 12 * part, 1012 + 12 * part):
        left = mess(seed, PROFILE, plan)
        blocks = [
            lying(place.x_mm, place.y_mm, place.yaw_deg, plan.slot(number).kind)
            for number, place in left.items()
        ]
        removal = plan_removal(blocks, [], PLANNER)
        gone: list[LyingBlock] = []
        for step in removal.steps:
            jaw = jaw_of(step.grip)
            rest = [b for b in blocks if b is not step.block and b not in gone]
            for finger in jaw.fingers(step.grip.opening_mm):
                for body in [step.block.body, *(b.body for b in rest)]:
                    hit = push_out(body.polygon(), finger.polygon())
                    assert hit is None, f"seed {seed}: {step}"
            for other in rest:
                span = jaw.span(other.body)
                between = span is not None and span[0] < 0.5 * step.grip.opening_mm
                assert not (between and span is not None and span[1] > -0.5 * step.grip.opening_mm)
            gone.append(step.block)
