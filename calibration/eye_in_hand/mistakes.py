"""Mistakes of measuring an eye in hand, told apart by what would put them right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from calibration.errors import FitFailed
from calibration.eye_in_hand.refine import EyeFit, refine
from calibration.eye_in_hand.samples import Look, Samples, Touch
from calibration.eye_in_hand.two_stage import TwoStage
from calibration.statistics import region_factor
from calibration.verdict import Finding, Grade
from cell.geometry.eye_in_hand import EyeInHand, turned

LIMIT: Final = 3.0
"""Noise this many times the stated one means that something else is wrong."""
_BETTER: Final = 4.0
_PULSES: Final = (872.2222, 444.4444)
"""Pulses a degree of joints 1 and 2."""


@dataclass(frozen=True, slots=True)
class _Cure:
    code: str
    text: str
    hint: str
    apply: Callable[[Samples, EyeInHand], tuple[Samples, EyeInHand]]


def named_mistake(
    samples: Samples, eye: EyeInHand, found: EyeFit | None, height_mm: float = 0.0
) -> Finding | None:
    """Return the mistake that explains why samples do not fit; None if none does.

    Each mistake is undone in the samples and the fit made again; the one that helps most is
    named if it makes the noise four times smaller and believable.

    Args:
        samples: As they were given.
        eye: As it was known before.
        found: The fit of the samples as given; None if there was none.
        height_mm: Height of the point over the table.
    """
    noise = _noise(found)
    ranking = []
    for cure in _CURES:
        try:
            cured, other = cure.apply(samples, eye)
            after = refine(cured, other, height_mm=height_mm)
        except FitFailed:
            continue
        if found is not None and len(after.held) > len(found.held):
            continue
        ranking.append((_noise(after) + _strangeness(after, other), _noise(after), cure))
    ranking.sort(key=lambda entry: entry[0])
    if not ranking:
        return None
    _, best, cure = ranking[0]
    if best > LIMIT or best * _BETTER > noise:
        return None
    before = "nothing can be fitted" if found is None else f"the noise is {noise:.0f} times larger"
    return Finding(
        code=cure.code,
        grade=Grade.BAD,
        text=f"{cure.text}: as given {before}, put right the samples agree",
        hint=cure.hint,
    )


def strange_values(found: EyeFit, eye: EyeInHand) -> list[Finding]:
    """Return what the fitted values themselves give away."""
    fitted = found.eye
    scale = _scale_mistake(found, eye)
    if scale is not None:
        return [scale]
    findings = []
    swapped = abs(fitted.link_1_mm - eye.link_2_mm) < 0.1 * eye.link_2_mm
    if swapped and abs(fitted.link_1_mm - eye.link_1_mm) > 0.2 * eye.link_1_mm:
        findings.append(
            Finding(
                code="swapped-links",
                grade=Grade.BAD,
                text=f"link 1 comes out as {fitted.link_1_mm:.1f} mm where {eye.link_1_mm:g} mm "
                f"is given, which is the length given for link 2 ({eye.link_2_mm:g} mm)",
                hint="exchange the two lengths in link_mm of the profile and fit again",
            )
        )
    else:
        for name, value, known in (
            ("link 1", fitted.link_1_mm, eye.link_1_mm),
            ("link 2", fitted.link_2_mm, eye.link_2_mm),
        ):
            index = 3 if name == "link 1" else 4
            deviation = float(np.sqrt(found.covariance[index, index]))
            if abs(value - known) > 2.0 + 3.0 * deviation:
                findings.append(
                    Finding(
                        code="link-length",
                        grade=Grade.DEGRADED,
                        text=f"{name} comes out as {value:.1f} mm, {value - known:+.1f} mm from "
                        "what is given; the maker allows 1 mm",
                        hint="check the length given, the joints' zero, and the picture's scale",
                    )
                )
    if "angle_error" not in found.held and abs(fitted.angle_error_deg) > 45.0:
        findings.append(
            Finding(
                code="picture-turned",
                grade=Grade.BAD,
                text=f"the picture is turned by {fitted.angle_error_deg:.0f} deg against how the "
                "camera is meant to be mounted",
                hint="if the camera was mounted so, say so by setting it upright; else columns "
                "and rows were read from another corner",
            )
        )
    return findings


def _scale_mistake(found: EyeFit, eye: EyeInHand) -> Finding | None:
    """Return that both links come out by one factor too long: it is the picture's scale."""
    first = found.eye.link_1_mm / eye.link_1_mm
    second = first if "link_2" in found.held else found.eye.link_2_mm / eye.link_2_mm
    deviation = float(np.sqrt(found.covariance[3, 3])) / eye.link_1_mm
    is_common = 0.9 < second / first < 1.1
    if "link_1" in found.held or not is_common or abs(first - 1.0) < 0.01 + 3.0 * deviation:
        return None
    in_cm = 0.08 < first < 0.12
    return Finding(
        code="scale-in-cm" if in_cm else "picture-scale",
        grade=Grade.BAD,
        text=f"link 1 comes out as {found.eye.link_1_mm:.1f} mm where {eye.link_1_mm:g} mm is "
        f"given: the picture's scale ({eye.scale_u_mm:.4f} mm a pixel) is "
        + ("given in cm" if in_cm else f"{first:.3f} times what it should be"),
        hint="give mm a pixel"
        if in_cm
        else "measure the scale again: a known length on the "
        "table over its pixels; it changes with the camera's height",
    )


