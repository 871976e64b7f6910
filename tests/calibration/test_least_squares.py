from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.least_squares import differences, fit
from calibration.statistics import mahalanobis_squared, region_factor

X = np.linspace(0.0, 4.0, 24)
TRUTH = np.array([2.5, 0.7, -0.4])


def curve(p: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(p[0] * np.exp(-p[1] * X) + p[2])


def test_a_curve_without_noise_is_found_exactly() -> None:
    found = fit(lambda p: curve(p) - curve(TRUTH), np.array([1.0, 1.0, 0.0]))
    assert np.abs(found.parameters - TRUTH).max() < 1e-9
    assert found.rms < 1e-10


def test_a_given_jacobian_leads_to_the_same_place() -> None:
    noise = np.random.default_rng(3).normal(0, 0.05, X.size)

    def residuals(p: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(curve(p) - curve(TRUTH) - noise)

    def slope(p: NDArray[np.float64]) -> NDArray[np.float64]:
        bend = np.exp(-p[1] * X)
        return np.stack([bend, -p[0] * X * bend, np.ones_like(X)], axis=1)

    start = np.array([1.0, 1.0, 0.0])
    assert np.abs(slope(TRUTH) - differences(residuals, TRUTH)).max() < 1e-8
    given, worked_out = fit(residuals, start, jacobian=slope), fit(residuals, start)
    assert np.abs(given.parameters - worked_out.parameters).max() < 1e-7


@pytest.mark.parametrize("is_noise_known", [True, False])
def test_regions_hold_the_truth_as_often_as_they_say(is_noise_known: bool) -> None:
    generator = np.random.default_rng(11)
    held, runs, sigma = 0, 600, 0.03
    for _ in range(runs):
        measured = curve(TRUTH) + generator.normal(0, sigma, X.size)
        unit = sigma if is_noise_known else 1.0

        def residuals(p: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.asarray((curve(p) - measured) / unit)  # noqa: B023

        found = fit(residuals, TRUTH, is_noise_known=is_noise_known)
        freedom = None if is_noise_known else found.freedom
        distance = mahalanobis_squared(found.parameters - TRUTH, found.covariance)
        held += distance <= region_factor(3, freedom)
    assert 0.93 <= held / runs <= 0.97, f"{held} of {runs} (seed 11)"


def test_too_few_values_are_refused() -> None:
    with pytest.raises(FitFailed, match="2 measured values cannot determine 3"):
        fit(lambda p: p[:2], np.ones(3))


def test_a_parameter_without_influence_is_refused() -> None:
    with pytest.raises(FitFailed, match="nothing about one"):
        fit(lambda p: np.array([p[0], 2 * p[0], p[0] - 1]), np.ones(2))


def test_parameters_that_act_alike_are_refused() -> None:
    with pytest.raises(FitFailed, match="tell the parameters apart"):
        fit(lambda p: (p[0] + p[1]) * X - 1.0, np.array([0.2, 0.1]))


def test_a_start_without_finite_residuals_is_refused() -> None:
    with pytest.raises(FitFailed, match="no finite residuals"):
        fit(lambda p: np.array([np.nan, p[0]]), np.ones(1))
