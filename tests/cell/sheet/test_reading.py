"""The sheet read back: where it lies, how it was printed, and what is wrong with it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.statistics import region_factor
from cell.geometry import PlaneMap, PlaneView
from cell.profile import StoreProfile
from cell.sheet import SheetError, lay_out
from cell.sheet.placing import Sighting, fit_place
from cell.sheet.reading import Look, SheetReading, read_sheet
from cell.store import place_of_slot
from tests.cell.sheet.bench import (
    LENS,
    MASH_SLOTS,
    PROFILE,
    SURFACE_MM,
    picture_of_sheet,
    view_from,
)

LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)
STORE = StoreProfile(corner_mm=(-250.0, 700.0))
VIEW = view_from(STORE, height_mm=720.0, tilt_deg=15.0, turn_deg=8.0)
PLAN_MM = np.array([(slot.x_mm, slot.y_mm) for slot in MASH_SLOTS])

Points = NDArray[np.float64]


def read(
    truth: StoreProfile = STORE,
    *,
    seed: int = 0,
    scale: float = 1.0,
    mirrored: bool = False,
    expected: StoreProfile | None = None,
    ruler_mm: float | None = None,
) -> SheetReading:
    pixels = picture_of_sheet(LAYOUT, truth, VIEW, seed=seed, scale=scale, mirrored=mirrored)
    return read_sheet(
        [Look(pixels=pixels, view=VIEW)],
        LAYOUT,
        surface_mm=SURFACE_MM,
        expected=expected,
        ruler_mm=ruler_mm,
    )


def true_slots(store: StoreProfile) -> Points:
    places = [place_of_slot(slot, store) for slot in MASH_SLOTS]
    return np.array([(place.x_mm, place.y_mm) for place in places])


def moved(random: np.random.Generator) -> StoreProfile:
    x, y = random.uniform(-30, 30, 2)
    return StoreProfile(corner_mm=(-250.0 + x, 700.0 + y), angle_deg=random.uniform(-4, 4))


def codes(reading: SheetReading) -> list[str]:
    return [one.code for one in reading.findings]


def test_twelve_places_are_read_back_to_a_tenth_of_a_millimetre() -> None:
    random = np.random.default_rng(11)
    errors = []
    for seed in range(12):
        truth = moved(random)
        reading = read(truth, seed=seed)
        assert reading.place is not None, f"seed {seed}"
        off = np.linalg.norm(reading.place.to_robot(PLAN_MM) - true_slots(truth), axis=1)
        errors.append(off)
        assert reading.held_out_rms_mm is not None
        assert reading.held_out_rms_mm < 0.5, f"seed {seed}"
        assert codes(reading) == [], f"seed {seed}"
    rms = float(np.sqrt(np.mean(np.square(errors))))
    assert rms < 0.1
    assert float(np.max(errors)) < 0.3


@pytest.mark.parametrize("count", [1, 2, 5])
def test_the_95_percent_region_of_place_and_angle_holds_the_truth(count: int) -> None:
    random = np.random.default_rng([count, 12])
    held, cases = 0, 600
    bound = region_factor(3, 8 * count - 3)
    corners = [np.array(one.corners_mm) for one in LAYOUT.fiducials]
    for _ in range(cases):
        truth = moved(random)
        angle = math.radians(truth.angle_deg)
        turn = np.array([[math.cos(angle), math.sin(angle)], [math.sin(angle), -math.cos(angle)]])
        chosen = random.choice(len(corners), count, replace=False)
        sightings = []
        for index in chosen:
            pixels = VIEW.to_picture(corners[index] @ turn.T + truth.corner_mm, SURFACE_MM)
            sightings.append(
                Sighting(
                    index=int(index),
                    view=VIEW,
                    plan_mm=corners[index],
                    pixels=pixels + random.normal(0, 0.3, (4, 2)),
                )
            )
        place = fit_place(sightings, SURFACE_MM)
        off = np.array([*place.corner_mm, place.angle_deg]) - (*truth.corner_mm, truth.angle_deg)
        held += float(off @ np.linalg.solve(place.covariance, off)) <= bound
    assert 0.925 <= held / cases <= 0.972, f"seed [{count}, 12]: {held} of {cases}"


@pytest.mark.parametrize("scale", [0.97, 0.94, 1.03, 0.99])
def test_a_wrong_scale_of_the_printer_is_told_in_percent(scale: float) -> None:
    reading = read(scale=scale)
    (finding,) = reading.findings
    assert finding.code == "printed-scale"
    assert f"{100 * scale:.1f} %" in finding.text
    assert reading.place is not None
    assert reading.place.scale == pytest.approx(scale, abs=0.001)
    assert not reading.is_good


def test_a_measured_ruler_sets_the_scale() -> None:
    reading = read(scale=0.97, ruler_mm=97.0)
    assert codes(reading) == ["printed-scale"]
    assert reading.place is not None
    assert reading.place.scale == 0.97
    assert reading.held_out_rms_mm is not None
    assert reading.held_out_rms_mm < 0.5


def test_a_ruler_in_centimetres_is_refused() -> None:
    with pytest.raises(SheetError, match="millimetres"):
        read(ruler_mm=9.7)


def test_a_mirrored_print_is_named() -> None:
    reading = read(mirrored=True)
    assert codes(reading) == ["mirrored"]
    assert reading.place is None


def test_a_print_of_another_plan_is_named() -> None:
    other = lay_out((replace(MASH_SLOTS[0], colour="red"), *MASH_SLOTS[1:]), PROFILE.blocks)
    reading = read_sheet(
        [Look(pixels=picture_of_sheet(other, STORE, VIEW, seed=1), view=VIEW)],
        LAYOUT,
        surface_mm=SURFACE_MM,
    )
    assert codes(reading)[0] == "other-print"
    assert not reading.is_good


def test_a_sheet_the_wrong_way_round_is_named() -> None:
    turned = StoreProfile(corner_mm=(297.0, 332.0), angle_deg=180.0)
    reading = read(turned, expected=STORE)
    assert codes(reading) == ["wrong-way"]
    assert "180 deg" in reading.findings[0].text


def test_a_sheet_that_was_pushed_is_told_with_how_far() -> None:
    pushed = StoreProfile(corner_mm=(-244.0, 700.0))
    reading = read(pushed, expected=STORE)
    assert codes(reading) == ["moved"]
    assert "6.0 mm" in reading.findings[0].text or "6.1 mm" in reading.findings[0].text
    assert codes(read(STORE, expected=STORE)) == []


def test_nothing_in_view_is_told_and_gives_no_place() -> None:
    blank = np.full((960, 1280, 3), 130, np.uint8)
    reading = read_sheet([Look(pixels=blank, view=VIEW)], LAYOUT, surface_mm=SURFACE_MM)
    assert codes(reading) == ["not-found"]
    assert reading.place is None
    assert not reading.is_good


def test_covered_markers_are_counted_and_the_others_suffice() -> None:
    pixels = picture_of_sheet(LAYOUT, STORE, VIEW, seed=2).copy()
    pixels[:, 640:] = 90
    reading = read_sheet([Look(pixels=pixels, view=VIEW)], LAYOUT, surface_mm=SURFACE_MM)
    assert 4 <= len(reading.seen) < 12
    assert reading.place is not None
    off = np.linalg.norm(reading.place.to_robot(PLAN_MM) - true_slots(STORE), axis=1)
    assert off.max() < 0.5


def test_one_marker_gives_a_place_and_says_what_it_cannot_tell() -> None:
    whole = picture_of_sheet(LAYOUT, STORE, VIEW, seed=3)
    only = LAYOUT.fiducials[5]
    corner = np.array([[-250.0, 700.0]]) + np.array(only.corners_mm) * (1.0, -1.0)
    place = VIEW.to_picture(corner, SURFACE_MM)
    u0, v0 = (place.min(axis=0) - 14).astype(int)
    u1, v1 = (place.max(axis=0) + 14).astype(int)
    pixels = np.full_like(whole, 130)
    pixels[v0:v1, u0:u1] = whole[v0:v1, u0:u1]
    reading = read_sheet([Look(pixels=pixels, view=VIEW)], LAYOUT, surface_mm=SURFACE_MM)
    assert reading.seen == (5,)
    assert codes(reading) == ["one-marker", "covered"]
    assert reading.held_out_rms_mm is None


def test_pages_joined_askew_are_told() -> None:
    pixels = picture_of_sheet(LAYOUT, STORE, VIEW, seed=4)
    shifted = picture_of_sheet(LAYOUT, StoreProfile(corner_mm=(-250.0, 694.0)), VIEW, seed=5)
    torn = np.concatenate([pixels[:, :400], shifted[:, 400:]], axis=1)
    reading = read_sheet([Look(pixels=torn, view=VIEW)], LAYOUT, surface_mm=SURFACE_MM)
    assert "uneven" in codes(reading) or "printed-scale" in codes(reading)
    assert not reading.is_good


def test_without_a_view_the_print_is_known_and_its_place_is_not() -> None:
    pixels = picture_of_sheet(LAYOUT, STORE, VIEW, seed=6)
    reading = read_sheet([Look(pixels=pixels, view=None)], LAYOUT, surface_mm=SURFACE_MM)
    assert len(reading.seen) == 12
    assert reading.place is None
    assert codes(reading) == ["no-view"]
    assert reading.is_good


def test_a_plane_map_at_another_height_is_refused() -> None:
    plane = PlaneView(PlaneMap(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))), 71.5)
    pixels = picture_of_sheet(LAYOUT, STORE, VIEW, seed=6)
    with pytest.raises(SheetError, match=r"71\.5"):
        read_sheet([Look(pixels=pixels, view=plane)], LAYOUT, surface_mm=SURFACE_MM)


def test_every_slot_of_an_empty_sheet_is_empty_or_not_in_view() -> None:
    reading = read()
    assert {one.state for one in reading.slots} <= {"empty", "not in view"}
    assert sum(one.state == "empty" for one in reading.slots) >= 16
    assert LENS.width_px == 1280