def reference_mistake(found: EyeFit, stages: TwoStage) -> Finding | None:
    """Return that the two-stage measurement and the looks put the reference point elsewhere."""
    eye = found.eye
    towards = np.radians(eye.b_angle_deg - 180.0)
    fitted = eye.d_t_c_mm * np.array([np.cos(towards), np.sin(towards)])
    away = stages.mean_mm - fitted
    slopes = np.array(
        [
            [np.cos(towards), -fitted[1] * np.pi / 180.0],
            [np.sin(towards), fitted[0] * np.pi / 180.0],
        ]
    )
    spread = stages.spread_mm if stages.freedom else 0.5
    spread = max(spread, 0.2)
    covariance = slopes @ found.covariance[:2, :2] @ slopes.T + np.eye(2) * spread**2 / len(
        stages.offsets_mm
    )
    distance = float(away @ np.linalg.solve(covariance, away))
    miss = float(np.hypot(*away))
    if miss < 1.0 or distance < region_factor(2, max(stages.freedom, 2), 0.99):
        return None
    ahead = turned(away, eye.angle_error_deg - 180.0)
    du, dv = ahead[0] / eye.scale_u_mm, -ahead[1] / eye.scale_v_mm
    u, v = eye.reference_px
    return Finding(
        code="wrong-reference-pixel",
        grade=Grade.BAD,
        text=f"the two-stage measurement and the looks differ by {miss:.1f} mm: in its first "
        f"stage the point lay at ({u + du:.0f}, {v + dv:.0f}) px, not at the reference pixel "
        f"({u:g}, {v:g})",
        hint="take the reference pixel of the profile for both, and measure the stages again",
    )


def _noise(found: EyeFit | None) -> float:
    return float("inf") if found is None else found.noise_factor


def _strangeness(found: EyeFit, eye: EyeInHand) -> float:
    """Return how little a fit looks like an arm: of two that fit equally the likelier counts."""
    fitted = found.eye
    turn = abs((fitted.angle_error_deg - eye.angle_error_deg + 180.0) % 360.0 - 180.0)
    return (
        turn / 30.0
        + abs(fitted.link_1_mm / eye.link_1_mm - 1.0) * 20.0
        + abs(fitted.link_2_mm / eye.link_2_mm - 1.0) * 20.0
    )


def _joints(change: Callable[[float, float], tuple[float, float]]) -> Callable[
    [Samples, EyeInHand], tuple[Samples, EyeInHand]
]:  # fmt: skip
    def look(one: Look) -> Look:
        j1, j2 = change(one.j1_deg, one.j2_deg)
        return replace(one, j1_deg=j1, j2_deg=j2)

    def touch(one: Touch) -> Touch:
        j1, j2 = change(one.j1_deg, one.j2_deg)
        return replace(one, j1_deg=j1, j2_deg=j2)

    def apply(samples: Samples, eye: EyeInHand) -> tuple[Samples, EyeInHand]:
        looks = tuple(look(one) for one in samples.looks)
        touches = tuple(touch(one) for one in samples.touches)
        return replace(samples, looks=looks, touches=touches), eye

    return apply


def _pixels(change: Callable[[float, float, EyeInHand], tuple[float, float]]) -> Callable[
    [Samples, EyeInHand], tuple[Samples, EyeInHand]
]:  # fmt: skip
    def look(one: Look, eye: EyeInHand) -> Look:
        u, v = change(one.u_px, one.v_px, eye)
        return replace(one, u_px=u, v_px=v)

    def apply(samples: Samples, eye: EyeInHand) -> tuple[Samples, EyeInHand]:
        return replace(samples, looks=tuple(look(one, eye) for one in samples.looks)), eye

    return apply


def _scaled(factor: Callable[[float], float]) -> Callable[
    [Samples, EyeInHand], tuple[Samples, EyeInHand]
]:  # fmt: skip
    def apply(samples: Samples, eye: EyeInHand) -> tuple[Samples, EyeInHand]:
        return samples, replace(
            eye, scale_u_mm=factor(eye.scale_u_mm), scale_v_mm=factor(eye.scale_v_mm)
        )

    return apply


_CURES: Final = (
    _Cure(
        "radians",
        "the joint angles were given in radians",
        "give degrees",
        _joints(lambda a, b: (float(np.degrees(a)), float(np.degrees(b)))),
    ),
    _Cure(
        "pulses",
        "the joint angles were given in the controller's pulses",
        "divide by 872.2222 (joint 1) and 444.4444 (joint 2)",
        _joints(lambda a, b: (a / _PULSES[0], b / _PULSES[1])),
    ),
    _Cure(
        "swapped-joints",
        "joint 1 and joint 2 were exchanged",
        "give joint 1 first",
        _joints(lambda a, b: (b, a)),
    ),
    _Cure(
        "joint-2-absolute",
        "joint 2 was given as its direction in the robot frame, J1 + J2",
        "give its angle against link 1",
        _joints(lambda a, b: (a, b - a)),
    ),
    _Cure(
        "mirrored-columns",
        "the picture is mirrored left to right",
        "switch the mirroring off, or count columns from the left",
        _pixels(lambda u, v, eye: (2.0 * eye.centre_px[0] - u, v)),
    ),
    _Cure(
        "mirrored-rows",
        "the picture's rows were counted from the bottom",
        "count rows downwards from the top",
        _pixels(lambda u, v, eye: (u, 2.0 * eye.centre_px[1] - v)),
    ),
    _Cure(
        "swapped-columns-rows",
        "column and row were exchanged",
        "give the column first",
        _pixels(lambda u, v, eye: (v, u)),
    ),
    _Cure(
        "scale-in-cm",
        "the picture's scale was given in cm a pixel",
        "give mm a pixel",
        _scaled(lambda scale: 10.0 * scale),
    ),
    _Cure(
        "scale-upside-down",
        "the picture's scale was given in pixels a mm",
        "give mm a pixel, such as 1/3.56",
        _scaled(lambda scale: 1.0 / scale),
    ),
)
