from __future__ import annotations

import numpy as np
import pytest

from calibration.errors import FitFailed
from calibration.eye_in_hand.samples import Stages
from calibration.eye_in_hand.two_stage import two_stage
from calibration.statistics import mahalanobis_squared, region_factor
from tests.calibration.eye_in_hand.bench import NOMINAL, TRUTH, Bench


def test_a_measurement_without_noise_is_exact() -> None:
    found = two_stage(Bench(1).stages(3, mm=0.0), TRUTH)
    assert found.d_t_c_mm == pytest.approx(TRUTH.d_t_c_mm, abs=1e-9)
    assert found.b_angle_deg == pytest.approx(TRUTH.b_angle_deg, abs=1e-9)
    assert found.spread_mm == pytest.approx(0.0, abs=1e-9)


def test_the_printed_sign_of_delta_would_miss_the_source_s_own_angle() -> None:
    """Appendix A with the window's joints and the printed b_angl 137.7 deg."""
    seen = np.array([45.0, 105.0])
    offset = NOMINAL.places(np.array([3.0, 457.0]), seen, height_mm=0.0) - NOMINAL.gripper(seen)
    dx, dy = -offset  # A.1, A.2: first less second place
    delta = np.degrees(np.arctan(dx / dy))
    assert 180 - (150 - 90) - delta == pytest.approx(137.7)
    assert 180 - (150 - 90) + delta == pytest.approx(102.3)


def test_three_repetitions_find_half_a_millimetre_and_half_a_degree() -> None:
    misses = []
    for seed in range(200):
        found = two_stage(Bench(seed).stages(3), TRUTH)
        misses.append((found.d_t_c_mm - TRUTH.d_t_c_mm, found.b_angle_deg - TRUTH.b_angle_deg))
    assert (np.abs(misses) < 0.5).mean() > 0.99


def test_the_region_of_the_mean_holds_the_truth_as_often_as_it_says() -> None:
    held = 0
    for seed in range(2000):
        found = two_stage(Bench(seed).stages(3), TRUTH)
        off = np.array([found.d_t_c_mm - TRUTH.d_t_c_mm, found.b_angle_deg - TRUTH.b_angle_deg])
        held += mahalanobis_squared(off, found.covariance) <= region_factor(2, found.freedom)
    assert 0.93 <= held / 2000 <= 0.97, held


def test_a_single_pair_has_no_spread() -> None:
    found = two_stage(Bench(3).stages(1), TRUTH)
    assert np.isnan(found.spread_mm)
    assert found.freedom == 0


def test_both_stages_at_the_same_place_are_refused() -> None:
    pair = Stages(label="pair 1", seen_deg=(45.0, 105.0), over_deg=(45.0, 105.0))
    with pytest.raises(FitFailed, match="same place in both stages"):
        two_stage([pair], NOMINAL)


def test_no_pair_is_refused() -> None:
    with pytest.raises(FitFailed, match="two or three"):
        two_stage([], NOMINAL)
