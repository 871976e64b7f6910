from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.errors import FitFailed
from calibration.eye_in_hand.guidance import Reach, next_look, predicted_miss
from calibration.eye_in_hand.judge import cleaned_fit, held_out_mm, miss_mm
from calibration.eye_in_hand.refine import parameters_of, refine
from calibration.eye_in_hand.samples import Noise, Samples
from tests.calibration.eye_in_hand.bench import NOMINAL, POINT, TRUTH, Bench


def test_samples_without_noise_give_the_truth() -> None:
    bench = Bench(1)
    looks = tuple(bench.look(f"look {i}", j, px=0.0) for i, j in enumerate(bench.joints(8)))
    found = refine(Samples(looks=looks, touches=(bench.touch("t", mm=0.0),)), NOMINAL)
    assert np.abs(found.parameters - parameters_of(TRUTH)).max() < 1e-6
    assert found.point_mm == pytest.approx(POINT, abs=1e-6)


def test_regions_hold_the_truth_in_93_to_97_of_100_calibrations() -> None:
    runs, held, misses = 1000, 0, []
    for seed in range(runs):
        found = refine(_again(seed), NOMINAL)
        held += found.holds(TRUTH)
        misses.append(np.abs(found.parameters - parameters_of(TRUTH)) / np.sqrt(
            np.diag(found.covariance)
        ))  # fmt: skip
    assert 0.93 <= held / runs <= 0.97, f"{held} of {runs} (seeds 0 to {runs - 1})"
    within = (np.array(misses) < 2.0).mean(axis=0)
    assert ((within > 0.92) & (within < 0.98)).all(), within


_JOINTS = Bench(0).joints(12)


def _again(seed: int) -> Samples:
    bench = Bench(seed)
    looks = tuple(bench.look(f"look {i}", joints) for i, joints in enumerate(_JOINTS))
    return Samples(looks=looks, touches=(bench.touch("touch 1"), bench.touch("touch 2")))


def test_noise_that_is_larger_than_stated_widens_the_regions() -> None:
    held, runs = 0, 300
    for seed in range(runs):
        bench = Bench(seed)
        looks = tuple(bench.look(f"look {i}", joints, px=1.2) for i, joints in enumerate(_JOINTS))
        touches = (bench.touch("touch 1", mm=0.6), bench.touch("touch 2", mm=0.6))
        found = refine(Samples(looks=looks, touches=touches), NOMINAL)
        held += found.holds(TRUTH)
    assert 0.92 <= held / runs <= 0.98, held
    assert 2.0 < found.noise_factor < 4.5


def test_looks_alone_cannot_part_link_2_from_the_camera_s_offset() -> None:
    samples = replace(Bench(2).samples(), touches=())
    found = refine(samples, NOMINAL)
    assert found.held == ("link_2",)
    assert found.eye.link_2_mm == NOMINAL.link_2_mm
    with pytest.raises(FitFailed):
        refine(samples, NOMINAL, may_hold=False)


def test_an_edge_of_unknown_direction_says_nothing_of_angle_error_one_of_known_does() -> None:
    bench = Bench(4)
    looks = bench.samples()
    unknown = tuple(bench.edge(f"e{i}", j, 30.0, known=False) for i, j in enumerate(_JOINTS))
    known = tuple(bench.edge(f"e{i}", j, 30.0, known=True) for i, j in enumerate(_JOINTS))
    plain = refine(looks, NOMINAL).information
    with_unknown = refine(replace(looks, lines=unknown), NOMINAL)
    with_known = refine(replace(looks, lines=known), NOMINAL)
    inverse = np.linalg.inv(plain)[2, 2]
    assert np.linalg.inv(with_unknown.information)[2, 2] == pytest.approx(inverse, rel=1e-2)
    assert np.linalg.inv(with_known.information)[2, 2] < 0.95 * inverse


def test_looks_from_one_place_are_refused_with_what_to_do() -> None:
    bench = Bench(5)
    joints = bench.joints(1)[0]
    looks = tuple(bench.look(f"look {i}", joints) for i in range(8))
    with pytest.raises(FitFailed, match="turn joint 1 and joint 2"):
        refine(Samples(looks=looks), NOMINAL)


