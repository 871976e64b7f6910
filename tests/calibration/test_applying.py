"""Calibrations become values of the profile, demands are held against them, two are compared."""

from __future__ import annotations

from datetime import timedelta

import pytest
from pydantic import JsonValue

from calibration.applying import Misfit, calibrate_where_it_fits, calibrated_profile
from calibration.archive import Slot
from calibration.demands import (
    require_quality,
    shortcoming,
    unmet_by_kind,
    unmet_for_camera,
    unmet_for_lattice,
)
from calibration.diffing import difference
from calibration.errors import QualityNotMet
from cell.profile import load_cell_profile, load_profile
from tests.calibration.records import MAP, WHEN, a_record

PROFILE = load_profile("mash")
GUID = PROFILE.cameras["top"].guid
ORIGIN: dict[str, JsonValue] = {"lattice.origin_mm": [700.0, -260.0]}


def moved_map(by_mm: float) -> JsonValue:
    assert isinstance(MAP, list)
    first = MAP[0]
    assert isinstance(first, list)
    assert isinstance(first[2], float)
    return [[first[0], first[1], first[2] + by_mm], MAP[1], MAP[2]]


def test_a_profile_without_calibrations_is_the_same_object() -> None:
    assert calibrated_profile(PROFILE, []) is PROFILE


def test_a_value_takes_the_place_of_the_profile_s_and_nothing_else_changes() -> None:
    known = calibrated_profile(PROFILE, [a_record(values=ORIGIN)])
    assert known.lattice.origin_mm == (700.0, -260.0)
    assert known.model_copy(update={"lattice": PROFILE.lattice}) == PROFILE


def test_of_two_that_set_the_same_the_later_one_counts_whatever_their_order() -> None:
    old = a_record(values={"lattice.origin_mm": [1.0, 2.0]})
    new = a_record(values=ORIGIN, measured_at=WHEN + timedelta(days=1))
    for records in ([old, new], [new, old]):
        assert calibrated_profile(PROFILE, records).lattice.origin_mm == (700.0, -260.0)


def test_every_cell_s_profile_can_be_calibrated() -> None:
    lynx = load_cell_profile("lynx")
    record = a_record(cell=lynx.name, values={"server.port": 1234})
    assert calibrated_profile(lynx, [record]).server.port == 1234


@pytest.mark.parametrize(
    ("record", "told"),
    [
        (a_record(cell="other"), "made for the cell other, not for mash"),
        (
            a_record(cameras={"top": "00AA"}),
            f"measured with the camera 00AA, but top is now {GUID}",
        ),
        (a_record(cameras={"side": "00AA"}), "no camera side any more"),
        (a_record(values={"cameras.side.plane_map": MAP}), "sets cameras.side.plane_map"),
        (a_record(values={"lattice.slant_deg": 3}), "sets lattice.slant_deg"),
        (a_record(values={"lattice": 3}), "lattice"),
        (a_record(values={"lattice.step_mm": -1}), "lattice.step_mm"),
        (a_record(values={"": 1}), "sets ,"),
    ],
)
def test_what_does_not_fit_is_named_and_left_out(record: object, told: str) -> None:
    from calibration.record import CalibrationRecord

    assert isinstance(record, CalibrationRecord)
    with pytest.raises(Misfit) as error:
        calibrated_profile(PROFILE, [record])
    assert told in str(error.value)
    assert record.identity[:8] in str(error.value)
    assert "cell calibration undo homography top" in str(error.value)
    sound = a_record(kind="lattice", subject="cell", values=ORIGIN)
    found = calibrate_where_it_fits(PROFILE, [record, sound])
    assert found.records == (sound,)
    assert [misfit.record for misfit in found.misfits] == [record]
    assert found.profile.lattice.origin_mm == (700.0, -260.0)


@pytest.mark.parametrize(
    ("held_out_mm", "unit", "limit_mm", "told"),
    [
        (0.7, "mm", 0.7, None),
        (3.14, "mm", 2.0, "the homography of top has 3.14 mm (held out), measured on 2026-11-10"),
        (0.1, "px", 2.0, "in px, not in mm"),
        (None, "mm", 2.0, "does not know its accuracy"),
    ],
)
def test_a_demand_is_met_by_a_figure_in_mm_only(
    held_out_mm: float | None, unit: str, limit_mm: float, told: str | None
) -> None:
    found = shortcoming(a_record(held_out_mm=held_out_mm, unit=unit), limit_mm)
    assert found is None if told is None else found is not None and told in found


def test_a_cell_s_demands_are_held_against_every_subject_of_a_kind() -> None:
    top, oblique = a_record(), a_record(subject="oblique", held_out_mm=4.0)
    assert unmet_by_kind({"homography": 1.0}, [top]) == []
    (told,) = unmet_by_kind({"homography": 1.0}, [top, oblique])
    assert "homography of oblique has 4 mm" in told
    (told,) = unmet_by_kind({"world": 1.0}, [top, oblique])
    assert told == (
        "1 mm are demanded, but no world is known: none is kept; calibrate it: "
        "`cell calibrate world`"
    )
    assert unmet_by_kind({}, []) == []


def test_what_is_known_of_a_camera_is_what_was_measured_last() -> None:
    rough = a_record(held_out_mm=3.0)
    fine = a_record(kind="screen", held_out_mm=0.4, measured_at=WHEN + timedelta(hours=1))
    assert unmet_for_camera("top", 1.0, PROFILE, [rough, fine]) is None
    told = unmet_for_camera("top", 1.0, PROFILE, [rough])
    assert told is not None
    assert "3 mm (held out)" in told
    told = unmet_for_camera("top", 1.0, PROFILE, [])
    assert told is not None
    assert "is not known: no calibration is kept" in told


def test_a_camera_that_moves_is_not_asked_where_it_looks() -> None:
    assert PROFILE.cameras["gripper"].plane_map is None
    assert unmet_for_camera("gripper", 0.1, PROFILE, []) is None


def test_the_lattice_is_known_by_what_sets_it() -> None:
    assert unmet_for_lattice(1.0, [a_record(values=ORIGIN)]) is None
    told = unmet_for_lattice(1.0, [a_record()])
    assert told is not None
    assert "where the lattice lies is not known" in told


def test_a_procedure_gets_a_refusal_with_the_figure() -> None:
    slot = Slot("homography", "top")
    require_quality([a_record()], slot, 1.0)
    with pytest.raises(QualityNotMet, match=r"0\.5 mm are demanded, but .* has 0\.7 mm"):
        require_quality([a_record()], slot, 0.5)
    with pytest.raises(QualityNotMet, match="no homography of top is kept"):
        require_quality([], slot, 0.5)


def test_two_maps_are_compared_in_mm_at_the_playground_s_corners() -> None:
    first = a_record()
    second = a_record(values={"cameras.top.plane_map": moved_map(2.0)})
    found = difference(first, second, PROFILE)
    assert list(found.values) == ["cameras.top.plane_map"]
    corners = found.corners["top"]
    assert {c.corner_mm for c in corners} == {(300, -350), (700, -350), (300, 300), (700, 300)}
    for corner in corners:
        assert corner.distance_mm == pytest.approx(2.0, abs=0.02)


def test_a_calibration_does_not_differ_from_itself() -> None:
    found = difference(a_record(), a_record(), PROFILE)
    assert found.values == {}
    assert all(c.distance_mm < 1e-9 for corners in found.corners.values() for c in corners)


def test_maps_are_compared_only_where_both_have_one() -> None:
    assert difference(a_record(), a_record(values=ORIGIN), PROFILE).corners == {}
    assert difference(a_record(), a_record(), None).corners == {}
