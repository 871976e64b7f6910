"""Lens, mount and target's place in one bundle adjustment, the arm's own errors in it.

What is seen is off for two reasons: each corner by the picture's noise, and all corners of a
view together because the arm is not quite where it says. The covariance of a view's residuals
is σ² I + Q S Qᵀ with Q their derivatives by the arm's pose and S the arm's stated exactness;
residuals are whitened with its inverse root. σ comes from what is left within views once the
arm's pose is taken out, which needs no statement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.least_squares import Fit
from calibration.least_squares import fit as least_squares
from calibration.mount.model import MountState, MountView, Scene
from calibration.statistics import chi_square_quantile

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

_ROUNDS = 6
_SETTLED = 0.002
_LEAST_SIGMA_PX = 1e-4
_CERTAIN = 0.999


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmNoise:
    """How exactly the arm is where it says, as standard deviations.

    Attributes:
        position_mm: Along each axis.
        angle_deg: About each axis.
    """

    position_mm: float = 0.02
    angle_deg: float = 0.005


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MountFit:
    """What was fitted.

    Attributes:
        state: The fitted values.
        covariance: Of the parameters in the order of `MountState.moved`.
        sigma_px: Noise of a corner along an axis, from within the views.
        residuals: Seen less fitted pixels, view by view, (n, 2).
        strain: What views are off as a whole, sum of squares in standard deviations.
        freedom: How much of that is expected.
    """

    state: MountState
    covariance: Matrix
    sigma_px: float
    residuals: tuple[Points, ...]
    strain: float
    freedom: int

    @property
    def is_consistent(self) -> bool:
        """Whether views fit together as well as the arm is said to be exact."""
        return self.strain <= chi_square_quantile(_CERTAIN, max(self.freedom, 1))

    @property
    def strain_ratio(self) -> float:
        """How many times as far off views are as they should be; 1 where that is chance."""
        if self.is_consistent:
            return 1.0
        return math.sqrt(self.strain / max(self.freedom, 1))


def fit_mount(
    views: Sequence[MountView], start: MountState, noise: ArmNoise, *, with_scale: bool = False
) -> MountFit:
    """Fit lens, mount and the target's places.

    Where views disagree by more than chance, the covariance is larger by as much (Birge's
    ratio).

    Args:
        views: The views.
        start: Where to begin.
        noise: How exact the arm is.
        with_scale: Whether the target's scale is fitted, too.

    Raises:
        FitFailed: The views do not determine it.
    """
    scene = Scene(views)
    count = 11 + 6 * len(start.targets) + int(with_scale)
    if 2 * len(scene.points) <= count + 6 * len(views):
        raise FitFailed(f"{len(scene.points)} corners are too few; show more of the target")
    state, sigma = start, math.inf
    for _ in range(_ROUNDS):
        before = sigma
        whiten, sigma = _whitener(scene, state, noise)
        fit = _step(scene, state, whiten, count, with_scale=with_scale)
        state = state.moved(fit.parameters)
        if abs(sigma - before) < _SETTLED * sigma:
            break
    if state.lens[0] <= 0:
        raise FitFailed("the views do not determine the lens; tilt the hand more")
    together = whiten.along(scene.residuals(state))
    strain = float(together @ together)
    freedom = 6 * len(views) - count + 5
    fitted = MountFit(
        state=state,
        covariance=fit.covariance,
        sigma_px=sigma,
        residuals=tuple(np.split(scene.residuals(state).reshape(-1, 2), scene.ends[1:-1])),
        strain=strain,
        freedom=freedom,
    )
    if fitted.is_consistent:
        return fitted
    return MountFit(
        state=state,
        covariance=fit.covariance * fitted.strain_ratio**2,
        sigma_px=sigma,
        residuals=fitted.residuals,
        strain=strain,
        freedom=freedom,
    )


def information(scene: Scene, state: MountState, noise: ArmNoise, sigma_px: float) -> Matrix:
    """Return what views would tell of the parameters: the normal matrix (p, p)."""
    slopes, by_arm = scene.slopes(state)
    white = _Whitener(scene.ends, by_arm * _spread(noise), sigma_px).all(slopes)
    return np.asarray(white.T @ white)


class _Whitener:
    """Multiplies with the inverse root of σ² I + Q S Qᵀ, view by view."""

    def __init__(self, ends: NDArray[np.int_], spread: Matrix, sigma_px: float) -> None:
        self._ends, self._sigma = 2 * ends, sigma_px
        self._parts: list[tuple[Matrix, Points]] = []
        for low, high in zip(self._ends[:-1], self._ends[1:], strict=True):
            left, size, _ = np.linalg.svd(spread[low:high], full_matrices=False)
            self._parts.append((left, 1.0 / np.sqrt(1.0 + (size / sigma_px) ** 2)))

    def all(self, values: Matrix) -> Matrix:
        """Return whitened rows (n,) or (n, p)."""
        out = np.empty_like(values)
        for (left, size), low, high in self._views():
            part = values[low:high]
            along = left.T @ part
            less = (1.0 - size) if part.ndim == 1 else (1.0 - size)[:, None]
            out[low:high] = part - left @ (less * along)
        return out / self._sigma

    def along(self, values: Points) -> Points:
        """Return the whitened parts along the arm's errors, 6 a view."""
        found = [size * (left.T @ values[a:b]) for (left, size), a, b in self._views()]
        return np.concatenate(found) / self._sigma

    def _views(self) -> list[tuple[tuple[Matrix, Points], int, int]]:
        return list(zip(self._parts, self._ends[:-1], self._ends[1:], strict=True))


def _whitener(scene: Scene, state: MountState, noise: ArmNoise) -> tuple[_Whitener, float]:
    """Return the whitener for a state, with the noise found within the views."""
    _, by_arm = scene.slopes(state)
    residuals = scene.residuals(state)
    alone = _Whitener(scene.ends, by_arm * 1e9, 1.0).all(residuals)
    freedom = residuals.size - 6 * len(scene.counts) - 5
    sigma = max(math.sqrt(float(alone @ alone) / freedom), _LEAST_SIGMA_PX)
    return _Whitener(scene.ends, by_arm * _spread(noise), sigma), sigma


def _step(
    scene: Scene, state: MountState, whiten: _Whitener, count: int, *, with_scale: bool
) -> Fit:
    def residuals(change: Points) -> Points:
        return whiten.all(scene.residuals(state.moved(change)))

    def slopes(change: Points) -> Matrix:
        # Right turns at a changed state differ from those at the first by second order only,
        # which the next round takes out.
        return -whiten.all(scene.slopes(state.moved(change), with_scale=with_scale)[0])

    return least_squares(
        residuals, np.zeros(count), jacobian=slopes, is_noise_known=True, steps=25, tolerance=1e-6
    )


def _spread(noise: ArmNoise) -> Points:
    return np.repeat([noise.position_mm, math.radians(noise.angle_deg)], 3)
