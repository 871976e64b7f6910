"""From the samples of an eye in hand to a measurement that can be kept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic import JsonValue

from calibration.errors import FitFailed
from calibration.eye_in_hand.guidance import Reach, predicted_miss
from calibration.eye_in_hand.judge import (
    Cleaned,
    Fresh,
    cleaned_fit,
    fitted_mm,
    held_out_mm,
    miss_mm,
    outlier_findings,
    weakness_findings,
)
from calibration.eye_in_hand.mistakes import (
    LIMIT,
    named_mistake,
    reference_mistake,
    strange_values,
)
from calibration.eye_in_hand.refine import NAMES, UNITS, EyeFit, refine
from calibration.eye_in_hand.samples import Look, Samples, Stages, Touch
from calibration.eye_in_hand.two_stage import TwoStage, two_stage
from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.statistics import strong_correlations
from calibration.verdict import Finding, Grade
from cell.geometry.eye_in_hand import EyeInHand

KIND = "eye-in-hand"
_GRIP_MM = 2.0
"""Larger misses of the gripper do not pick an IC reliably."""


def measure_eye_in_hand(
    samples: Samples,
    stages: Sequence[Stages],
    fresh: Sequence[Fresh],
    eye: EyeInHand,
    *,
    reach: Reach | None = None,
    height_mm: float = 0.0,
) -> Measurement:
    """Fit an eye in hand from both stages' measurements and judge it.

    Args:
        samples: Looks at a point, touches of it, looks at an edge.
        stages: Two-stage measurements; they are not fitted on but check the fit.
        fresh: Points that were seen and met with the gripper, not fitted on.
        eye: What was known before.
        reach: Where the joints may stand.
        height_mm: Height of the points over the table.

    Raises:
        FitFailed: The samples tell too little, and no mistake explains it.
    """
    first = two_stage(stages, eye) if stages else None
    try:
        cleaned = cleaned_fit(samples, eye, height_mm=height_mm)
    except FitFailed:
        mistake = named_mistake(samples, eye, None, height_mm)
        if mistake is None:
            raise
        return Measurement(
            kind=KIND, subject="arm", method=_method(samples, stages), findings=(mistake,)
        )
    mistake = _mistake(samples, eye, height_mm)
    if mistake is not None:
        cleaned = Cleaned(fit=refine(samples, eye, height_mm=height_mm), used=samples, outliers=())
    found = cleaned.fit
    findings = _findings(cleaned, mistake, first, eye, reach or Reach())
    misses = [miss_mm(found.eye, one, height_mm=height_mm) for one in fresh]
    misses += [miss_mm(found.eye, one) for one in _as_fresh(stages, found.eye)]
    accuracy = _accuracy(found, cleaned, misses, bool(stages), len(fresh))
    findings += _miss_findings(misses)
    is_bad = any(one.grade is Grade.BAD for one in findings)
    return Measurement(
        kind=KIND,
        subject="arm",
        method=_method(samples, stages),
        samples=_samples(samples, cleaned, stages, fresh, misses),
        parameters=_parameters(found),
        covariance=tuple(tuple(float(v) for v in row) for row in found.covariance),
        correlations=tuple(
            Correlation(first=a, second=b, value=value)
            for a, b, value in strong_correlations(found.covariance, NAMES)
        ),
        accuracy=accuracy,
        region=Region(
            text="objects in the picture, with the arm where the point was looked at; "
            f"J1 {_span(samples, 0)} deg, J2 {_span(samples, 1)} deg"
        ),
        findings=tuple(findings),
        values={} if is_bad else eye_values(found.eye),
        details=_details(found, first),
        not_known=_not_known(samples, found, misses),
    )


def eye_values(eye: EyeInHand) -> dict[str, JsonValue]:
    """Return what an eye in hand sets in the profile."""
    return {
        "arm.link_mm": [eye.link_1_mm, eye.link_2_mm],
        "arm.eye_in_hand": {
            "scale_mm": [eye.scale_u_mm, eye.scale_v_mm],
            "reference_px": list(eye.reference_px),
            "centre_px": list(eye.centre_px),
            "camera_height_mm": eye.camera_height_mm,
            "face_height_mm": eye.face_height_mm,
            "d_t_c_mm": eye.d_t_c_mm,
            "b_angle_deg": eye.b_angle_deg,
            "angle_error_deg": eye.angle_error_deg,
        },
    }


def _mistake(samples: Samples, eye: EyeInHand, height_mm: float) -> Finding | None:
    plain = refine(samples, eye, height_mm=height_mm)
    if plain.noise_factor <= LIMIT and len(plain.held) < 2:
        return None
    return named_mistake(samples, eye, plain, height_mm)


def _findings(
    cleaned: Cleaned,
    mistake: Finding | None,
    first: TwoStage | None,
    eye: EyeInHand,
    reach: Reach,
) -> list[Finding]:
    found = cleaned.fit
    if mistake is not None:
        return [mistake]
    findings = strange_values(found, eye)
    if found.noise_factor > LIMIT:
        worst = held_out_mm(found, len(cleaned.used.looks)).max()
        findings.append(
            Finding(
                code="looks-disagree",
                grade=Grade.BAD,
                text=f"the looks scatter {found.noise_factor:.1f} times as much as stated, up to "
                f"{worst:.1f} mm from a fit of the others, and no single mistake explains it",
                hint="check that the point did not move and the camera sits firmly",
            )
        )
    if first is not None and "d_t_c" not in found.held and not findings:
        wrong = reference_mistake(found, first)
        findings += [] if wrong is None else [wrong]
    findings += outlier_findings(cleaned.outliers)
    return findings + weakness_findings(found, cleaned.used, reach)


def _miss_findings(misses: Sequence[float]) -> list[Finding]:
    if not misses or max(misses) <= _GRIP_MM:
        return []
    return [
        Finding(
            code="gripper-misses",
            grade=Grade.DEGRADED,
            text=f"at points that were not fitted on, the gripper misses by up to "
            f"{max(misses):.1f} mm; more than {_GRIP_MM:g} mm does not grip reliably",
            hint="take more looks and touches, and check the touches of the fresh points",
        )
    ]


def _accuracy(
    found: EyeFit, cleaned: Cleaned, misses: Sequence[float], has_stages: bool, fresh: int
) -> Accuracy:
    count = len(cleaned.used.looks)
    predicted_rms, predicted_max = predicted_miss(found)
    left_out = held_out_mm(found, count)
    held = np.array(misses) if misses else left_out
    if misses:
        stage_words = f"{len(misses) - fresh} two-stage pairs" if has_stages else ""
        fresh_words = f"{fresh} fresh points" if fresh else ""
        how = " and ".join(word for word in (fresh_words, stage_words) if word)
        how = f"gripper against seen point: {how}"
    else:
        how = "leave-one-out of the looks"
    return Accuracy(
        fit_rms=float(np.sqrt((fitted_mm(found, count) ** 2).sum(axis=1).mean())),
        held_out_rms=float(np.sqrt((held**2).mean())),
        held_out_max=float(held.max()),
        held_out_count=len(held),
        how=how,
        predicted_rms=None if np.isnan(predicted_rms) else predicted_rms,
        predicted_max=None if np.isnan(predicted_max) else predicted_max,
    )


def _as_fresh(stages: Sequence[Stages], eye: EyeInHand) -> list[Fresh]:
    """Return two-stage measurements as points seen on the reference pixel, at table height."""
    u, v = eye.reference_px
    return [
        Fresh(
            look=Look(
                label=one.label, u_px=u, v_px=v, j1_deg=one.seen_deg[0], j2_deg=one.seen_deg[1]
            ),
            touch=Touch(label=one.label, j1_deg=one.over_deg[0], j2_deg=one.over_deg[1]),
        )
        for one in stages
    ]


def _samples(
    samples: Samples,
    cleaned: Cleaned,
    stages: Sequence[Stages],
    fresh: Sequence[Fresh],
    misses: Sequence[float],
) -> tuple[Sample, ...]:
    found, used = cleaned.fit, cleaned.used.looks
    inside = fitted_mm(found, len(used))
    left_out = held_out_mm(found, len(used))
    far = {look.label: distance for look, distance in cleaned.outliers}
    rows = []
    for look in samples.looks:
        index = used.index(look) if look in used else None
        rows.append(
            Sample(
                label=look.label,
                given=(look.j1_deg, look.j2_deg),
                measured=(look.u_px, look.v_px),
                residual=() if index is None else tuple(float(v) for v in inside[index]),
                residual_mm=far[look.label] if index is None else float(np.hypot(*inside[index])),
                held_out_mm=far[look.label] if index is None else float(left_out[index]),
                is_used=index is not None,
            )
        )
    first = 2 * len(used)
    for number, touch in enumerate(samples.touches):
        pair = found.fit.residuals[first + 2 * number : first + 2 * number + 2]
        off = pair * samples.noise.touch_mm
        rows.append(
            Sample(
                label=touch.label,
                given=(touch.j1_deg, touch.j2_deg),
                residual=tuple(float(v) for v in off),
                residual_mm=float(np.hypot(*off)),
            )
        )
    rows += [
        Sample(
            label=line.label,
            given=(line.j1_deg, line.j2_deg)
            + (() if line.direction_deg is None else (line.direction_deg,)),
            measured=(line.alpha_deg,),
        )
        for line in samples.lines
    ]
    checks = [*fresh, *_as_fresh(stages, found.eye)]
    rows += [
        Sample(
            label=check.look.label,
            given=(check.look.j1_deg, check.look.j2_deg, check.touch.j1_deg, check.touch.j2_deg),
            measured=(check.look.u_px, check.look.v_px),
            held_out_mm=miss,
            is_used=False,
        )
        for check, miss in zip(checks, misses, strict=True)
    ]
    return tuple(rows)


def _parameters(found: EyeFit) -> tuple[Parameter, ...]:
    deviation = np.sqrt(np.diag(found.covariance))
    return tuple(
        Parameter(
            name=name,
            value=float(found.parameters[index]),
            unit=UNITS[index],
            deviation=None if name in found.held else float(deviation[index]),
        )
        for index, name in enumerate(NAMES)
    )


def _details(found: EyeFit, first: TwoStage | None) -> dict[str, JsonValue]:
    details: dict[str, JsonValue] = {
        "point_mm": list(found.point_mm),
        "freedom": found.fit.freedom,
        "noise_factor": found.noise_factor,
        "held": list(found.held),
    }
    if first is not None:
        details["two_stage"] = {
            "d_t_c_mm": first.d_t_c_mm,
            "b_angle_deg": first.b_angle_deg,
            "spread_mm": None if first.freedom == 0 else first.spread_mm,
            "pairs": len(first.offsets_mm),
        }
    return details


def _not_known(samples: Samples, found: EyeFit, misses: Sequence[float]) -> tuple[str, ...]:
    said = [f"{name} was not measured; the value known before was kept" for name in found.held]
    if not misses:
        said.append("how far the gripper misses: no point was both seen and met by it")
    if samples.lines and all(line.direction_deg is None for line in samples.lines):
        said.append(
            "what the edge says of angle_error: its own direction is not known, so its looks "
            "only confirm that the arm's angles are true"
        )
    said.append("whether the camera's height, so the picture's scale, changes over the table")
    return tuple(said)


def _method(samples: Samples, stages: Sequence[Stages]) -> str:
    return (
        f"{len(stages)} two-stage measurements, then five parameters together from "
        f"{len(samples.looks)} looks at a point, {len(samples.touches)} touches of it and "
        f"{len(samples.lines)} looks at an edge"
    )


def _span(samples: Samples, joint: int) -> str:
    values = samples.look_joints[:, joint]
    return f"{values.min():.0f} to {values.max():.0f}"
