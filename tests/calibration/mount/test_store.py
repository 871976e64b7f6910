"""A calibrated gripper camera measures where the store's sheet lies, on a hidden cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.mount.checking import kept_state
from calibration.mount.procedure import calibrate_mount
from calibration.store_place.procedure import store_place
from calibration.verdict import Grade
from cell.assembly.twin import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile, StoreProfile
from cell.sheet import lay_out
from cell.sheet.looking import hand_camera, looking_poses
from cell.sheet.reading import read_sheet
from cell.store import StorePlan, place_of_slot
from tests.calibration.mount.test_procedure import (
    PROFILE,
    calibrated,
    hidden,
    recorded,
    state_of,
    true_miss_mm,
)
from tests.calibration.playing import played
from tests.cell.sheet.bench import MASH_SLOTS, SURFACE_MM

PLAN = StorePlan(MASH_SLOTS)
LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)


def site(profile: Profile) -> Site:
    return Site(profile=profile, plan=PLAN, current=())


def with_store(truth: Profile) -> tuple[Profile, StoreProfile]:
    store: StoreProfile = PROFILE.store.model_copy(
        update={"corner_mm": (-241.0, 712.0), "angle_deg": 1.4}
    )
    made: Profile = truth.model_copy(update={"store": store})
    return made, store


def test_the_gripper_camera_finds_the_sheet_and_tells_which_slots_are_empty() -> None:
    profile = calibrated_profile(PROFILE, [calibrated(0)])
    truth, store = with_store(hidden(0))
    cell = assemble_twin(profile, PLAN, seed=4, clock=SimulatedClock(), truth=truth)
    try:
        answers = {"way": "camera", "camera": "gripper"}
        cell.open()
        cell.switch_lights(is_on=True)
        measured = played(store_place(site(profile)), answers, cell)
        gone = {3, 8, 12}
        homes = [place_of_slot(slot, store) for slot in MASH_SLOTS if slot.number in gone]
        for block in cell.world.blocks.all():
            if any(np.hypot(block.x_mm - h.x_mm, block.y_mm - h.y_mm) < 20.0 for h in homes):
                cell.world.blocks.put(replace(block, x_mm=-1200.0, y_mm=-1200.0))
        hand = hand_camera(profile, "gripper")
        looks = []
        for one in looking_poses(profile, LAYOUT, hand.lens, hand.flange_from_camera, store=store):
            cell.move_joints(one.joints)
            looks.append(hand.look(cell.grab("gripper").pixels, cell.read_pose()))
    finally:
        cell.dispose()
    assert measured.grade is not Grade.BAD, measured.findings
    found = calibrated_place(measured.values)
    places = [(place_of_slot(slot, store), place_of_slot(slot, found)) for slot in MASH_SLOTS]
    off = [np.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm) for a, b in places]
    assert float(np.sqrt(np.mean(np.square(off)))) < 0.5
    reading = read_sheet(looks, LAYOUT, surface_mm=SURFACE_MM, expected=store)
    states = {one.number: one.state for one in reading.slots}
    assert {number for number, state in states.items() if state == "empty"} == gone
    assert sum(state == "occupied" for state in states.values()) >= len(states) - len(gone) - 2


def calibrated_place(values: Mapping[str, object]) -> StoreProfile:
    return StoreProfile.model_validate(
        {"corner_mm": values["store.corner_mm"], "angle_deg": values["store.angle_deg"]}
    )


def test_the_sheet_itself_is_a_target_for_the_camera() -> None:
    truth, _ = with_store(hidden(1))
    cell = assemble_twin(PROFILE, PLAN, seed=6, clock=SimulatedClock(), truth=truth)
    try:
        measured = played(calibrate_mount(site(PROFILE)), {"target": "sheet"}, cell)
    finally:
        cell.dispose()
    assert measured.grade is not Grade.BAD, measured.findings
    found = kept_state(recorded(measured))
    true = state_of(truth.twin.cameras["gripper"])
    assert float(found.lens[0]) == pytest.approx(float(true.lens[0]), rel=0.01)
    miss = true_miss_mm(found, truth)
    assert float(np.sqrt(np.mean(miss**2))) < 1.0
