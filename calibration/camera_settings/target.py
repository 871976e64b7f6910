"""What a picture shall look like: patches of a picture from when it was right.

Under light of another level or colour every patch changes by the same factor in a channel.
Patches that do not, because an arm or a block is there now, are left out by their own
disagreement; half of the others is kept out of the search and judges it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.errors import CalibrationError
from cell.vision.picture_measures import Patches, focus, patches

COLUMNS, ROWS = 32, 24
FULL_SIZE = (960, 1280, 3)

_LEAST_LEVEL = 6.0
_LEAST_TARGET_LEVEL = 30.0
_MOST_TEXTURE_SHARE = 0.2
_MOST_CLIPPED = 0.01
_AGREEMENT = 0.10
_LEAST_USABLE = 12

Means = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Target:
    """What the patches shall look like.

    Attributes:
        means: Mean levels R G B, (24, 32, 3).
        clipped: Share of clipped pixels, (24, 32).
        is_stable: Which patches count, (24, 32): those of one colour that are bright enough.
        sharpness: `focus` of the picture; 0 if it is not known.
        source: Where it comes from, in words.
    """

    means: Means
    clipped: NDArray[np.float64]
    is_stable: Mask
    sharpness: float
    source: str

    @property
    def clipped_share(self) -> float:
        """Share of the whole picture that is clipped."""
        return float(self.clipped.mean())

    def as_json(self) -> dict[str, JsonValue]:
        """Return it as a record keeps it."""
        return {
            "columns": COLUMNS,
            "rows": ROWS,
            "means": [round(float(v), 1) for v in self.means.ravel()],
            "clipped": [round(float(v), 3) for v in self.clipped.ravel()],
            "stable": [int(v) for v in self.is_stable.ravel()],
            "sharpness": round(self.sharpness, 4),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """How a picture compares with a target.

    Attributes:
        log_ratios: By how much light in R G B lacks: ln of wanted over seen.
        stable: How many patches could be compared in good light.
        usable: How many patches say so: neither clipped nor dark.
        agreeing: How many of these agree with each other.
        error: Mean difference over the agreeing patches and channels, grey levels, of the
            half that the search does not use.
        fit_error: The same of the half that it uses.
        worst_channel: Greatest mean difference of a channel, of the held-out half.
        clipped_share: Share of the stable patches that are clipped.
        dark_share: Share of the stable patches that are too dark to tell anything.
        held_out: How many patches `error` is over.
        correlation: Of the brightness of stable patches with the target; 1 for the same scene.
    """

    log_ratios: tuple[float, float, float]
    stable: int
    usable: int
    agreeing: int
    error: float
    fit_error: float
    worst_channel: float
    clipped_share: float
    dark_share: float
    held_out: int
    correlation: float

    @property
    def is_readable(self) -> bool:
        """Whether enough patches tell by how much light is off."""
        return self.usable >= min(_LEAST_USABLE, max(self.stable // 2, 1))


def target_of(pixels: NDArray[np.uint8], source: str) -> Target:
    """Return a picture of 1280 x 960 as a target.

    Raises:
        CalibrationError: It has another size.
    """
    if pixels.shape != FULL_SIZE:
        raise CalibrationError(
            f"{source} has {pixels.shape[1]} x {pixels.shape[0]} px; 1280 x 960 are needed"
        )
    cut = patches(pixels, COLUMNS, ROWS)
    return Target(
        means=cut.means,
        clipped=cut.clipped,
        is_stable=_stable(cut),
        sharpness=focus(pixels),
        source=source,
    )


def grey_target(box_px: tuple[float, float, float, float], level: float) -> Target:
    """Return the target that all patches inside a rectangle are grey of one level.

    Args:
        box_px: Left, top, right and bottom in the picture (1280 x 960).
        level: Grey level, 0 to 255.

    Raises:
        CalibrationError: No whole patch lies in the rectangle.
    """
    side = 1280 // COLUMNS
    left, top, right, bottom = box_px
    column, row = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    inside = (column * side >= left) & ((column + 1) * side <= right)
    inside &= (row * side >= top) & ((row + 1) * side <= bottom)
    if not inside.any():
        raise CalibrationError(
            f"no whole patch of {side} x {side} px lies in the rectangle {box_px}; "
            "point at a larger grey area"
        )
    return Target(
        means=np.full((ROWS, COLUMNS, 3), level),
        clipped=np.zeros((ROWS, COLUMNS)),
        is_stable=inside,
        sharpness=0.0,
        source=f"a grey area at level {level:g}",
    )


def target_from_json(kept: JsonValue, source: str) -> Target:
    """Return the target that a record keeps.

    Raises:
        CalibrationError: The record keeps none, or one of another kind.
    """
    if not isinstance(kept, dict) or (kept.get("columns"), kept.get("rows")) != (COLUMNS, ROWS):
        raise CalibrationError(f"{source} keeps no patches; take a reference picture again")
    try:
        means = np.array(kept["means"], np.float64).reshape(ROWS, COLUMNS, 3)
        clipped = np.array(kept["clipped"], np.float64).reshape(ROWS, COLUMNS)
        stable = np.array(kept["stable"], np.float64).reshape(ROWS, COLUMNS) > 0
        sharpness = float(np.array(kept["sharpness"], np.float64))
    except (KeyError, TypeError, ValueError) as error:
        raise CalibrationError(f"{source} keeps damaged patches; calibrate again") from error
    return Target(
        means=means, clipped=clipped, is_stable=stable, sharpness=sharpness, source=source
    )


def match(target: Target, pixels: NDArray[np.uint8], gamma: float = 1.0) -> Match:
    """Compare a picture of 1280 x 960 with a target.

    Args:
        target: What it shall look like.
        pixels: R G B.
        gamma: Of the camera: a level is light to the power of 1 / gamma.
    """
    seen = patches(pixels, COLUMNS, ROWS)
    stable = target.is_stable & (target.clipped <= _MOST_CLIPPED)
    is_clipped = seen.clipped > _MOST_CLIPPED
    is_dark = seen.means.min(axis=2) < _LEAST_LEVEL
    usable = stable & ~is_clipped & ~is_dark
    logs = gamma * (np.log(np.maximum(target.means, 1.0)) - np.log(np.maximum(seen.means, 1.0)))
    first, second = _halves()
    ratios, agrees = _consensus(logs, usable, usable & first, target.means)
    counted = (agrees | (stable & is_clipped)) if agrees.any() else stable
    difference = np.abs(target.means - seen.means)
    held, fitted = difference[counted & second], difference[counted & first]
    total = max(int(stable.sum()), 1)
    return Match(
        log_ratios=ratios,
        stable=int(stable.sum()),
        usable=int(usable.sum()),
        agreeing=int(agrees.sum()),
        error=float(held.mean()) if held.size else float("inf"),
        fit_error=float(fitted.mean()) if fitted.size else float("inf"),
        worst_channel=float(held.mean(axis=0).max()) if held.size else float("inf"),
        clipped_share=float((stable & is_clipped).sum()) / total,
        dark_share=float((stable & is_dark).sum()) / total,
        held_out=len(held),
        correlation=_correlation(target, seen),
    )


def _stable(cut: Patches) -> Mask:
    """Return the patches of one colour: little structure inside, bright enough to count."""
    green = cut.means[..., 1]
    is_even = cut.deviations <= np.maximum(_MOST_TEXTURE_SHARE * green, 6.0)
    return np.asarray(is_even & (cut.means.max(axis=2) >= _LEAST_TARGET_LEVEL))


def _halves() -> tuple[Mask, Mask]:
    """Return the patches of a chessboard: fitted on, held out."""
    column, row = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    first = (column + row) % 2 == 0
    return first, ~first


def _consensus(
    logs: Means, usable: Mask, fitted: Mask, weights: Means
) -> tuple[tuple[float, float, float], Mask]:
    """Return the factor that most patches share, and which patches do.

    The brighter a patch, the more it counts: what the lamps do not light, such as the
    screen's own glow, shows in dark ones.
    """
    chosen = fitted if fitted.any() else usable
    if not chosen.any():
        return (0.0, 0.0, 0.0), usable
    middle = np.array(
        [_weighted_median(logs[chosen][:, c], weights[chosen][:, c]) for c in range(3)]
    )
    near = usable & (np.abs(logs - middle).max(axis=2) <= _AGREEMENT)
    inner = near & chosen
    if inner.any():
        share = weights[inner]
        middle = (logs[inner] * share).sum(axis=0) / share.sum(axis=0)
    return (float(middle[0]), float(middle[1]), float(middle[2])), near


def _weighted_median(values: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    order = np.argsort(values)
    running = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])


def _correlation(target: Target, seen: Patches) -> float:
    """Return how alike two pictures' patches are in brightness, whatever their exposure."""
    both = (target.clipped <= _MOST_CLIPPED) & (seen.clipped <= _MOST_CLIPPED)
    a, b = target.means[..., 1][both], seen.means[..., 1][both]
    if a.size < 8 or a.std() < 1e-9 or b.std() < 1e-9:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])