def test_looks_from_one_place_and_a_touch_tell_no_more_than_the_two_stages() -> None:
    bench = Bench(5)
    joints = bench.joints(1)[0]
    looks = tuple(bench.look(f"look {i}", joints) for i in range(8))
    found = refine(Samples(looks=looks, touches=(bench.touch("t"),)), NOMINAL)
    assert found.held == ("angle_error", "link_1", "link_2")


def test_two_looks_are_too_few() -> None:
    samples = Bench(6).samples(looks=2)
    with pytest.raises(FitFailed, match="2 looks"):
        refine(samples, NOMINAL)


def test_held_out_distances_are_those_of_fits_without_each_look() -> None:
    samples = Bench(7).samples()
    found = refine(samples, NOMINAL)
    by_leverage = held_out_mm(found, len(samples.looks))
    for index, look in enumerate(samples.looks):
        rest = replace(samples, looks=samples.looks[:index] + samples.looks[index + 1 :])
        without = refine(rest, NOMINAL)
        place = without.eye.places(
            np.array([look.u_px, look.v_px]), np.array([look.j1_deg, look.j2_deg]), height_mm=0.0
        )
        distance = np.hypot(*(place - np.array(without.point_mm)))
        assert by_leverage[index] == pytest.approx(distance, abs=0.01)


def test_a_look_that_does_not_belong_is_named_with_its_distance() -> None:
    for seed in range(20):
        samples = Bench(seed).samples()
        looks = list(samples.looks)
        looks[seed % 12] = replace(looks[seed % 12], u_px=looks[seed % 12].u_px + 20.0)
        cleaned = cleaned_fit(replace(samples, looks=tuple(looks)), NOMINAL)
        ((look, distance),) = cleaned.outliers
        assert look.label == samples.looks[seed % 12].label, seed
        assert distance == pytest.approx(20 / 3.56, abs=1.5), seed


def test_good_looks_are_hardly_ever_left_out() -> None:
    dropped = sum(bool(cleaned_fit(_again(seed), NOMINAL).outliers) for seed in range(300))
    assert dropped <= 10, f"{dropped} of 300"


def test_the_refined_eye_grips_better_than_what_was_known_before() -> None:
    before, after = [], []
    for seed in range(60):
        bench = Bench(seed)
        found = refine(bench.samples(), NOMINAL)
        for fresh in bench.fresh(3):
            before.append(miss_mm(NOMINAL, fresh))
            after.append(miss_mm(found.eye, fresh))
    assert np.sqrt(np.mean(np.square(after))) < 0.6
    assert np.sqrt(np.mean(np.square(before))) > 1.5


def test_the_predicted_miss_is_what_fresh_points_show() -> None:
    misses, predicted = [], []
    for seed in range(100):
        bench = Bench(seed)
        found = refine(bench.samples(), NOMINAL)
        predicted.append(predicted_miss(found)[0])
        # What was measured of fresh points carries its own noise: compare places.
        seen = np.array([bench.joints(1)[0]])
        pixels = np.array([[250.0, 240.0]])
        away = found.eye.places(pixels, seen) - TRUTH.places(pixels, seen)
        misses.append(np.hypot(*away[0]))
    assert np.sqrt(np.mean(np.square(misses))) < 3.0 * np.mean(predicted)
    assert 0.05 < np.mean(predicted) < 0.6


def test_the_suggested_look_helps_more_than_one_taken_again() -> None:
    bench = Bench(9)
    samples = bench.samples(looks=6)
    found = refine(samples, NOMINAL)
    best = next_look(found, Reach(), Noise())
    assert best is not None
    assert best.gain > 0.0
    suggested = bench.look("look 7", np.array([best.j1_deg, best.j2_deg]))
    assert (suggested.u_px, suggested.v_px) == pytest.approx((best.u_px, best.v_px), abs=15)
    again = replace(samples.looks[0], label="look 7")

    def variance(look: object) -> float:
        more = refine(replace(samples, looks=(*samples.looks, look)), NOMINAL)  # type: ignore[arg-type]
        return float(np.trace(np.linalg.inv(more.information)[:5, :5]))

    assert variance(suggested) < variance(again)
