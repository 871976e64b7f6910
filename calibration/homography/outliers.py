"""Whether pairs scatter as their noise says, and if not, which one is to blame."""

from __future__ import annotations

import numpy as np

from calibration.errors import FitFailed
from calibration.homography.judging import Pairs
from calibration.homography.knowledge import CameraKnowledge
from calibration.homography.noise import PairNoise
from calibration.statistics import chi_square_quantile
from calibration.verdict import Finding, Grade

SURE = 0.999
"""Share of sound calibrations that are not called noisy."""

_CLEAR = 8.0
_CLEARLY_LESS = 0.25


def judge_noise(
    pairs: Pairs, known: CameraKnowledge, noise: PairNoise, *, by_arm: bool
) -> tuple[Finding, ...]:
    """Return which pair, or that all together, scatter more than the stated noise explains."""
    total = _chi_square(pairs, known, noise)
    if total is None or total[0] <= chi_square_quantile(SURE, total[1]):
        return ()
    suspects: list[tuple[float, int]] = []
    allowed = _CLEARLY_LESS * total[0]
    for index in range(len(pairs.labels)):
        rest = _chi_square(pairs.without(index), known, noise)
        if rest is not None:
            suspects.append((rest[0], index))
            allowed = max(allowed, chi_square_quantile(SURE, rest[1]))
    suspects.sort()
    # Twice the difference of chi squares is what speaks for one suspect against the next.
    if len(suspects) > 1 and suspects[0][0] <= allowed:
        best, second = suspects[0][0], suspects[1][0]
        if second - best > max(_CLEAR, best):
            return (_named(pairs, suspects[0][1], known, noise, by_arm=by_arm),)
    ratio = float(np.sqrt(total[0] / total[1]))
    return (
        Finding(
            code="noisier-than-stated",
            grade=Grade.DEGRADED,
            text=f"the pairs scatter {ratio:.1f} times as much as the stated noise of "
            f"{noise.pixel_px:g} px and {noise.placement_mm:g} mm",
            hint=(
                "calibrate the lens first, or look whether the camera or the object moves"
                if known.lens is None
                else "look whether the camera or the object moves, or state the noise as it is"
            ),
        ),
    )


def _named(
    pairs: Pairs, index: int, known: CameraKnowledge, noise: PairNoise, *, by_arm: bool
) -> Finding:
    rest = pairs.without(index)
    fit = known.fit(rest.pixels, rest.points_mm, noise)
    miss = fit.to_robot(pairs.pixels[[index]])[0] - pairs.points_mm[index]
    label = pairs.labels[index]
    off = f"{np.hypot(*miss):.1f} mm ({miss[0]:+.1f}, {miss[1]:+.1f})"
    if by_arm:
        return Finding(
            code="object-moved",
            grade=Grade.BAD,
            text=f"{label}: the object lies {off} from where the arm put it; the other "
            f"{len(rest.labels)} points fit",
            hint="nobody may touch it after it is placed; see that the fingers let it go freely, "
            "and calibrate again",
            samples=(label,),
        )
    return Finding(
        code="outlier-pair",
        grade=Grade.BAD,
        text=f"{label} lies {off} from where the other {len(rest.labels)} points put it",
        hint="point at it again, or check its position",
        samples=(label,),
    )


def _chi_square(pairs: Pairs, known: CameraKnowledge, noise: PairNoise) -> tuple[float, int] | None:
    """Return the sum of squared residuals in standard deviations, and its freedom."""
    freedom = 2 * len(pairs.labels) - (8 if known.lens is None else 6)
    if len(pairs.labels) < 4 or freedom < 1:
        return None
    try:
        fit = known.fit(pairs.pixels, pairs.points_mm, noise)
    except FitFailed:
        return None
    return None if fit.noise_ratio is None else (fit.noise_ratio**2 * freedom, freedom)
