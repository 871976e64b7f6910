"""Names what is wrong with pairs of picture and robot points, before anything is fitted.

A homography goes exactly through any four pairs, also wrong ones. What tells here is that
the camera looks down (see `similarity`), and the map that held before, if there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from calibration.homography.similarity import distances, misfit, similarity
from calibration.verdict import Finding, Grade

Points = NDArray[np.float64]

SIMILARITY_SHARE = 0.06
"""How far, as a share of the points' spread, a camera's map may be from a similarity: that of
a camera tilted by about 10 deg."""

LEAST_MISTAKE_MM = 8.0
"""Pairs nearer than this to what the map before tells are not called mistaken."""

_LIKELY_TURN_DEG = 90.0
_LINE_SHARE = 0.05
_SAME_MM = 5.0
_SAME_PX = 5.0
_SAME_SHARE = 0.01
_UNIT_SLACK = 0.12
_UNITS = (
    (10.0, "cm-for-mm", "centimetres"),
    (25.4, "inches-for-mm", "inches"),
    (1000.0, "m-for-mm", "metres"),
)


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Pairs to judge.

    Attributes:
        labels: Name of each.
        pixels: u, v, shape (n, 2).
        points_mm: Robot x, y, shape (n, 2).
    """

    labels: tuple[str, ...]
    pixels: Points
    points_mm: Points

    def without(self, index: int) -> Pairs:
        """Return all but one."""
        return Pairs(
            self.labels[:index] + self.labels[index + 1 :],
            np.delete(self.pixels, index, axis=0),
            np.delete(self.points_mm, index, axis=0),
        )


def judge_pairs(
    pairs: Pairs, before: Callable[[Points], Points] | None = None
) -> tuple[Finding, ...]:
    """Return what is wrong with pairs; nothing if they are plausible.

    Args:
        pairs: Four or more.
        before: The map that held before, from pixels (n, 2) to robot points (n, 2).
    """
    geometry = _geometry(pairs)
    if geometry is not None:
        return (geometry,)
    allowed_mm = SIMILARITY_SHARE * _spread(pairs.points_mm)
    if _fits(pairs.pixels, pairs.points_mm, allowed_mm):
        return () if before is None else _against(pairs, before(pairs.pixels))
    return (_named(pairs, allowed_mm, None if before is None else before(pairs.pixels)),)


def _spread(points: Points) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _fits(pixels: Points, points_mm: Points, allowed_mm: float, is_mirrored: bool = True) -> bool:
    return bool(misfit(pixels, points_mm, is_mirrored=is_mirrored).max() <= allowed_mm)


def _geometry(pairs: Pairs) -> Finding | None:
    """Return what is wrong with where the points lie, whatever they are paired with."""
    same_mm = min(_SAME_MM, _SAME_SHARE * _spread(pairs.points_mm))
    for i, j in combinations(range(len(pairs.labels)), 2):
        near_mm = float(np.hypot(*(pairs.points_mm[i] - pairs.points_mm[j])))
        near_px = float(np.hypot(*(pairs.pixels[i] - pairs.pixels[j])))
        if near_mm <= same_mm or near_px < _SAME_PX:
            return _bad(
                "duplicate-pair",
                f"{pairs.labels[i]} and {pairs.labels[j]} are the same point: {near_mm:.1f} mm "
                f"and {near_px:.1f} px apart",
                "take each point once, far from the others",
                pairs.labels[i],
                pairs.labels[j],
            )
    for points in (pairs.points_mm, pairs.pixels):
        line = _on_a_line(points)
        if line is not None:
            names = tuple(pairs.labels[i] for i in line)
            return _bad(
                "collinear-points",
                f"{_listed(names)} lie on a line, the rest does not determine the map",
                "put the points at the corners of the playground",
                *names,
            )
    return None


def _on_a_line(points: Points) -> tuple[int, ...] | None:
    """Return the points on a line that leaves fewer than four in general position."""
    size = _spread(points)
    most: tuple[int, ...] = ()
    for i, j in combinations(range(len(points)), 2):
        along = points[j] - points[i]
        length = float(np.hypot(*along))
        across = np.abs((points - points[i]) @ (-along[1], along[0])) / max(length, 1e-9)
        on = tuple(int(k) for k in np.flatnonzero(across <= _LINE_SHARE * size))
        most = max(most, on, key=len)
    return most if len(most) > len(points) - 2 else None


def _named(pairs: Pairs, allowed_mm: float, before_mm: Points | None) -> Finding:
    """Return which mistake makes pairs that do not fit together fit."""
    # A swap first: the other way round it fits, and mirrored orders are two swaps.
    labels, pixels, points = pairs.labels, pairs.pixels, pairs.points_mm
    swaps = _swaps(pairs, allowed_mm, before_mm)
    if swaps:
        names = [f"{labels[i]} and {labels[j]}" for i, j in swaps]
        more = "" if len(swaps) == 1 else "; which of the two, only a map from before could tell"
        return _bad(
            "swapped-pairs",
            f"the picture points of {', or of '.join(names)} are exchanged: the other way "
            f"round all pairs fit{more}",
            "exchange them",
            *(labels[i] for swap in swaps for i in swap),
        )
    if _fits(pixels, points, allowed_mm, is_mirrored=False):
        return _bad(
            "mirrored-order",
            "the pairs fit a mirrored picture only, and no camera above the table sees that: "
            "they go round the playground the wrong way, or the picture is mirrored",
            "name the picture points in the order of the robot points, and switch off mirroring "
            "in the camera",
            *labels,
        )
    if len(labels) == 4:
        for turned in permutations(range(4)):
            if _fits(pixels[list(turned)], points, allowed_mm):
                right = _listed(tuple(labels[i] for i in turned))
                return _bad(
                    "mixed-order",
                    f"the picture points are in another order than the robot points; they fit as "
                    f"{right}",
                    "put them into that order",
                    *labels,
                )
    return _left_out(pairs, allowed_mm)


