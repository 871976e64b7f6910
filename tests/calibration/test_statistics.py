from __future__ import annotations

import numpy as np
import pytest

from calibration.statistics import (
    chi_square_quantile,
    correlation_matrix,
    f_quantile,
    mahalanobis_squared,
    region_factor,
    strong_correlations,
    t_quantile,
)


@pytest.mark.parametrize(
    ("freedom", "value"),
    [(1, 3.841459), (2, 5.991465), (8, 15.507313), (30, 43.772972), (100, 124.342113)],
)
def test_chi_square_agrees_with_the_printed_tables(freedom: int, value: float) -> None:
    assert chi_square_quantile(0.95, freedom) == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize(
    ("first", "second", "value"),
    [(1, 1, 161.447639), (2, 10, 4.102821), (5, 20, 2.710890), (10, 5, 4.735063)],
)
def test_fishers_f_agrees_with_the_printed_tables(first: int, second: int, value: float) -> None:
    assert f_quantile(0.95, first, second) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(("freedom", "value"), [(1, 12.706205), (10, 2.228139), (120, 1.979930)])
def test_students_t_agrees_with_the_printed_tables(freedom: int, value: float) -> None:
    assert t_quantile(0.95, freedom) == pytest.approx(value, rel=1e-6)


def test_a_region_of_estimated_noise_is_larger_than_one_of_known_noise() -> None:
    assert region_factor(2, 5) > region_factor(2, 50) > region_factor(2, None)
    assert region_factor(2, 100_000) == pytest.approx(region_factor(2, None), rel=1e-4)


@pytest.mark.parametrize("probability", [0.0, 1.0, -0.5])
def test_an_impossible_probability_is_refused(probability: float) -> None:
    with pytest.raises(ValueError, match="no quantile"):
        chi_square_quantile(probability, 2)


def test_strong_correlations_are_named_and_weak_ones_are_not() -> None:
    covariance = np.array([[1.0, 1.9, 0.1], [1.9, 4.0, 0.2], [0.1, 0.2, 9.0]])
    ((first, second, value),) = strong_correlations(covariance, ("a", "b", "c"))
    assert (first, second) == ("a", "b")
    assert value == pytest.approx(0.95)


def test_a_parameter_without_variance_has_no_correlation() -> None:
    assert correlation_matrix(np.diag([1.0, 0.0]))[0, 1] == 0.0


def test_the_mahalanobis_distance_counts_standard_deviations() -> None:
    assert mahalanobis_squared(np.array([2.0, 3.0]), np.diag([4.0, 9.0])) == pytest.approx(2.0)
