"""Pushes: they make room, keep blocks on the field, and touch nothing else."""

from __future__ import annotations

import random

import pytest

from cell.cleaning.cleaner import screen_field
from cell.cleaning.grips import GripPlanner, plan_removal
from cell.cleaning.lumps import least_rectangle, lumps
from cell.cleaning.pushes import PushPlanner, slide
from cell.cleaning.sight import LyingBlock, Playground, StrangeThing, body_of
from cell.contact import Footprint, Outline, push_out
from cell.profile import load_profile

PROFILE = load_profile("mash")
GRIPS = GripPlanner(PROFILE.gripper)
FIELD = screen_field(PROFILE.display)
PUSHES = PushPlanner(PROFILE.gripper, GRIPS, FIELD)


def lying(x: float, y: float, yaw_deg: float = 0.0, kind: str = "cube") -> LyingBlock:
    return LyingBlock(kind=kind, colour="red", body=body_of(PROFILE.blocks, kind, x, y, yaw_deg))


HEAPS = {
    "square": [lying(500 + 33.1 * i, 33.1 * j) for i in range(2) for j in range(2)],
    "three by three": [lying(500 + 33.1 * i, 33.1 * j) for i in range(3) for j in range(3)],
    "bridges side by side": [lying(500, 33.1 * i, 0.0, "bridge") for i in range(3)],
    "at the edge": [lying(700 + 33.1 * i, 33.1 * j) for i in range(2) for j in range(2)],
}


def test_the_field_is_the_screen_less_a_margin() -> None:
    assert FIELD.outside_mm(500.0, 0.0) < -100.0
    assert FIELD.outside_mm(245.7, 0.0) == pytest.approx(25.0)
    assert FIELD.outside_mm(500.0, 340.0) == pytest.approx(35.0)


@pytest.mark.parametrize("name", HEAPS)
def test_a_heap_without_a_grip_has_a_push_that_makes_room(name: str) -> None:
    blocks = list(HEAPS[name])
    assert plan_removal(blocks, [], GRIPS).steps == ()
    push = PUSHES.best(blocks, [])
    assert push is not None
    assert push.frees >= 1
    assert FIELD.outside_mm(push.block.body.x_mm, push.block.body.y_mm) <= 0.0


def test_a_push_that_changed_nothing_is_not_tried_again() -> None:
    blocks = HEAPS["square"]
    first = PUSHES.best(blocks, [])
    assert first is not None
    ends = ((first.start.x_mm, first.start.y_mm), (first.end.x_mm, first.end.y_mm))
    second = PUSHES.best(blocks, [], [ends])
    assert second is not None
    assert (second.start, second.end) != (first.start, first.end)


def test_nothing_is_pushed_where_fingers_cannot_come_down_or_may_not_go() -> None:
    blocks = HEAPS["square"]
    ring = [
        Outline(body_of(PROFILE.blocks, "bridge", x, y, yaw).polygon())
        for x, y, yaw in (
            (516, 66, 0), (516, -34, 0), (466, 16, 90), (566, 16, 90),
        )
    ]  # fmt: skip
    assert PUSHES.best(blocks, ring) is None
    never = PushPlanner(PROFILE.gripper, GRIPS, FIELD, may_go=lambda start, end: False)
    assert never.best(blocks, []) is None
    unreachable = PushPlanner(PROFILE.gripper, GRIPS, FIELD, may_lie=lambda place: False)
    assert unreachable.best(blocks, []) is None


@pytest.mark.parametrize("seed", range(20))
def test_slid_blocks_never_lie_in_each_other(seed: int) -> None:
    chance = random.Random(seed)
    blocks = [lying(500 + 34 * i, 34 * j) for i in range(3) for j in range(2)]
    turn = chance.uniform(0, 360)
    pusher = Footprint(
        x_mm=470 + chance.uniform(0, 90), y_mm=-25.0, yaw_deg=turn, length_mm=17, width_mm=20
    )
    assert slide(blocks, pusher, []), f"seed {seed}"
    bodies = [block.body for block in blocks]
    for index, body in enumerate(bodies):
        for other in [*bodies[:index], pusher]:
            shift = push_out(body.polygon(), other.polygon())
            assert shift is None or max(map(abs, shift)) < 0.01, f"seed {seed}"


def test_a_lump_takes_in_the_blocks_that_touch_it_and_is_pushed_at_its_end() -> None:
    pair = [lying(500, 0).body, lying(533.1, 0).body]
    corners = [corner for body in pair for corner in body.polygon()]
    strange = StrangeThing(
        reason="test", x_mm=516, y_mm=0, corners=tuple(corners),
        edge=tuple(Outline(body.polygon()) for body in pair),
    )  # fmt: skip
    ground = Playground(blocks=(lying(566.5, 0), lying(400, 200)), strange=(strange,))
    ((box, others),) = lumps(ground)
    assert sorted((box.length_mm, box.width_mm)) == pytest.approx([34, 100], abs=3)
    assert len(others) == 1
    way = PUSHES.apart(box, others)
    assert way is not None
    start, _ = way
    assert abs(start.x_mm - box.x_mm) > 20.0


def test_a_large_thing_is_no_lump() -> None:
    corners = ((300.0, -200.0), (600.0, -200.0), (600.0, 100.0), (300.0, 100.0))
    strange = StrangeThing(
        reason="test", x_mm=450, y_mm=0, corners=corners, edge=(Outline(corners),)
    )
    assert list(lumps(Playground(blocks=(), strange=(strange,)))) == []


def test_the_least_rectangle_finds_a_turned_block() -> None:
    box = least_rectangle(lying(500, 0, 30.0, "bridge").body.polygon())
    assert sorted((box.length_mm, box.width_mm)) == pytest.approx([33, 100], abs=0.1)
    assert (box.x_mm, box.y_mm) == pytest.approx((500, 0))