def _swaps(
    pairs: Pairs, allowed_mm: float, before_mm: Points | None
) -> tuple[tuple[int, int], ...]:
    """Return the exchanges after which all pairs fit; those the map before denies left out.

    Of a rectangle's corners the two on either diagonal may have been exchanged: the results
    are half a turn apart.
    """
    found = []
    for i, j in combinations(range(len(pairs.labels)), 2):
        order = list(range(len(pairs.labels)))
        order[i], order[j] = j, i
        if _fits(pairs.pixels[order], pairs.points_mm, allowed_mm):
            turn = 0.0
            if before_mm is not None:
                change = similarity(before_mm[order], pairs.points_mm, is_mirrored=False)
                turn = abs(change.turn_deg)
            if turn <= _LIKELY_TURN_DEG:
                found.append((i, j))
    return tuple(found)


def _left_out(pairs: Pairs, allowed_mm: float) -> Finding:
    """Return the one pair without which the others fit."""
    rest: list[tuple[float, int, Points]] = []
    for index in range(len(pairs.labels)):
        others = pairs.without(index)
        own = SIMILARITY_SHARE * _spread(others.points_mm)
        found = similarity(others.pixels, others.points_mm, is_mirrored=True)
        worst = float(distances(found(others.pixels), others.points_mm).max())
        if worst <= own and found.scale > 0:
            rest.append((worst, index, found(pairs.pixels[index : index + 1])[0]))
    if not rest:
        return _bad(
            "inconsistent-pairs",
            f"the pairs do not fit together: {allowed_mm:.0f} mm would be allowed to a tilted "
            f"camera, they are up to "
            f"{misfit(pairs.pixels, pairs.points_mm, is_mirrored=True).max():.0f} mm apart; "
            "more than one is wrong",
            "take them again, one by one",
            *pairs.labels,
        )
    _, index, expected = min(rest, key=lambda one: one[0])
    given = pairs.points_mm[index]
    label = pairs.labels[index]
    return _bad(
        "misplaced-pair",
        f"{label} does not fit the others: robot ({given[0]:g}, {given[1]:g}) mm is given, the "
        f"others put it near ({expected[0]:.0f}, {expected[1]:.0f}) mm",
        f"{_guess(given, expected, allowed_mm)}, or take this pair again",
        label,
    )


def _guess(given: Points, expected: Points, allowed_mm: float) -> str:
    """Return what was probably meant by a robot point."""
    x, y = (float(v) for v in given)
    for guess in ((x, -y), (-x, y), (-x, -y), (y, x), (-y, x), (y, -x)):
        if float(np.hypot(*(np.array(guess) - expected))) <= 2.0 * allowed_mm:
            return f"if ({guess[0]:g}, {guess[1]:g}) was meant, correct it"
    return "look for a misprint in it"


def _against(pairs: Pairs, before_mm: Points) -> tuple[Finding, ...]:
    """Judge plausible pairs against the map that held before."""
    change = similarity(before_mm, pairs.points_mm, is_mirrored=False)
    for ratio, code, unit in _UNITS:
        if abs(change.scale * ratio - 1.0) < _UNIT_SLACK:
            return (
                _bad(
                    code,
                    f"the robot points seem to be given in {unit}: by the map before they are "
                    f"{1.0 / change.scale:.1f} times as far apart",
                    "give them in millimetres",
                    *pairs.labels,
                ),
            )
    if abs(change.scale - 1.0) > 0.25:
        return (
            Finding(
                code="implausible-scale",
                grade=Grade.DEGRADED,
                text=f"by the map before the points are {1.0 / change.scale:.2f} times as far "
                "apart",
                hint="if the camera was not moved, check the robot points' unit",
            ),
        )
    if abs(change.turn_deg) > _LIKELY_TURN_DEG:
        return (
            _bad(
                "turned-order",
                f"by the map before the pairs are turned by {change.turn_deg:.0f} deg: the picture "
                "points begin at another corner than the robot points",
                "begin both at the same corner; if the camera was turned round, take its old "
                "calibration out of force first",
                *pairs.labels,
            ),
        )
    return _odd_one_out(pairs, before_mm)


def _odd_one_out(pairs: Pairs, before_mm: Points) -> tuple[Finding, ...]:
    """Return the pair that departs from the map before while all others agree with it."""
    best: tuple[float, int, float] | None = None
    if misfit(before_mm, pairs.points_mm, is_mirrored=False).max() <= LEAST_MISTAKE_MM:
        return ()
    for index, label in enumerate(pairs.labels):
        others = pairs.without(index)
        seen = np.delete(before_mm, index, axis=0)
        change = similarity(seen, others.points_mm, is_mirrored=False)
        rest = float(distances(change(seen), others.points_mm).max())
        off = float(distances(change(before_mm[[index]]), pairs.points_mm[[index]])[0])
        if rest <= 0.5 * LEAST_MISTAKE_MM and off > LEAST_MISTAKE_MM and label:
            best = min(best or (rest, index, off), (rest, index, off))
    if best is None:
        return ()
    _, index, off = best
    return (
        _bad(
            "misplaced-pair",
            f"{pairs.labels[index]} lies {off:.1f} mm from where the others and the map before "
            "put it",
            "take this pair again",
            pairs.labels[index],
        ),
    )


def _bad(code: str, text: str, hint: str, *samples: str) -> Finding:
    return Finding(code=code, grade=Grade.BAD, text=text, hint=hint, samples=samples)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
