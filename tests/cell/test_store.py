import pytest

from cell.errors import StoreError
from cell.profile import StoreProfile
from cell.store import StorePlan, StoreSlot, place_of_slot

PLAN = StorePlan(
    (
        StoreSlot(number=8, kind="cube", colour="red", x_mm=275, y_mm=150),
        StoreSlot(number=7, kind="cube", colour="red", x_mm=165, y_mm=150),
        StoreSlot(number=13, kind="bridge", colour="red", x_mm=275, y_mm=250),
    )
)


def test_plan_x_runs_along_robot_x_and_plan_y_against_robot_y() -> None:
    place = place_of_slot(PLAN.slot(7), StoreProfile(corner_mm=(-250, 700)))
    assert (place.x_mm, place.y_mm, place.yaw_deg) == (-85, 550, 0)


def test_a_turned_plan_turns_its_slots_and_their_blocks() -> None:
    place = place_of_slot(PLAN.slot(7), StoreProfile(corner_mm=(0, 0), angle_deg=90))
    assert (place.x_mm, place.y_mm) == pytest.approx((150, 165))
    assert place.yaw_deg == 90


def test_slots_of_a_kind_and_colour_come_lowest_first() -> None:
    assert [slot.number for slot in PLAN.slots_of("cube", "red")] == [7, 8]
    assert PLAN.slots_of("cube", "blue") == ()


def test_an_unknown_slot_is_refused_by_name() -> None:
    with pytest.raises(StoreError, match=r"no slot 99; it has 8, 7, 13"):
        PLAN.slot(99)
