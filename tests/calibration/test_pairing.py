"""Where a camera stands was fitted with its lens: the two stay paired, whatever is replaced."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import pytest
from pydantic import JsonValue

from calibration.applying import Misfit, calibrate_where_it_fits, calibrated_profile, setters
from calibration.archive import Archive, Slot
from calibration.catalogue import Site
from calibration.demands import unmet_for_camera
from calibration.diffing import difference
from calibration.homography.knowledge import knowledge_of
from calibration.record import CalibrationRecord, Support
from cell.profile import Profile, load_profile
from tests.calibration.records import MAP, WHEN, a_record

PROFILE = load_profile("mash")
LENS, PLACE = "cameras.top.lens", "cameras.top.place"


def a_lens(focal_px: float) -> JsonValue:
    return {"focal_px": [focal_px, focal_px], "centre_px": [640.0, 480.0], "k1": -0.05,
            "k2": 0.0, "p1": 0.0, "p2": 0.0, "k3": 0.0}  # fmt: skip


def a_place(height_mm: float) -> JsonValue:
    return {"position_mm": [500.0, 0.0, height_mm], "rotation_deg": [180.0, 0.0, 90.0]}


def screen(hour: int, focal_px: float = 1000.0) -> CalibrationRecord:
    values = {LENS: a_lens(focal_px), PLACE: a_place(1400.0), "display.angle_deg": 0.25}
    return a_record(kind="screen", subject="cell", values=values, measured_at=at(hour))


def lens(hour: int, focal_px: float) -> CalibrationRecord:
    return a_record(kind="lens", unit="px", values={LENS: a_lens(focal_px)}, measured_at=at(hour))


def homography(hour: int, made_with: CalibrationRecord) -> CalibrationRecord:
    """A place that the wizard fits with the lens of another calibration."""
    values: dict[str, JsonValue] = {PLACE: a_place(1300.0), "cameras.top.plane_map": MAP}
    record = a_record(values=values, measured_at=at(hour))
    site = Site(profile=calibrated_profile(PROFILE, [made_with]), plan=None, current=(made_with,))
    return record.model_copy(update={"stands_on": knowledge_of(site, "top").stands_on})


def at(hour: int) -> datetime:
    return WHEN + timedelta(hours=hour)


def height_mm(profile: Profile) -> float | None:
    place = profile.cameras["top"].place
    return None if place is None else place.position_mm[2]


def test_a_lens_after_the_screen_takes_away_the_place_that_was_fitted_with_the_screen_s() -> None:
    first, second = screen(0), lens(1, 1100.0)
    found = calibrate_where_it_fits(PROFILE, [first, second])
    assert height_mm(found.profile) is None
    assert found.profile.cameras["top"].plane_map == PROFILE.cameras["top"].plane_map
    assert found.profile.display.angle_deg == 0.25
    assert found.records == (first, second)
    assert found.misfits == ()
    (stale,) = found.stale
    assert (stale.path, stale.record, stale.replaced_by) == (PLACE, first, second)
    assert first.identity[:8] in str(stale)
    assert "`cell calibration undo lens top`" in str(stale)
    assert calibrated_profile(PROFILE, found.records) == found.profile


def test_a_lens_that_comes_to_the_same_leaves_the_place() -> None:
    found = calibrate_where_it_fits(PROFILE, [screen(0, 1000.0), lens(1, 1000.0)])
    assert height_mm(found.profile) == 1400.0
    assert found.stale == ()


def test_the_screen_after_a_lens_brings_its_own_place() -> None:
    found = calibrate_where_it_fits(PROFILE, [lens(0, 1100.0), screen(1)])
    assert height_mm(found.profile) == 1400.0
    assert (found.stale, found.misfits) == ((), ())


def test_a_place_measured_after_the_lens_was_replaced_is_not_stale() -> None:
    middle = lens(1, 1100.0)
    found = calibrate_where_it_fits(PROFILE, [screen(0), middle, homography(2, middle)])
    assert height_mm(found.profile) == 1300.0
    assert (found.stale, found.misfits) == ((), ())


def test_a_homography_whose_lens_was_replaced_is_left_out_by_name() -> None:
    first = lens(0, 1000.0)
    placed, second = homography(1, first), lens(2, 1100.0)
    found = calibrate_where_it_fits(PROFILE, [first, placed, second])
    assert found.records == (first, second)
    assert height_mm(found.profile) is None
    (misfit,) = found.misfits
    assert misfit.record is placed
    assert f"made with the lens {first.identity[:8]} of top, which is not in force" in str(misfit)
    assert f"take {second.identity[:8]} back with `cell calibration undo lens top`" in str(misfit)
    with pytest.raises(Misfit, match="not in force any more"):
        calibrated_profile(PROFILE, [first, placed, second])


def test_a_homography_whose_lens_was_undone_is_left_out_by_name() -> None:
    first = lens(0, 1000.0)
    placed = homography(1, first)
    found = calibrate_where_it_fits(PROFILE, [placed])
    assert found.records == ()
    assert found.profile == PROFILE
    assert "`cell calibration undo homography top`" in str(found.misfits[0])


def test_a_place_fitted_with_the_lens_of_the_file_goes_with_it() -> None:
    top = calibrated_profile(PROFILE, [screen(0)]).cameras["top"]
    profile = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": top}})
    placed = a_record(values={PLACE: a_place(1300.0)}).model_copy(
        update={"stands_on": knowledge_of(Site(profile=profile, plan=None, current=()), "top")
                .stands_on}
    )  # fmt: skip
    assert placed.stands_on[0].record == ""
    assert height_mm(calibrated_profile(profile, [placed])) == 1300.0
    found = calibrate_where_it_fits(profile, [placed, lens(1, 1100.0)])
    assert "made with the lens of the cell's file of top" in str(found.misfits[0])
    # The file's own place was fitted with the file's own lens.
    assert height_mm(found.profile) is None
    assert found.stale[0].record is None
    assert "of the cell's file was fitted with another lens" in str(found.stale[0])


def test_what_a_later_calibration_sets_anew_is_no_matter() -> None:
    first = lens(0, 1000.0)
    records = [first, homography(1, first), screen(2, 1050.0)]
    found = calibrate_where_it_fits(PROFILE, records)
    assert found.records == tuple(records)
    assert (found.stale, found.misfits) == ((), ())
    assert height_mm(found.profile) == 1400.0


def test_what_stands_on_a_record_that_is_left_out_is_left_out_too() -> None:
    first = lens(0, 1000.0)
    placed = homography(1, first)
    on_place = Support(path=PLACE, value=placed.values[PLACE], record=placed.identity)
    upon = a_record(
        kind="lattice", subject="cell", values={"lattice.origin_mm": [1.0, 2.0]},
        measured_at=at(2),
    ).model_copy(update={"stands_on": (on_place,)})  # fmt: skip
    whole = calibrate_where_it_fits(PROFILE, [first, upon, placed])
    assert len(whole.records) == 3
    found = calibrate_where_it_fits(PROFILE, [upon, placed])
    assert [misfit.record for misfit in found.misfits] == [placed, upon]
    assert found.profile == PROFILE


def test_undo_of_the_lens_brings_everything_back(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    first = lens(0, 1000.0)
    placed = homography(1, first)
    for record in (screen(-1, 950.0), first, placed):
        archive.keep(record, {})
    before = calibrate_where_it_fits(PROFILE, archive.current())
    assert height_mm(before.profile) == 1300.0
    archive.keep(lens(2, 1100.0), {})
    between = calibrate_where_it_fits(PROFILE, archive.current())
    assert height_mm(between.profile) is None
    assert [misfit.record for misfit in between.misfits] == [placed]
    archive.undo(Slot("lens", "top"))
    after = calibrate_where_it_fits(PROFILE, archive.current())
    assert after.profile == before.profile
    assert (after.stale, after.misfits) == ((), ())
    # Without any lens of its own, the screen's pair counts again; the homography's does not.
    archive.undo(Slot("lens", "top"))
    last = calibrate_where_it_fits(PROFILE, archive.current())
    assert [misfit.record for misfit in last.misfits] == [placed]
    assert height_mm(last.profile) == 1400.0


def test_a_demand_is_not_met_by_a_place_that_was_taken_away() -> None:
    first, second = screen(0), lens(1, 1100.0)
    known = calibrate_where_it_fits(PROFILE, [first])
    assert unmet_for_camera("top", 1.0, known.profile, known.records) is None
    assert setters(known.records)[PLACE] is first
    found = calibrate_where_it_fits(PROFILE, [first, second])
    assert PLACE not in setters(found.records)
    bare = found.profile.cameras["top"].model_copy(update={"plane_map": None})
    for top in (found.profile.cameras["top"], bare):
        cameras = {**found.profile.cameras, "top": top}
        profile = found.profile.model_copy(update={"cameras": cameras})
        told = unmet_for_camera("top", 1.0, profile, found.records)
        assert told is not None
        assert "where camera top looks is not known" in told


def test_homographies_are_compared_each_with_the_lens_it_was_made_with() -> None:
    one = homography(1, lens(0, 1000.0))
    other = homography(3, lens(2, 1100.0))
    corners = difference(one, other, PROFILE).corners["top"]
    # 500 mm from under the camera, a tenth more focal length shrinks it by a tenth.
    assert all(10.0 < corner.distance_mm < 60.0 for corner in corners)


def test_a_record_that_stands_on_a_lens_reads_back_the_same() -> None:
    with_support = homography(1, lens(0, 1000.0))
    assert b'"stands_on"' in with_support.canonical()
    again = CalibrationRecord.model_validate_json(with_support.canonical())
    assert again.identity == with_support.identity
    assert again.stands_on == with_support.stands_on
