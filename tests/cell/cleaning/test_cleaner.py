"""What the cell does around a mess: ledger, slots, refusals, a kill in the middle."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.messes import store
from cell.assembly import assemble_twin
from cell.cleaning.grips import Grip
from cell.clock import SimulatedClock
from cell.errors import MotionRefused, UnreachablePose, VisionError
from cell.ledger import Phase
from cell.manipulation import Deployment
from cell.profile import load_profile
from cell.store import TablePlace
from cell.twin.blocks import TwinBlock
from cell.twin_cell import TwinCell


def make(folder: Path | None = None) -> TwinCell:
    cell = assemble_twin(
        load_profile("mash"), store(), seed=3, clock=SimulatedClock(), state_folder=folder
    )
    cell.open()
    return cell


@pytest.fixture
def cell() -> Iterator[TwinCell]:
    cell = make()
    yield cell
    cell.dispose()


def truth(cell: TwinCell, slot: int) -> TwinBlock:
    return next(b for b in cell.world.whereabouts() if b.block == f"slot {slot}")


def leave(cell: TwinCell, slot: int, x: float, y: float, yaw_deg: float = 0.0) -> None:
    cell.world.blocks.put(replace(truth(cell, slot), x_mm=x, y_mm=y, yaw_deg=yaw_deg))


def off_mm(block: TwinBlock, place: TablePlace) -> float:
    return math.hypot(block.x_mm - place.x_mm, block.y_mm - place.y_mm)


def test_a_plan_tells_turn_and_grip_of_every_block_and_touches_nothing(cell: TwinCell) -> None:
    leave(cell, 7, 500.0, 0.0, 10.0)
    leave(cell, 13, 600.0, 100.0, -40.0)
    before = {b.block: b for b in cell.world.whereabouts()}
    plan = cell.plan_from_picture()
    assert sorted(one.turn or 0 for one in plan.seen) == [1, 2]
    assert all(one.grip is not None and one.why_not == "" for one in plan.seen)
    assert {b.block: b for b in cell.world.whereabouts()} == before
    assert cell.ledger.blocks_out() == {}


def test_a_square_of_cubes_is_pushed_apart_first(cell: TwinCell) -> None:
    for slot, x, y in ((1, 0, 0), (5, 33.2, 0), (7, 0, 33.2), (9, 33.2, 33.2)):
        leave(cell, slot, 500.0 + x, y)
    plan = cell.plan_from_picture()
    assert plan.push is not None
    assert all("no room for the fingers" in one.why_not for one in plan.seen)
    cleaning = cell.clean_from_picture()
    assert sorted(cleaning.home) == [1, 5, 7, 9]
    assert cleaning.pushes >= 1
    assert cleaning.left == ()
    assert cell.world.harms == ()


def test_a_bridge_gripped_beside_its_middle_lies_in_the_middle_of_its_slot(cell: TwinCell) -> None:
    # Cubes on both sides of its middle leave room only near its ends.
    leave(cell, 13, 500.0, 0.0)
    leave(cell, 7, 500.0, 33.3)
    leave(cell, 9, 500.0, -33.3)
    plan = cell.plan_from_picture()
    bridge = next(one for one in plan.seen if one.block and one.block.kind == "bridge")
    assert bridge.grip is not None
    grip = Grip(place=bridge.grip.place, along_mm=40.0, opening_mm=56.0, clearance_mm=3.0)
    cell.manipulator.bring_home(13, grip)
    assert off_mm(truth(cell, 13), cell.manipulator.slot_place(13)) < 3.0


def test_a_block_of_a_sort_that_has_no_free_slot_is_left_and_the_others_go_home(
    cell: TwinCell,
) -> None:
    spare = replace(truth(cell, 7), block="spare", x_mm=500.0, y_mm=0.0)
    cell.world.blocks.put(spare)
    leave(cell, 16, 600.0, 100.0)
    cleaning = cell.clean_from_picture()
    assert cleaning.home == (16,)
    (left,) = cleaning.left
    assert "red cube at (500, 0) mm: the store has no free slot" in left
    assert "by hand" in left


def test_what_the_ledger_has_out_and_nobody_sees_is_told_or_felt_in_its_slot(
    cell: TwinCell,
) -> None:
    cell.lay_out(
        [Deployment(slot=7, x_mm=500.0, y_mm=0.0), Deployment(slot=9, x_mm=600.0, y_mm=0.0)]
    )
    home = cell.manipulator.slot_place(7)
    leave(cell, 7, home.x_mm, home.y_mm)
    leave(cell, 9, -600.0, -600.0)
    cleaning = cell.clean_from_picture()
    assert cleaning.home == (7,)
    assert "green cube of slot 9: not seen anywhere, last at (600, 0) mm" in cleaning.left[0]
    assert set(cell.ledger.blocks_out()) == {9}


def test_the_ledger_follows_a_block_that_a_person_moved(cell: TwinCell) -> None:
    cell.lay_out([Deployment(slot=7, x_mm=500.0, y_mm=0.0)])
    leave(cell, 7, 620.0, -150.0, 30.0)
    assert cell.clean_from_picture().home == (7,)
    assert cell.manipulator.is_table_clean()


@pytest.mark.parametrize("phase", ["planned", "gripped", "placing"])
def test_killed_in_the_middle_the_ledger_still_brings_everything_home(
    tmp_path: Path, phase: Phase, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Killed(BaseException):
        """The process is gone."""

    first = make(tmp_path)
    leave(first, 7, 500.0, 0.0, 20.0)
    leave(first, 13, 600.0, 100.0, -40.0)

    def kill_after(name: str) -> None:
        real = getattr(first.ledger, name)

        def killing(*arguments: object) -> None:
            real(*arguments)
            raise Killed

        monkeypatch.setattr(first.ledger, name, killing)

    kill_after({"planned": "plan"}.get(phase, phase))
    with pytest.raises(Killed):
        first.clean_from_picture()
    transfer = first.ledger.open_transfer()
    assert transfer is not None
    assert transfer.phase == phase
    monkeypatch.undo()
    first.dispose()
    second = make(tmp_path)
    second.clean()
    second.clean_from_picture()
    for slot in (7, 13):
        assert off_mm(truth(second, slot), second.manipulator.slot_place(slot)) < 8.0
    assert second.manipulator.is_table_clean()
    second.dispose()


def test_a_place_out_of_reach_is_refused_before_anything_is_touched(cell: TwinCell) -> None:
    before = {b.block: b for b in cell.world.whereabouts()}
    joints = cell.arm.joints()
    for place in (
        TablePlace(x_mm=1200.0, y_mm=0.0, yaw_deg=0.0),
        TablePlace(x_mm=920.0, y_mm=520.0, yaw_deg=0.0),
        TablePlace(x_mm=100.0, y_mm=0.0, yaw_deg=0.0),
    ):
        with pytest.raises((MotionRefused, UnreachablePose)):
            cell.deploy(7, place)
        assert cell.ledger.open_transfer() is None
        assert cell.ledger.blocks_out() == {}
    assert {b.block: b for b in cell.world.whereabouts()} == before
    assert cell.arm.joints() == joints
    cell.deploy(7, TablePlace(x_mm=500.0, y_mm=0.0, yaw_deg=0.0))


def test_without_a_camera_that_is_mapped_nothing_is_cleaned_by_picture() -> None:
    profile = load_profile("mash")
    cameras = {
        name: camera.model_copy(update={"plane_map": None, "lens": None})
        for name, camera in profile.cameras.items()
    }
    profile = profile.model_copy(update={"cameras": cameras})
    cell = assemble_twin(profile, store(), seed=3, clock=SimulatedClock())
    cell.open()
    with pytest.raises(VisionError, match="calibrate the top camera first"):
        cell.clean_from_picture()
    cell.dispose()
