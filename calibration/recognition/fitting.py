"""Fits colours and kinds to samples, and tries the fit on blocks that it has not seen.

All colours share one scatter, that of light and noise over the table, because few blocks of
each are there; a colour's own scatter counts the more the more samples it has. The spread of
a mean of few samples is added, so that regions hold new blocks as often as they should.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.recognition.samples import BlockSample, features_of
from calibration.statistics import t_quantile
from cell.profile import LearnedColourProfile, LearnedKindProfile
from cell.vision.colour_model import ColourClass, ColourModel

_POOL_WEIGHT = 10.0
_LEAST_DEVIATION = np.array([0.04, 0.04, 0.07])
"""By so much the light's colour and level may change before the check of the camera's settings
says so: what was learned must hold until then."""

_RANGE_PROBABILITY = 0.999
_LEAST_AREA_SHARE = 0.02
_LEAST_CIRCULARITY = 0.02

Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tried:
    """How samples came out that a fit had not seen.

    Attributes:
        count: How many.
        right: How many got their own colour.
        abstained: How many got none.
        wrong: Slots of those that got another.
        least_margin: Least margin of a right one to the next colour.
        how: Which those samples are.
    """

    count: int
    right: int
    abstained: int
    wrong: tuple[int, ...]
    least_margin: float
    how: str


def fit_colours(samples: Sequence[BlockSample], origin: str) -> ColourModel:
    """Return the colours of samples.

    Raises:
        FitFailed: There are fewer than two samples of any colour.
    """
    names = sorted({sample.colour for sample in samples})
    by_name = {n: features_of([s for s in samples if s.colour == n]) for n in names}
    freedom = sum(len(f) - 1 for f in by_name.values())
    if freedom < 2:
        raise FitFailed("one sample of each colour tells nothing of their scatter; take more")
    pooled = sum((_scatter(f) for f in by_name.values()), np.zeros((3, 3))) / freedom
    return ColourModel(
        classes=tuple(_class(name, by_name[name], pooled) for name in names), origin=origin
    )


def try_held_out(samples: Sequence[BlockSample]) -> Tried:
    """Return how each block comes out by a fit without any of its samples.

    Where a colour has a single block, its samples are left out one by one.
    """
    right = abstained = singles = 0
    wrong: list[int] = []
    margins: list[float] = []
    for slot in sorted({s.slot for s in samples}):
        own = [s for s in samples if s.slot == slot]
        others = [s for s in samples if s.slot != slot]
        if any(s.colour == own[0].colour for s in others):
            groups = [(own, others)]
        elif len(own) > 1:
            singles += 1
            groups = [([s], [o for o in samples if o is not s]) for s in own]
        else:
            continue
        for held, rest in groups:
            try:
                model = fit_colours(rest, "")
            except FitFailed:
                # What is left is too little to learn from; nothing was tried then.
                continue
            for sample in held:
                guess = model.classify(sample.mean_rgb)
                right += guess.colour == sample.colour
                abstained += guess.colour is None
                if guess.colour not in (None, sample.colour):
                    wrong.append(slot)
                if guess.colour == sample.colour:
                    margins.append(guess.margin)
    how = "leaving one block out" + (f", one place of {singles} single blocks" if singles else "")
    return Tried(
        count=right + abstained + len(wrong),
        right=right,
        abstained=abstained,
        wrong=tuple(wrong),
        least_margin=min(margins, default=0.0),
        how=how,
    )


def fit_kinds(samples: Sequence[BlockSample]) -> dict[str, LearnedKindProfile]:
    """Return ranges of area and circularity that hold 99.9 % of new regions of each kind."""
    kinds = {}
    for kind in sorted({s.kind for s in samples}):
        own = [s for s in samples if s.kind == kind]
        if len(own) < 3:
            continue
        area = _range([float(s.area_px) for s in own], _LEAST_AREA_SHARE, is_share=True)
        roundness = _range([s.circularity for s in own], _LEAST_CIRCULARITY, is_share=False)
        kinds[kind] = LearnedKindProfile(
            area_px=area, circularity=(roundness[0], min(roundness[1], 1.0))
        )
    return kinds


def colour_profiles(model: ColourModel) -> dict[str, LearnedColourProfile]:
    """Return colours as the profile keeps them."""
    return {
        one.colour: LearnedColourProfile(mean=one.mean, covariance=one.covariance)
        for one in model.classes
    }


def nearest_pairs(model: ColourModel) -> list[tuple[str, str, float]]:
    """Return all pairs of colours with their margin, nearest first."""
    names = model.colours
    pairs = [(a, b, model.margin(a, b)) for i, a in enumerate(names) for b in names[i + 1 :]]
    return sorted(pairs, key=lambda pair: pair[2])


def _scatter(features: Matrix) -> Matrix:
    offset = features - features.mean(axis=0)
    return np.asarray(offset.T @ offset)


def _class(name: str, features: Matrix, pooled: Matrix) -> ColourClass:
    count = len(features)
    own = _scatter(features)
    covariance = (own + _POOL_WEIGHT * pooled) / (max(count - 1, 0) + _POOL_WEIGHT)
    covariance = covariance * (1.0 + 1.0 / count) + np.diag(_LEAST_DEVIATION**2)
    mean = features.mean(axis=0)
    rows = tuple((float(r[0]), float(r[1]), float(r[2])) for r in covariance)
    return ColourClass(
        colour=name,
        mean=(float(mean[0]), float(mean[1]), float(mean[2])),
        covariance=(rows[0], rows[1], rows[2]),
    )


def _range(values: list[float], least: float, *, is_share: bool) -> tuple[float, float]:
    """Return the interval that holds a new value with 99.9 %, never narrower than `least`."""
    array = np.array(values)
    mean, spread = float(array.mean()), float(array.std(ddof=1))
    half = t_quantile(_RANGE_PROBABILITY, len(values) - 1) * spread * math.sqrt(1 + 1 / len(values))
    half = max(half, least * mean if is_share else least)
    return max(mean - half, 0.0), mean + half
