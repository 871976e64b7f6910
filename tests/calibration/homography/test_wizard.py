from __future__ import annotations

import numpy as np

from calibration.applying import calibrated_profile
from calibration.homography.procedure import calibrate_homography
from calibration.record import Measurement, make_record
from cell.profile import Profile, load_profile
from tests.calibration.hidden_truth import (
    block_top_mm,
    hidden,
    playground_grid,
    true_view,
    with_true_lens,
)
from tests.calibration.moment import MOMENT
from tests.calibration.playing import codes, played, rms, site_of, twin_of

TOP = 71.5


def errors_mm(profile: Profile, found: Measurement, truth: Profile) -> np.ndarray:
    record = make_record(found, cell=profile.name, measured_at=MOMENT, versions={}, answers={})
    calibrated = calibrated_profile(profile, [record])
    view = calibrated.cameras["top"].view(TOP)
    assert view is not None
    grid = playground_grid()
    return np.asarray(view.to_robot(true_view(truth).to_picture(grid, TOP), TOP) - grid)


def test_four_points_and_the_lens_map_the_playground_of_hidden_cells() -> None:
    nominal = load_profile("mash")
    assert block_top_mm(nominal) == TOP
    all_off = []
    for seed in (3, 11, 12):
        truth = hidden(nominal, seed)
        profile = with_true_lens(nominal, truth)
        with twin_of(profile, truth, seed) as cell:
            found = played(calibrate_homography(site_of(profile)), {}, cell)
            home = cell.ledger.blocks_out()
        # Two fresh points with 0.3 mm of scatter each may miss the usual quality of 1 mm.
        assert set(codes(found)) <= {"quality-not-met"}, (seed, found.findings)
        assert home == {}
        all_off.append(errors_mm(profile, found, truth))
        assert found.accuracy.held_out_count == 2
        assert found.accuracy.held_out_rms is not None
        assert found.accuracy.held_out_rms < 1.5, seed
        assert set(found.values) == {
            "cameras.top.place", "cameras.top.plane_map", "cameras.top.plane_map_guid",
            "cameras.top.plane_map_date",
        }  # fmt: skip
    off = np.concatenate(all_off)
    assert rms(off) < 0.7
    assert float(np.hypot(*off.T).max()) < 2.0


def test_without_a_lens_a_homography_is_fitted_and_what_it_does_not_know_is_said() -> None:
    profile = load_profile("mash")
    truth = hidden(profile, 5)
    with twin_of(profile, truth, 5) as cell:
        found = played(calibrate_homography(site_of(profile)), {"fresh": 0.0}, cell)
    assert [p.name for p in found.parameters][:2] == ["h11", "h12"]
    assert any("lens bends" in text for text in found.not_known)
    assert found.accuracy.held_out_rms is None
    assert rms(errors_mm(profile, found, truth)) < 3.0


def test_more_points_are_taken_where_the_map_is_known_least() -> None:
    nominal = load_profile("mash")
    truth = hidden(nominal, 7)
    profile = with_true_lens(nominal, truth)
    with twin_of(profile, truth, 7) as cell:
        found = played(
            calibrate_homography(site_of(profile)),
            {"points": 6.0, "fresh": 0.0, "quality": 0.4},
            cell,
        )
    assert len(found.samples) == 6
    assert found.accuracy.how == "leave-one-out"
    assert found.accuracy.held_out_count == 6


def test_clicked_marks_give_a_map_without_any_device() -> None:
    profile = load_profile("mash")
    truth = hidden(profile, 2)
    view = true_view(truth)
    corners = [(700.0, -350.0), (700.0, 300.0), (300.0, 300.0), (300.0, -350.0)]
    answers: dict[str, float | str | tuple[float, float]] = {
        "way": "clicked", "pixel_noise": 0.3, "placement_noise": 0.3,
    }  # fmt: skip
    for number, corner in enumerate(corners, start=1):
        u, v = view.to_picture(np.array([corner]), TOP)[0]
        answers[f"point {number}"] = corner
        answers[f"pixel {number}"] = (float(u), float(v))
    with twin_of(profile, truth) as cell:
        found = played(calibrate_homography(site_of(profile)), answers, cell)
    assert codes(found) == []
    assert rms(errors_mm(profile, found, truth)) < 3.0


REFERENCE = (
    ((700.0, -350.0), (46.8, 821.5)),
    ((700.0, 300.0), (1175.8, 815.1)),
    ((300.0, 300.0), (1166.8, 123.0)),
    ((300.0, -350.0), (44.3, 132.9)),
)


def of_reference(third: tuple[float, float], *, with_map: bool) -> Measurement:
    """Calibrate with the pairs of the reference, the third as given."""
    profile = load_profile("mash")
    if not with_map:
        top = profile.cameras["top"].model_copy(update={"plane_map": None, "plane_map_guid": ""})
        profile = profile.model_copy(update={"cameras": {**profile.cameras, "top": top}})
    answers: dict[str, float | str | tuple[float, float]] = {
        "camera": "top", "way": "clicked", "quality": 5.0,
    }  # fmt: skip
    for number, (point, pixel) in enumerate(REFERENCE, start=1):
        answers[f"point {number}"] = third if number == 3 else point
        answers[f"pixel {number}"] = pixel
    with twin_of(profile) as cell:
        return played(calibrate_homography(site_of(profile)), answers, cell)


def test_the_references_pairs_give_its_matrix_in_the_profile() -> None:
    found = of_reference((300.0, 300.0), with_map=False)
    assert found.grade.value == "OK", found.findings
    matrix = np.array(found.values["cameras.top.plane_map"])
    printed = np.array([[0.00656, 0.58748, 222.028], [0.58116, -0.00504, -375.536], [0, 1e-5, 1]])
    half_digit = np.array([[5e-6, 5e-6, 5e-4], [5e-6, 5e-6, 5e-4], [5e-6, 5e-6, 0.0]])
    assert (np.abs(matrix - printed) <= np.maximum(5e-4 * np.abs(printed), half_digit)).all()


def test_the_misprinted_pair_is_bad_and_named_with_and_without_a_map_before() -> None:
    for with_map in (False, True):
        found = of_reference((300.0, -300.0), with_map=with_map)
        assert found.grade.value == "BAD"
        assert found.findings[0].samples == ("pair 3",)
        assert found.values == {}


def test_without_a_screen_the_object_is_told_from_the_empty_table() -> None:
    nominal = load_profile("mash")
    truth = hidden(nominal, 6)
    profile = with_true_lens(nominal, truth)
    off = profile.display.model_copy(update={"enabled": False})
    profile = profile.model_copy(update={"display": off})
    with twin_of(profile, truth, 6) as cell:
        found = played(calibrate_homography(site_of(profile)), {}, cell)
    assert codes(found) == []
    assert rms(errors_mm(profile, found, truth)) < 1.1
