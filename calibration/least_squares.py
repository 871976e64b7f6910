"""Least squares by Levenberg and Marquardt, with the covariance of what was fitted.

Residuals are given divided by their standard deviation where that is known; then the
covariance is (JᵀJ)⁻¹. Where it is not known, the residuals' own spread is put in: the
covariance is s² (JᵀJ)⁻¹ with s² = Σr²/(n - p).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_RELATIVE_STEP = 1e-6
_RANK_TOLERANCE = 1e-11


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """What was fitted.

    Attributes:
        parameters: Shape (p,).
        residuals: At the solution, shape (n,), in the unit they were given in.
        jacobian: Of the residuals, shape (n, p).
        covariance: Of the parameters, shape (p, p).
        scale: What the covariance was multiplied with: 1 for residuals in standard
            deviations, else s².
        iterations: Steps taken.
    """

    parameters: Vector
    residuals: Vector
    jacobian: Matrix
    covariance: Matrix
    scale: float
    iterations: int

    @property
    def freedom(self) -> int:
        """Residuals less parameters."""
        return self.residuals.size - self.parameters.size

    @property
    def rms(self) -> float:
        """Root of the residuals' mean square."""
        return float(np.sqrt(np.mean(self.residuals**2)))


def fit(
    residuals: Callable[[Vector], Vector],
    start: Vector,
    *,
    jacobian: Callable[[Vector], Matrix] | None = None,
    is_noise_known: bool = False,
    steps: int = 100,
    tolerance: float = 1e-12,
) -> Fit:
    """Find the parameters with the least sum of squared residuals.

    Args:
        residuals: From parameters (p,) to residuals (n,), n ≥ p.
        start: Where to begin, shape (p,).
        jacobian: Of the residuals, (n, p); by central differences unless given.
        is_noise_known: Whether residuals are in standard deviations.
        steps: Most steps.
        tolerance: Relative change of the sum at which to stop.

    Raises:
        FitFailed: The residuals are not finite, fewer than the parameters, or do not depend
            on every parameter at the solution.
    """
    parameters = np.array(start, np.float64)
    slope = jacobian or (lambda p: differences(residuals, p))
    now = _finite(residuals(parameters))
    if now.size < parameters.size:
        raise FitFailed(
            f"{now.size} measured values cannot determine {parameters.size} parameters; "
            "take more samples"
        )
    total, damping, taken = float(now @ now), 1e-3, 0
    matrix = slope(parameters)
    for taken in range(1, steps + 1):  # noqa: B007
        normal, gradient = matrix.T @ matrix, matrix.T @ now
        diagonal = np.maximum(np.diag(normal), 1e-30)
        improved = False
        while damping < 1e12:
            step = np.linalg.solve(normal + np.diag(damping * diagonal), -gradient)
            after = residuals(parameters + step)
            after_total = float(after @ after)
            if np.isfinite(after_total) and after_total <= total:
                improved = True
                break
            damping *= 10.0
        if not improved:
            break
        gain = total - after_total
        parameters, now, total = parameters + step, after, after_total
        matrix = slope(parameters)
        damping = max(damping * 0.1, 1e-12)
        if gain <= tolerance * max(total, 1e-300):
            break
    return _judged(parameters, now, matrix, is_noise_known=is_noise_known, iterations=taken)


def differences(residuals: Callable[[Vector], Vector], at: Vector) -> Matrix:
    """Return the Jacobian (n, p) by central differences."""
    columns = []
    for index in range(at.size):
        step = _RELATIVE_STEP * max(abs(float(at[index])), 1.0)
        up, down = at.copy(), at.copy()
        up[index] += step
        down[index] -= step
        columns.append((residuals(up) - residuals(down)) / (2.0 * step))
    return np.stack(columns, axis=1)


def _judged(
    parameters: Vector,
    residuals: Vector,
    jacobian: Matrix,
    *,
    is_noise_known: bool,
    iterations: int,
) -> Fit:
    """Return the fit with its covariance, worked out in columns of unit length."""
    length = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    if (length == 0.0).any():
        raise FitFailed("the samples say nothing about one of the parameters; vary them more")
    _, values, right = np.linalg.svd(jacobian / length, full_matrices=False)
    if values[-1] < _RANK_TOLERANCE * values[0]:
        raise FitFailed("the samples do not tell the parameters apart; vary them more")
    inverse = (right.T / values**2) @ right
    freedom = residuals.size - parameters.size
    scale = 1.0
    if not is_noise_known:
        scale = float(residuals @ residuals) / freedom if freedom > 0 else float("nan")
    covariance = scale * inverse / np.outer(length, length)
    return Fit(
        parameters=parameters,
        residuals=residuals,
        jacobian=jacobian,
        covariance=covariance,
        scale=scale,
        iterations=iterations,
    )


def _finite(values: Vector) -> Vector:
    if not np.isfinite(values).all():
        raise FitFailed("the start of the fit gives no finite residuals; check the samples")
    return values
