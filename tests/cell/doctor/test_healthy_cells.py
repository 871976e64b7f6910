"""A hundred healthy cells of all kinds: the doctor finds nothing, and leaves nothing behind."""

from __future__ import annotations

import random
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from cell.doctor import PageState
from cell.links.base import Link
from cell.profile import Profile
from cell.twin.keeping import dump_world
from tests.cell.doctor.ward import NOW, Ward, mash

CELLS = 100
WITH_PICTURES = range(0, CELLS, 10)


def healthy_profile(rng: random.Random) -> Profile:
    """Return the profile of a cell that differs from ours within what is healthy."""
    profile = mash()
    lattice = profile.lattice.model_copy(
        update={
            "origin_mm": (710.0 - rng.uniform(0, 15), -265.0 + rng.uniform(-10, 10)),
            "step_mm": rng.uniform(18.0, 20.0),
        }
    )
    store = profile.store.model_copy(update={"corner_mm": (-250.0, 700.0 - rng.uniform(0, 5))})
    heights = profile.heights.model_copy(update={"service_mm": rng.uniform(190.0, 200.0)})
    gripper = profile.gripper.model_copy(
        update={"module_id": rng.randrange(1, 33), "open_mm": rng.uniform(50.0, 66.0)}
    )
    arm = profile.arm.model_copy(
        update={
            "robot": 1,
            "slot": rng.choice((1, 1, 2)),
            "linear_speed_mm_s": rng.uniform(50, 400),
        }
    )
    top = profile.cameras["top"].model_copy(
        update={
            "plane_map_date": rng.choice((None, (NOW - timedelta(days=rng.randrange(366))).date()))
        }
    )
    changes = {
        "lattice": lattice,
        "store": store,
        "heights": heights,
        "gripper": gripper,
        "arm": arm,
        "cameras": {**profile.cameras, "top": top},
    }
    return profile.model_copy(update=changes)


def healthy_ward(number: int, folder: Path) -> Ward:
    rng = random.Random(number)
    ward = Ward(healthy_profile(rng), seed=number)
    if number in WITH_PICTURES:
        ward = Ward(seed=number).with_pictures()
    surroundings = ward.surroundings
    if rng.random() < 0.5:
        surroundings.state_folder = folder
        (folder / "anything.json").write_text("{}")
        surroundings.wall = lambda: NOW + timedelta(days=365 * 3)
        if ward.profile.cameras["top"].plane_map_date is not None:
            surroundings.wall = lambda: NOW
            surroundings.state_folder = None
    if rng.random() < 0.5:
        surroundings.page_told = PageState(is_connected=True, width_px=1920, height_px=1080)
    surroundings.free = rng.randrange(2 * 10**9, 10**12)
    world = rng.choice(("dark", "in service", "was in service", "lights left on"))
    if world != "dark":
        ward.in_service()
        ward.cell.show(rng.choice(("black", "white", "water")))
    if world == "was in service":
        ward.cell.close()
    if world == "lights left on":
        ward.cell.close()
        ward.cell.world.set_output(
            ward.profile.outputs.lights, is_on=True, now_s=ward.cell.clock.now_s()
        )
    return ward


@pytest.mark.parametrize("number", range(CELLS))
def test_a_healthy_cell_has_no_finding(number: int, tmp_path: Path) -> None:
    report = healthy_ward(number, tmp_path).examine()
    assert report.findings == (), f"cell of seed {number}"
    assert len(report.fine) > 20


@pytest.mark.parametrize("is_in_service", [False, True])
def test_an_examination_leaves_the_cell_as_it_was(is_in_service: bool) -> None:
    ward = Ward().with_pictures()
    if is_in_service:
        ward.in_service()
    cell = ward.cell
    state = cell.behind.controller._commands.state
    outputs = {bit for bit, is_on in cell.world.outputs.items() if is_on}
    before = (
        state.is_open,
        state.holder,
        state.servo_ready_s,
        state.program,
        cell.world.joints_deg(ward.now_s),
        cell.world.opening_mm(ward.now_s),
        cell.behind.television.is_on,
    )
    blocks = cell.world.whereabouts()
    ward.examine()
    assert blocks == cell.world.whereabouts()
    if not is_in_service:
        after_state = cell.behind.controller._commands.state
        assert outputs == {bit for bit, is_on in cell.world.outputs.items() if is_on}
        assert before == (
            after_state.is_open,
            after_state.holder,
            after_state.servo_ready_s,
            after_state.program,
            cell.world.joints_deg(ward.now_s),
            cell.world.opening_mm(ward.now_s),
            cell.behind.television.is_on,
        )
    assert dump_world(cell.world, ward.now_s)


def test_an_examination_in_service_takes_nothing_from_the_cell() -> None:
    ward = Ward().in_service()
    patient = ward.patient
    assert patient.is_in_service
    cell = ward.cell
    dispose, disposed = cell.dispose, []
    cell.dispose = lambda: disposed.append(True)  # type: ignore[method-assign]
    ward.examine()
    assert disposed
    cell.move_to(600.0, 0.0, 250.0)
    cell.gripper.move_to(40.0)
    assert cell.display.is_on()
    dispose()


def test_what_was_not_checked_is_told_with_its_reason() -> None:
    report = Ward().with_pictures().examine()
    told = {(one.component, one.what) for one in report.unchecked}
    assert ("camera top", "age of the plane map") in told
    ward = Ward().with_pictures()
    ward.learned = {}
    told = {(one.component, one.what) for one in ward.examine().unchecked}
    assert ("camera oblique", "focus and place") in told
    assert all(one.why for one in report.unchecked)


def test_a_disabled_device_is_not_looked_at() -> None:
    gripper = mash().gripper.model_copy(update={"enabled": False})
    ward = Ward().believing(profile=mash().model_copy(update={"gripper": gripper}))
    ward.lines["gripper"] = _never
    report = ward.examine()
    assert report.findings == ()
    assert any(one.component == "gripper" for one in report.unchecked)


def _never() -> Link:
    raise AssertionError("the line of a disabled device was opened")


def test_the_clock_of_a_cell_in_order_may_run_a_little_apart() -> None:
    ward = Ward()
    times = iter([NOW, NOW, NOW, *([NOW + timedelta(seconds=1)] * 9)])
    ward.surroundings = replace(ward.surroundings, wall=lambda: next(times))
    assert ward.examine("computer").findings == ()
