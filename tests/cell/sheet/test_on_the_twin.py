"""The twin's gripper camera looks at a sheet whose place the program does not know."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.geometry import CameraView, LensModel, Pose, Transform
from cell.motion.guard import Guard
from cell.profile import PlaceProfile, Profile, StoreProfile
from cell.profile.cameras import LensProfile
from cell.sheet import lay_out
from cell.sheet.looking import LookingPose, hand_camera, looking_poses
from cell.sheet.reading import Look, SheetReading, read_sheet
from cell.store import StorePlan, place_of_slot
from cell.twin_cell import TwinCell
from tests.cell.sheet.bench import MASH_SLOTS, PROFILE, SURFACE_MM

PLAN = StorePlan(MASH_SLOTS)
LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)


def lens_of(camera: str) -> LensModel:
    placing = PROFILE.twin.cameras[camera]
    return LensModel(
        width_px=1280,
        height_px=960,
        focal_u_px=placing.focal_px,
        focal_v_px=placing.focal_px,
        centre_u_px=placing.centre_px[0],
        centre_v_px=placing.centre_px[1],
        k1=placing.k1,
        k2=placing.k2,
    )


def mount_of(camera: str) -> Transform:
    placing = PROFILE.twin.cameras[camera]
    return Transform.from_pose(Pose(*placing.position_mm, *placing.rotation_deg))


@cache
def calibrated() -> Profile:
    """Return the profile with the gripper camera's lens and mount as they truly are."""
    drawn = PROFILE.twin.cameras["gripper"]
    camera = PROFILE.cameras["gripper"].model_copy(
        update={
            "lens": LensProfile(
                focal_px=(drawn.focal_px, drawn.focal_px), centre_px=drawn.centre_px,
                k1=drawn.k1, k2=drawn.k2,
            ),
            "mount": PlaceProfile(
                position_mm=drawn.position_mm, rotation_deg=drawn.rotation_deg
            ),
        }
    )  # fmt: skip
    made: Profile = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "gripper": camera}})
    return made


@cache
def poses() -> tuple[LookingPose, ...]:
    return looking_poses(PROFILE, LAYOUT, lens_of("gripper"), mount_of("gripper"))


def twin(store: StoreProfile) -> TwinCell:
    truth: Profile = PROFILE.model_copy(update={"store": store})
    cell = assemble_twin(PROFILE, PLAN, seed=3, clock=SimulatedClock(), truth=truth)
    cell.open()
    cell.switch_lights(is_on=True)
    return cell


def look_around(cell: TwinCell) -> SheetReading:
    hand = hand_camera(calibrated(), "gripper")
    looks = []
    for one in poses():
        cell.move_joints(one.joints)
        looks.append(hand.look(cell.grab("gripper").pixels, cell.read_pose()))
    return read_sheet(looks, LAYOUT, surface_mm=SURFACE_MM, expected=PROFILE.store)


def test_the_guard_passes_every_motion_from_pose_to_pose_and_every_marker_is_seen() -> None:
    assert {index for one in poses() for index in one.sees} == set(range(12))
    guard = Guard.from_profile(PROFILE)
    cell = twin(PROFILE.store)
    try:
        for one in poses():
            cell.move_joints(one.joints)
            assert guard.arm.forward(one.joints).x_mm == pytest.approx(one.pose.x_mm, abs=0.01)
    finally:
        cell.dispose()


@pytest.mark.parametrize("seed", range(3))
def test_a_full_store_is_found_wherever_it_lies_and_every_block_is_seen(seed: int) -> None:
    random = np.random.default_rng([seed, 21])
    x, y = random.uniform(-20, 20), random.uniform(0, 25)
    place = {"corner_mm": (-250.0 + x, 700.0 + y), "angle_deg": float(random.uniform(-3, 3))}
    store: StoreProfile = PROFILE.store.model_copy(update=place)
    cell = twin(store)
    try:
        reading = look_around(cell)
    finally:
        cell.dispose()
    assert reading.place is not None
    plan = np.array([(slot.x_mm, slot.y_mm) for slot in MASH_SLOTS])
    places = [place_of_slot(slot, store) for slot in MASH_SLOTS]
    truth = np.array([(place.x_mm, place.y_mm) for place in places])
    off = np.linalg.norm(reading.place.to_robot(plan) - truth, axis=1)
    assert float(np.sqrt(np.mean(off**2))) < 0.4, f"seed {seed}"
    assert {one.code for one in reading.findings} - {"covered"} == {"moved"}
    known = [one for one in reading.slots if one.state != "not known"]
    assert len(known) >= 16, f"seed {seed}"
    assert all(one.state == "occupied" for one in known), f"seed {seed}"
    assert all(one.is_right is not False for one in known), f"seed {seed}"


def test_the_oblique_camera_sees_most_of_an_empty_sheet() -> None:
    cell = twin(PROFILE.store)
    try:
        for block in cell.world.blocks.all():
            cell.world.blocks.put(replace(block, x_mm=-1200.0, y_mm=-1200.0))
        pixels = cell.grab("oblique").pixels
    finally:
        cell.dispose()
    view = CameraView(lens_of("oblique"), mount_of("oblique"))
    reading = read_sheet(
        [Look(pixels=pixels, view=view)], LAYOUT, surface_mm=SURFACE_MM, expected=PROFILE.store
    )
    assert len(reading.seen) >= 8
    assert {one.code for one in reading.findings} <= {"covered"}
    assert {one.state for one in reading.slots} <= {"empty", "not known"}
