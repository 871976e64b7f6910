"""Regions that hold the truth with a stated probability, and how parameters hang together.

Quantiles of chi square, Fisher's F and Student's t come from the incomplete beta and gamma
functions, inverted by bisection (Press et al., Numerical Recipes, 6.2 and 6.4).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

_TERMS = 500
_TINY = 1e-300


@lru_cache(maxsize=256)
def chi_square_quantile(probability: float, freedom: int) -> float:
    """Return what chi square with `freedom` degrees stays below with a probability."""
    _check(probability, freedom)
    return _inverted(lambda x: _gamma_below(0.5 * freedom, 0.5 * x), probability)


@lru_cache(maxsize=256)
def f_quantile(probability: float, first: int, second: int) -> float:
    """Return what Fisher's F of `first` and `second` degrees stays below."""
    _check(probability, first)
    _check(probability, second)

    def below(x: float) -> float:
        return _beta_below(0.5 * first, 0.5 * second, first * x / (first * x + second))

    return _inverted(below, probability)


def t_quantile(probability: float, freedom: int) -> float:
    """Return what the absolute value of Student's t stays below with a probability."""
    return math.sqrt(f_quantile(probability, 1, freedom))


def region_factor(dimensions: int, freedom: int | None, probability: float = 0.95) -> float:
    """Return the squared Mahalanobis distance that bounds a region of a probability.

    Args:
        dimensions: How many parameters the region spans together.
        freedom: Degrees of freedom of the noise that was estimated from residuals (then
            dimensions · F); None where the noise is known (then chi square).
        probability: Share of such regions that hold the truth.
    """
    if freedom is None:
        return chi_square_quantile(probability, dimensions)
    return dimensions * f_quantile(probability, dimensions, freedom)


def mahalanobis_squared(offset: NDArray[np.float64], covariance: Matrix) -> float:
    """Return offsetᵀ · covariance⁻¹ · offset."""
    return float(offset @ np.linalg.solve(covariance, offset))


def correlation_matrix(covariance: Matrix) -> Matrix:
    """Return the correlations of a covariance; 0 with a parameter of no variance."""
    spread = np.sqrt(np.diag(covariance))
    product = np.outer(spread, spread)
    ratio: Matrix = np.divide(covariance, product, out=np.zeros_like(covariance), where=product > 0)
    return ratio


def strong_correlations(
    covariance: Matrix, names: Sequence[str], least: float = 0.8
) -> tuple[tuple[str, str, float], ...]:
    """Return the pairs of parameters that the samples hardly tell apart, strongest first."""
    correlations = correlation_matrix(covariance)
    found = [
        (names[i], names[j], float(correlations[i, j]))
        for i in range(len(names))
        for j in range(i + 1, len(names))
        if abs(correlations[i, j]) > least
    ]
    return tuple(sorted(found, key=lambda pair: -abs(pair[2])))


def _check(probability: float, freedom: int) -> None:
    if not 0.0 < probability < 1.0 or freedom < 1:
        raise ValueError(f"no quantile of probability {probability} with {freedom} degrees")


def _inverted(below: Callable[[float], float], probability: float) -> float:
    low, high = 0.0, 1.0
    while below(high) < probability:
        low, high = high, 2.0 * high
    for _ in range(200):
        middle = 0.5 * (low + high)
        if below(middle) < probability:
            low = middle
        else:
            high = middle
        if high - low <= 1e-13 * high:
            break
    return 0.5 * (low + high)


def _gamma_below(a: float, x: float) -> float:
    """Return the regularised incomplete gamma function P(a, x)."""
    if x <= 0.0:
        return 0.0
    front = math.exp(-x + a * math.log(x) - math.lgamma(a))
    if x < a + 1.0:
        term = total = 1.0 / a
        for n in range(1, _TERMS):
            term *= x / (a + n)
            total += term
            if term < total * 1e-16:
                break
        return total * front
    b = x + 1.0 - a
    c, d = 1.0 / _TINY, 1.0 / b
    fraction = d
    for n in range(1, _TERMS):
        an = -n * (n - a)
        b += 2.0
        d = 1.0 / (an * d + b or _TINY)
        c = b + an / c or _TINY
        fraction *= c * d
        if abs(c * d - 1.0) < 1e-16:
            break
    return 1.0 - front * fraction


def _beta_below(a: float, b: float, x: float) -> float:
    """Return the regularised incomplete beta function I_x(a, b)."""
    if x <= 0.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    front = math.exp(
        math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
        + a * math.log(x) + b * math.log1p(-x)
    )  # fmt: skip
    if x < (a + 1.0) / (a + b + 2.0):
        return front * _beta_fraction(a, b, x) / a
    return 1.0 - front * _beta_fraction(b, a, 1.0 - x) / b


def _beta_fraction(a: float, b: float, x: float) -> float:
    """Return the continued fraction of the incomplete beta function (Lentz's method)."""
    c, d = 1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0) or _TINY)
    fraction = d
    for m in range(1, _TERMS):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        for step in (even, odd):
            d = 1.0 / (1.0 + step * d or _TINY)
            c = 1.0 + step / c or _TINY
            fraction *= c * d
        if abs(c * d - 1.0) < 1e-16:
            break
    return fraction
