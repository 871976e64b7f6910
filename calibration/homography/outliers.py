"""Whether pairs scatter as their noise says, and if not, which one is to blame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.homography.judging import Pairs
from calibration.homography.knowledge import CameraKnowledge
from calibration.homography.noise import PairNoise
from calibration.statistics import chi_square_quantile
from calibration.verdict import Finding, Grade

Points = NDArray[np.float64]

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
    suspects: list[tuple[float, int, Points | None]] = []
    allowed = _CLEARLY_LESS * total[0]
    for index in range(len(pairs.labels)):
        rest = _chi_square(pairs.without(index), known, noise)
        if rest is not None:
            suspects.append((rest[0], index, None))
            allowed = max(allowed, chi_square_quantile(SURE, rest[1]))
    if by_arm:
        # All but the first being off, or the last alone, is one pair that is off.
        for index in range(2, len(pairs.labels) - 1):
            carried = _carried_on(pairs, index, known, noise)
            if carried is not None:
                suspects.append((carried[0], index, carried[1]))
    suspects.sort(key=lambda suspect: suspect[0])
    if _stands_out(suspects, allowed):
        _, index, offset_mm = suspects[0]
        if offset_mm is not None:
            return (_carried(pairs, index, offset_mm),)
        return (_named(pairs, index, known, noise, by_arm=by_arm),)
    if by_arm:
        neighbours = _two_in_a_row(pairs, known, noise, _CLEARLY_LESS * total[0])
        if neighbours is not None:
            return (_touched(pairs, neighbours, known, noise),)
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


def _stands_out(suspects: list[tuple[float, int, Points | None]], allowed: float) -> bool:
    """Return whether the first of the sorted suspects explains the scatter, and no other does."""
    if len(suspects) < 2 or suspects[0][0] > allowed:
        return False
    # Twice the difference of chi squares is what speaks for one suspect against the next.
    best, second = suspects[0][0], suspects[1][0]
    return second - best > max(_CLEAR, best)


def _two_in_a_row(
    pairs: Pairs, known: CameraKnowledge, noise: PairNoise, allowed: float
) -> int | None:
    """Return the first of two pairs without which the others fit.

    An object that was pushed along the fingers keeps its offset in them until they grip it
    turned by a quarter, which centres it: it is off where it was pushed and once more.
    """
    suspects: list[tuple[float, int, Points | None]] = []
    for index in range(len(pairs.labels) - 1):
        rest = _chi_square(pairs.without(index + 1).without(index), known, noise)
        if rest is not None:
            suspects.append((rest[0], index, None))
            allowed = max(allowed, chi_square_quantile(SURE, rest[1]))
    suspects.sort(key=lambda suspect: suspect[0])
    return suspects[0][1] if _stands_out(suspects, allowed) else None


def _touched(pairs: Pairs, index: int, known: CameraKnowledge, noise: PairNoise) -> Finding:
    both = slice(index, index + 2)
    rest = pairs.without(index + 1).without(index)
    fit = known.fit(rest.pixels, rest.points_mm, noise)
    miss = fit.to_robot(pairs.pixels[both]) - pairs.points_mm[both]
    first, second = (f"{np.hypot(*one):.1f} mm ({one[0]:+.1f}, {one[1]:+.1f})" for one in miss)
    labels = pairs.labels[both]
    return Finding(
        code="object-moved",
        grade=Grade.BAD,
        text=f"the object lies {first} at {labels[0]} and {second} at {labels[1]} from where the "
        f"arm put it, as if it was pushed and carried on so; the other {len(rest.labels)} points "
        "fit",
        hint="nobody may touch it after it is placed; see that the fingers let it go freely, "
        "and calibrate again",
        samples=labels,
    )


def _carried(pairs: Pairs, index: int, offset_mm: Points) -> Finding:
    labels = pairs.labels[index:]
    off = f"{np.hypot(*offset_mm):.1f} mm ({offset_mm[0]:+.1f}, {offset_mm[1]:+.1f})"
    return Finding(
        code="object-moved",
        grade=Grade.BAD,
        text=f"from {labels[0]} on the object lies {off} from where the arm put it, as if it was "
        "pushed between the fingers and carried on so; the pairs before fit",
        hint="nobody may touch it after it is placed; bring it home, so that it is gripped anew, "
        "and calibrate again",
        samples=labels,
    )


def _carried_on(
    pairs: Pairs, index: int, known: CameraKnowledge, noise: PairNoise
) -> tuple[float, Points] | None:
    """Return the least sum of squares where all pairs from one on share an offset, and that."""

    def cost(offset_mm: Points) -> float | None:
        points_mm = pairs.points_mm.copy()
        points_mm[index:] += offset_mm
        found = _chi_square(Pairs(pairs.labels, pairs.pixels, points_mm), known, noise)
        return None if found is None else found[0]

    # The fit is all but linear in the offset: its cost is a paraboloid, known from six points.
    tried = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1))
    costs = [cost(np.array(offset, np.float64)) for offset in tried]
    known_costs = [one for one in costs if one is not None]
    if len(known_costs) < len(tried):
        return None
    middle, right, left, up, down, both = known_costs
    slope = np.array([right - left, up - down]) / 2.0
    xx, yy = right + left - 2.0 * middle, up + down - 2.0 * middle
    xy = both - right - up + middle
    bend = np.array([[xx, xy], [xy, yy]])
    if float(np.linalg.eigvalsh(bend).min()) <= 0:
        return None
    offset_mm = -np.linalg.solve(bend, slope)
    least = cost(offset_mm)
    return None if least is None else (least, offset_mm)


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
