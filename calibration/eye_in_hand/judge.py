"""How good a refined eye in hand is: held-out looks, a look that does not belong, weak ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.eye_in_hand.guidance import Reach, gripping_joints, next_look
from calibration.eye_in_hand.refine import NAMES, UNITS, EyeFit, refine
from calibration.eye_in_hand.samples import Look, Samples, Touch
from calibration.statistics import f_quantile
from calibration.verdict import Finding, Grade
from cell.geometry.eye_in_hand import EyeInHand

Array = NDArray[np.float64]

TOLERANCE: Final = (0.5, 0.5, 0.5, 1.0, 1.0)
"""Standard deviation (mm, deg) above which a parameter counts as weakly seen."""
_FALSE_ALARMS: Final = 0.01
_MOST_OUTLIERS: Final = 0.2
_SHOWS: Final = (
    "turn joints 1 and 2 more between looks, so that J1 + J2 changes",
    "turn joints 1 and 2 more between looks, so that J1 + J2 changes",
    "let the point fall on pixels that lie farther apart, near all edges of the picture",
    "turn joint 2 more between looks",
    "drive the gripper over the point and note the joints, two or three times",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fresh:
    """A point that was not fitted on, seen and then met by the gripper.

    Attributes:
        look: The point as it was seen.
        touch: The gripper over it.
    """

    look: Look
    touch: Touch


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cleaned:
    """A fit without the looks that do not belong.

    Attributes:
        fit: The fit of the others.
        used: What it was made from.
        outliers: Looks left out, with their distances in mm from the fit without them.
    """

    fit: EyeFit
    used: Samples
    outliers: tuple[tuple[Look, float], ...]


def cleaned_fit(samples: Samples, eye: EyeInHand, *, height_mm: float = 0.0) -> Cleaned:
    """Fit, leaving out one after the other the looks that the rest does not believe.

    A look is left out if its distance from the fit of the others, in their noise, is larger
    than one look in a hundred fits would have by chance.
    """
    used = samples
    outliers: list[tuple[Look, float]] = []
    found = refine(used, eye, height_mm=height_mm)
    most = int(_MOST_OUTLIERS * len(samples.looks))
    while len(outliers) < most:
        worst = _worst_look(found, len(used.looks))
        if worst is None:
            break
        rest = replace(used, looks=used.looks[:worst] + used.looks[worst + 1 :])
        try:
            without = refine(rest, eye, height_mm=height_mm)
        except FitFailed:
            break
        if len(without.held) > len(found.held):
            break
        look = used.looks[worst]
        outliers.append((look, _distance_mm(without, look, height_mm)))
        used, found = rest, without
    return Cleaned(fit=found, used=used, outliers=tuple(outliers))


def held_out_mm(found: EyeFit, looks: int) -> Array:
    """Return how far each look lies from a fit without it, in mm on the table, shape (looks,).

    By the leverage of each look (exact for a linear model; its curvature is far below the
    noise here).
    """
    left_out = _left_out(found, looks)
    distance: Array = np.hypot(*(left_out * found.look_unit_mm).T)
    return distance


def fitted_mm(found: EyeFit, looks: int) -> Array:
    """Return how far right and above each look lies from the fit, in mm, shape (looks, 2)."""
    return found.fit.residuals[: 2 * looks].reshape(-1, 2) * found.look_unit_mm


def miss_mm(eye: EyeInHand, fresh: Fresh, *, height_mm: float = 0.0) -> float:
    """Return how far the gripper would miss a fresh point that it was shown."""
    look, touch = fresh.look, fresh.touch
    seen = eye.places(
        np.array([look.u_px, look.v_px]),
        np.array([look.j1_deg, look.j2_deg]),
        height_mm=height_mm,
    )
    return float(np.hypot(*(seen - eye.gripper(np.array([touch.j1_deg, touch.j2_deg])))))


def outlier_findings(outliers: Sequence[tuple[Look, float]]) -> list[Finding]:
    """Return one finding a look that does not belong."""
    return [
        Finding(
            code="look-apart",
            grade=Grade.DEGRADED,
            text=f"{look.label} at ({look.u_px:.0f}, {look.v_px:.0f}) px, joints "
            f"({look.j1_deg:.1f}, {look.j2_deg:.1f}) deg lies {distance:.1f} mm from what the "
            "other looks say; it was left out",
            hint="take it again: the point may have been moved or mistaken, or a figure mistyped",
            samples=(look.label,),
        )
        for look, distance in outliers
    ]


def weakness_findings(found: EyeFit, samples: Samples, reach: Reach) -> list[Finding]:
    """Return what the samples do not tell or hardly tell, and which look would."""
    findings = []
    deviation = np.sqrt(np.diag(found.covariance))
    for index, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True)):
        if name in found.held:
            value = found.parameters[index]
            findings.append(
                Finding(
                    code="not-seen",
                    grade=Grade.DEGRADED,
                    text=f"the samples say nothing about {name}; it is held at {value:g} {unit}",
                    hint=_SHOWS[index],
                )
            )
        elif deviation[index] > TOLERANCE[index]:
            findings.append(
                Finding(
                    code="weakly-seen",
                    grade=Grade.DEGRADED,
                    text=f"{name} is known to ± {2.0 * deviation[index]:.2f} {unit} only (95 %)",
                    hint=_SHOWS[index] + _next_words(found, samples, reach),
                )
            )
    return findings


def point_guess(eye: EyeInHand, touch: Touch) -> tuple[float, float]:
    """Return where the gripper stood."""
    x, y = eye.gripper(np.array([touch.j1_deg, touch.j2_deg]))
    return float(x), float(y)


def _next_words(found: EyeFit, samples: Samples, reach: Reach) -> str:
    best = next_look(found, reach, samples.noise)
    if best is None or best.gain < 0.05:
        over = gripping_joints(found.eye, found.point_mm)
        return "" if over is None else "; another touch of the point helps most"
    return (
        f"; the best next look is from joints ({best.j1_deg:.0f}, {best.j2_deg:.0f}) deg, where "
        f"the point will appear near ({best.u_px:.0f}, {best.v_px:.0f}) px"
    )


def _left_out(found: EyeFit, looks: int) -> Array:
    """Return residuals (looks, 2) against fits without each look, in standard deviations."""
    slopes = found.fit.jacobian[: 2 * looks].reshape(looks, 2, -1)
    inverse = np.linalg.inv(found.information)
    rest = np.eye(2) - np.einsum("nij,jk,nlk->nil", slopes, inverse, slopes)
    residuals = found.fit.residuals[: 2 * looks].reshape(looks, 2)
    solved: Array = np.linalg.solve(rest, residuals[..., None])[..., 0]
    return solved


def _worst_look(found: EyeFit, looks: int) -> int | None:
    freedom = found.fit.freedom - 2
    if freedom < 3:
        return None
    residuals = found.fit.residuals[: 2 * looks].reshape(looks, 2)
    square = np.einsum("ni,ni->n", residuals, _left_out(found, looks))
    rest = np.maximum(float(found.fit.residuals @ found.fit.residuals) - square, 1e-12) / freedom
    ratio = square / (2.0 * rest)
    worst = int(ratio.argmax())
    limit = f_quantile(1.0 - _FALSE_ALARMS / looks, 2, freedom)
    return worst if ratio[worst] > limit else None


def _distance_mm(found: EyeFit, look: Look, height_mm: float) -> float:
    place = found.eye.places(
        np.array([look.u_px, look.v_px]),
        np.array([look.j1_deg, look.j2_deg]),
        height_mm=height_mm,
    )
    return float(np.hypot(*(place - np.array(found.point_mm))))
