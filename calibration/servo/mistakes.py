"""Mistakes of measuring servos, told apart by what would put them right."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.servo.fitting import ServoFit, fit_servos
from calibration.servo.samples import JOINTS, MarkerNoise, Mount, Sight
from calibration.verdict import Finding, Grade
from cell.geometry import Pose
from cell.kinematics.lynx import LynxGeometry
from cell.kinematics.servo_map import Five

LIMIT: Final = 3.0
"""Noise this many times the stated one means that something else is wrong."""
_BETTER: Final = 4.0
_ENOUGH: Final = 40
"""How many sights tell a mistake."""
_STEPS: Final = 12
"""What needs more steps is not put right."""


@dataclass(frozen=True, slots=True)
class _Cure:
    code: str
    text: str
    hint: str
    apply: Callable[[Sight], Sight]


def named_mistake(
    sights: Sequence[Sight],
    geometry: LynxGeometry,
    mounts: Sequence[Mount],
    noise: MarkerNoise,
    found: ServoFit | None,
) -> Finding | None:
    """Return the mistake that explains why sights do not fit; None if none does.

    Args:
        sights: As they were given.
        geometry: The arm's lengths.
        mounts: How the markers sit on the hand.
        noise: How exactly a marker is seen.
        found: The fit of the sights as given; None if there was none.
    """
    before = float("inf") if found is None else found.noise_factor
    ranking: list[tuple[float, _Cure]] = []
    some = sights[:: max(1, len(sights) // _ENOUGH)]
    for cure in _CURES:
        cured = [cure.apply(sight) for sight in some]
        try:
            after = fit_servos(
                cured,
                geometry,
                mounts=mounts,
                noise=noise,
                knots=_few_knots(cured),
                steps=_STEPS,
                is_trial=True,
            )
        except FitFailed:
            continue
        ranking.append((after.noise_factor, cure))
    if not ranking:
        return None
    best, cure = min(ranking, key=lambda entry: entry[0])
    if best > LIMIT or best * _BETTER > before:
        return None
    words = "nothing can be fitted" if found is None else f"the noise is {before:.0f} times larger"
    return Finding(
        code=cure.code,
        grade=Grade.BAD,
        text=f"{cure.text}: as given {words}, put right the sights agree",
        hint=cure.hint,
    )


def _few_knots(sights: Sequence[Sight]) -> list[NDArray[np.float64]]:
    """Return three knots a joint: enough to tell a mistake from a bent servo."""
    commanded = np.array([sight.commanded_deg for sight in sights])
    return [np.linspace(column.min(), column.max() + 1e-3, 3) for column in commanded.T]


def _scaled(factor: float) -> Callable[[Sight], Sight]:
    def apply(sight: Sight) -> Sight:
        seen = sight.seen
        return replace(
            sight,
            seen=Pose(
                factor * seen.x_mm, factor * seen.y_mm, factor * seen.z_mm,
                seen.a_deg, seen.b_deg, seen.c_deg,
            ),
        )  # fmt: skip

    return apply


def _commanded(change: Callable[[list[float]], list[float]]) -> Callable[[Sight], Sight]:
    def apply(sight: Sight) -> Sight:
        a, b, c, d, e = change(list(sight.commanded_deg))
        commanded: Five = (a, b, c, d, e)
        return replace(sight, commanded_deg=commanded)

    return apply


def _turned_round(joint: int) -> Callable[[list[float]], list[float]]:
    def change(angles: list[float]) -> list[float]:
        return [-angle if i == joint else angle for i, angle in enumerate(angles)]

    return change


def _exchanged(first: int) -> Callable[[list[float]], list[float]]:
    def change(angles: list[float]) -> list[float]:
        angles[first], angles[first + 1] = angles[first + 1], angles[first]
        return angles

    return change


def _seen_in_radians(sight: Sight) -> Sight:
    seen = sight.seen
    a, b, c = (float(np.degrees(angle)) for angle in (seen.a_deg, seen.b_deg, seen.c_deg))
    return replace(sight, seen=Pose(seen.x_mm, seen.y_mm, seen.z_mm, a, b, c))


_CURES: Final = (
    _Cure("seen-in-cm", "the marker's places were given in cm", "give mm", _scaled(10.0)),
    _Cure("seen-in-m", "the marker's places were given in m", "give mm", _scaled(1000.0)),
    _Cure(
        "radians",
        "the commanded angles were given in radians",
        "give degrees",
        _commanded(lambda angles: [float(np.degrees(angle)) for angle in angles]),
    ),
    _Cure(
        "seen-in-radians",
        "the marker's turns were given in radians",
        "give degrees",
        _seen_in_radians,
    ),
    *(
        _Cure(
            f"reversed-{name}",
            f"{name} turns the other way than commanded",
            f"give us_per_unit of {name}'s servo the other sign, or its angles",
            _commanded(_turned_round(joint)),
        )
        for joint, name in enumerate(JOINTS)
    ),
    *(
        _Cure(
            f"swapped-{JOINTS[first]}-{JOINTS[first + 1]}",
            f"{JOINTS[first]} and {JOINTS[first + 1]} were exchanged",
            "check their plugs at the controller and the order of the angles",
            _commanded(_exchanged(first)),
        )
        for first in range(4)
    ),
)
