"""The assembled cell on the twin: what its users do with it, checked against the truth."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.errors import DeviceError, GripFailed, MotionRefused, Stopped, StoreError
from cell.geometry import JointPositions
from cell.manipulation import Deployment
from cell.profile import load_profile
from cell.store import StorePlan, StoreSlot, TablePlace
from cell.twin.blocks import TwinBlock
from cell.twin_cell import TwinCell

PLAN = StorePlan(
    (
        StoreSlot(number=5, kind="cube", colour="blue", x_mm=495, y_mm=50),
        StoreSlot(number=7, kind="cube", colour="red", x_mm=165, y_mm=150),
        StoreSlot(number=8, kind="cube", colour="red", x_mm=275, y_mm=150),
        StoreSlot(number=13, kind="bridge", colour="red", x_mm=275, y_mm=250),
        StoreSlot(number=16, kind="cylinder", colour="green", x_mm=165, y_mm=350),
    )
)
LAYOUT = (
    Deployment(slot=7, x_mm=490, y_mm=-45),
    Deployment(slot=16, x_mm=490, y_mm=-265),
    Deployment(slot=13, x_mm=610, y_mm=-145, yaw_deg=30),
)


def make(folder: Path | None = None) -> TwinCell:
    return assemble_twin(
        load_profile("mash"), PLAN, seed=3, clock=SimulatedClock(), state_folder=folder
    )


@pytest.fixture
def cell() -> Iterator[TwinCell]:
    cell = make()
    cell.open()
    yield cell
    cell.dispose()


def truth(cell: TwinCell, slot: int) -> TwinBlock:
    return next(b for b in cell.world.whereabouts() if b.block == f"slot {slot}")


def off_mm(block: TwinBlock, place: TablePlace | Deployment) -> float:
    return math.hypot(block.x_mm - place.x_mm, block.y_mm - place.y_mm)


def move_by_hand(cell: TwinCell, slot: int, x: float, y: float, yaw_deg: float = 0.0) -> None:
    block = truth(cell, slot)
    cell.world.blocks.put(replace(block, x_mm=x, y_mm=y, yaw_deg=yaw_deg))


def test_blocks_are_laid_out_and_brought_home(cell: TwinCell) -> None:
    cell.lay_out(LAYOUT)
    for deployment in LAYOUT:
        block = truth(cell, deployment.slot)
        assert off_mm(block, deployment) < 2.0
        assert (block.yaw_deg - deployment.yaw_deg + 45) % 90 - 45 == pytest.approx(0, abs=3)
    assert cell.clean() == [7, 13, 16]
    for slot in PLAN.slots:
        assert off_mm(truth(cell, slot.number), cell.manipulator.slot_place(slot.number)) < 3.0


def test_laying_out_again_cleans_first(cell: TwinCell) -> None:
    cell.lay_out(LAYOUT)
    cell.lay_out([Deployment(slot=5, x_mm=550, y_mm=-165)])
    assert set(cell.ledger.blocks_out()) == {5}
    assert off_mm(truth(cell, 7), cell.manipulator.slot_place(7)) < 3.0


def test_the_scatter_of_many_transfers_does_not_add_up_to_a_miss(cell: TwinCell) -> None:
    generator = random.Random(6)
    for _ in range(100):
        place = Deployment(
            slot=7, x_mm=generator.uniform(490, 710), y_mm=generator.uniform(-265, -45)
        )
        cell.lay_out([place])
        assert off_mm(truth(cell, 7), place) < 8.0
        cell.clean()


def test_a_block_that_is_not_in_its_slot_is_missed_by_name(cell: TwinCell) -> None:
    move_by_hand(cell, 7, 0.0, 300.0)
    with pytest.raises(GripFailed, match=r"slot 7: expected a cube .* the fingers found nothing"):
        cell.lay_out(LAYOUT)
    assert cell.manipulator.is_table_clean()


def test_a_block_taken_off_the_table_does_not_keep_the_others_out(cell: TwinCell) -> None:
    cell.lay_out(LAYOUT)
    move_by_hand(cell, 7, 300.0, 500.0)
    with pytest.raises(GripFailed, match="slot 7"):
        cell.clean()
    assert off_mm(truth(cell, 16), cell.manipulator.slot_place(16)) < 3.0
    assert set(cell.ledger.blocks_out()) == {7}


def test_a_block_is_carried_by_hand_from_place_to_place(cell: TwinCell) -> None:
    there = TablePlace(x_mm=600.0, y_mm=-100.0, yaw_deg=0.0)
    assert cell.grip_at(cell.manipulator.slot_place(8)) == 8
    cell.release_at(there)
    assert off_mm(truth(cell, 8), there) < 2.0
    with pytest.raises(GripFailed, match="hold no block"):
        cell.release_at(there)
    with pytest.raises(StoreError, match="no block within"):
        cell.grip_at(TablePlace(x_mm=500.0, y_mm=0.0, yaw_deg=0.0))
    assert cell.clean_objects([8]) == [8]


def test_moves_by_pose_lattice_and_joints_end_where_asked(cell: TwinCell) -> None:
    cell.move_to(600.0, -100.0, 150.0)
    pose = cell.read_pose()
    assert (pose.x_mm, pose.y_mm, pose.z_mm) == pytest.approx((600.0, -100.0, 150.0), abs=0.02)
    cell.move_to_lattice(2, 3)
    pose = cell.read_pose()
    assert (pose.x_mm, pose.y_mm, pose.z_mm) == pytest.approx((650.0, -225.0, 200.0), abs=0.02)
    cell.move_joints(JointPositions((10.0, 20.0, 100.0, 0.0, 60.0, 0.0)))
    assert cell.arm.arm.read_joints().values == pytest.approx((10, 20, 100, 0, 60, 0), abs=0.02)


def test_a_refused_move_sends_nothing(cell: TwinCell) -> None:
    cell.move_to(600.0, -100.0, 200.0)
    before = cell.read_pose()
    with pytest.raises(MotionRefused, match="nearest|free up to"):
        cell.move_to(1200.0, 0.0, 200.0)
    with pytest.raises(MotionRefused):
        cell.move_to(600.0, -100.0, 20.0)
    with pytest.raises(MotionRefused, match="linear speed"):
        cell.set_speed(5000.0, 10.0)
    assert cell.read_pose().z_mm == pytest.approx(before.z_mm, abs=0.02)


def test_a_stop_is_obeyed_before_the_next_move(cell: TwinCell) -> None:
    cell.stop.stop("somebody pressed stop")
    with pytest.raises(Stopped, match="somebody pressed stop"):
        cell.move_to(600.0, -100.0, 200.0)
    cell.stop.clear()
    cell.move_to(600.0, -100.0, 200.0)


def test_pictures_change_with_the_cell_and_only_then(cell: TwinCell) -> None:
    cell.show("forest")
    first = cell.grab("top", 640, 480)
    assert first.pixels.shape == (480, 640, 3)
    assert cell.grab("top", 640, 480) is first
    cell.show("water")
    second = cell.grab("top", 640, 480)
    assert second.number == first.number + 1
    assert (second.pixels != first.pixels).mean() > 0.2
    with pytest.raises(DeviceError, match="has no mode of 123x45"):
        cell.grab("top", 123, 45)
    with pytest.raises(DeviceError, match="known are gripper, oblique, top"):
        cell.grab("ceiling")


def test_everything_is_off_after_closing_and_comes_up_again(cell: TwinCell) -> None:
    cell.show("white")
    assert cell.world.scene().picture == "white"
    cell.close()
    assert cell.world.scene().picture is None
    assert not cell.world.scene().are_lights_on
    assert not cell.world.is_powered()
    cell.open()
    cell.move_to(600.0, -100.0, 200.0)


def test_the_table_is_cleaned_by_what_the_camera_sees(cell: TwinCell) -> None:
    move_by_hand(cell, 8, 560.0, -100.0, yaw_deg=25.0)
    move_by_hand(cell, 16, 640.0, -200.0)
    move_by_hand(cell, 13, 560.0, 150.0, yaw_deg=-60.0)
    cleaning = cell.clean_from_picture()
    assert sorted(cleaning.home) == [8, 13, 16]
    assert cleaning.left == ()
    for slot in PLAN.slots:
        home = cell.manipulator.slot_place(slot.number)
        assert off_mm(truth(cell, slot.number), home) < 8.0, slot
    assert cell.clean_from_picture().home == ()


def test_another_process_finds_the_table_as_it_was_left(tmp_path: Path) -> None:
    first = make(tmp_path)
    first.open()
    first.lay_out(LAYOUT)
    left = {b.block: b for b in first.world.whereabouts()}
    first.dispose()
    second = make(tmp_path)
    assert {b.block: b for b in second.world.whereabouts()} == left
    second.open()
    assert second.clean() == [7, 13, 16]
    second.dispose()


def test_the_same_session_seed_gives_the_same_world(cell: TwinCell) -> None:
    def play(one: TwinCell) -> str:
        one.begin_session(77)
        one.open()
        one.lay_out(LAYOUT)
        one.clean()
        return one.world_json()

    start = cell.world_json()
    other = make()
    other.restore_world(start)
    first = play(cell)
    assert play(other) == first
    other.dispose()
