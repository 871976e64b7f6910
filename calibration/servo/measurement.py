"""From sights of a marker to a measurement of servo maps and sag that can be kept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.errors import FitFailed
from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.servo.fitting import SAG_NAMES, ServoFit, ServoModel, fit_servos
from calibration.servo.judge import Residues, gripper_deviation, next_pose, play_findings, residues
from calibration.servo.mistakes import LIMIT, named_mistake
from calibration.servo.samples import BACK, JOINTS, TOP, MarkerNoise, Mount, Sight
from calibration.statistics import strong_correlations
from calibration.verdict import Finding, Grade
from cell.kinematics.lynx import LynxArm
from cell.kinematics.servo_map import ArmCorrection

KIND = "servo-maps"
_MOST_OUTLIERS = 0.1
_WIDE_DEG = 1.0
SIGHTS_FOR_REGION = 45
"""With fewer sights the fit bends more than its linear regions know: of 1,000 synthetic
calibrations they hold 94 to 96 % with 45 sights, 942 with 40, 923 with 32."""

Array = NDArray[np.float64]


def measure_servos(
    sights: Sequence[Sight],
    arm: LynxArm,
    *,
    fresh: Sequence[Sight] = (),
    mounts: Sequence[Mount] = (BACK, TOP),
    noise: MarkerNoise | None = None,
) -> Measurement:
    """Fit servo maps and sag, and judge them.

    Args:
        sights: Poses of the arm as the camera saw the marker.
        arm: Its lengths and limits.
        fresh: Sights that are not fitted on but check the fit.
        mounts: How the markers sit on the hand.
        noise: How exactly a marker is seen.

    Raises:
        FitFailed: The sights tell too little, and no mistake explains it.
    """
    noise = noise or MarkerNoise()
    method = (
        f"maps of five servos and sag together from {len(sights)} sights of a marker, monotone "
        "cubics"
    )
    try:
        plain = fit_servos(sights, arm.geometry, mounts=mounts, noise=noise)
    except FitFailed:
        mistake = named_mistake(sights, arm.geometry, mounts, noise, None)
        if mistake is None:
            raise
        return Measurement(kind=KIND, subject="arm", method=method, findings=(mistake,))
    if plain.noise_factor > LIMIT:
        mistake = named_mistake(sights, arm.geometry, mounts, noise, plain)
        if mistake is not None:
            return Measurement(kind=KIND, subject="arm", method=method, findings=(mistake,))
    used, dropped, found = _cleaned(list(sights), arm, mounts, noise, plain)
    model = ServoModel(used, arm.geometry, mounts, noise, found.knots_deg)
    left = residues(found, model, noise)
    checks = _check_mm(found, fresh, arm, mounts, noise)
    findings = [*_findings(found, dropped, arm), *play_findings(found, model, used, noise)]
    is_bad = any(finding.grade is Grade.BAD for finding in findings)
    has_region = len(used) >= SIGHTS_FOR_REGION
    if not has_region:
        findings.append(_few_sights(len(used)))
    return Measurement(
        kind=KIND,
        subject="arm",
        method=method,
        samples=_samples(used, left, dropped, fresh, checks),
        parameters=_parameters(found, has_region=has_region),
        covariance=tuple(tuple(float(v) for v in row) for row in found.covariance)
        if has_region
        else (),
        correlations=tuple(
            Correlation(first=a, second=b, value=value)
            for a, b, value in strong_correlations(found.covariance, _names(found))
        ),
        accuracy=_accuracy(found, left, checks, used, arm, has_region=has_region),
        region=Region(text=_region(found)),
        findings=tuple(findings),
        values={} if is_bad else {"arm.correction": correction_value(found.correction)},
        details={
            "uncorrected_rms_mm": _rms(left.uncorrected_mm),
            "noise_factor": found.noise_factor,
            "freedom": found.freedom,
            "held": list(found.held),
            "pointwise_band_deg": [found.band_deg(i).tolist() for i in range(5)]
            if has_region
            else None,
            "simultaneous_band_deg": [found.simultaneous_band_deg(i).tolist() for i in range(5)]
            if has_region
            else None,
        },
        not_known=_not_known(found, sights, has_region=has_region),
    )


def correction_value(correction: ArmCorrection) -> JsonValue:
    """Return a correction as the profile keeps it."""
    sag = correction.sag
    return {
        "maps_deg": [[list(pair) for pair in servo.knots_deg] for servo in correction.maps],
        "sag": {
            "shoulder_deg": sag.shoulder_deg,
            "elbow_deg": sag.elbow_deg,
            "wrist_deg": sag.wrist_deg,
            "hand_share": sag.hand_share,
        },
    }


def _cleaned(
    used: list[Sight], arm: LynxArm, mounts: Sequence[Mount], noise: MarkerNoise, found: ServoFit
) -> tuple[list[Sight], list[tuple[Sight, float]], ServoFit]:
    """Return the sights that belong together, those that do not with their distance, the fit."""
    dropped: list[tuple[Sight, float]] = []
    most = int(_MOST_OUTLIERS * len(used))
    while len(dropped) < most:
        model = ServoModel(used, arm.geometry, mounts, noise, found.knots_deg)
        left = residues(found, model, noise)
        if left.worst is None:
            break
        rest = [sight for index, sight in enumerate(used) if index != left.worst]
        try:
            after = fit_servos(rest, arm.geometry, mounts=mounts, noise=noise)
        except FitFailed:
            break
        dropped.append((used[left.worst], float(left.left_out_mm[left.worst])))
        used, found = rest, after
    return used, dropped, found


def _findings(
    found: ServoFit, dropped: Sequence[tuple[Sight, float]], arm: LynxArm
) -> list[Finding]:
    findings = []
    if found.noise_factor > LIMIT:
        findings.append(
            Finding(
                code="sights-disagree",
                grade=Grade.BAD,
                text=f"the sights scatter {found.noise_factor:.1f} times as much as stated, and "
                "no single mistake explains it",
                hint="check that marker and camera sit firmly, their places in the hand and in "
                "the robot frame, and the arm's lengths",
            )
        )
    findings += [
        Finding(
            code="sight-apart",
            grade=Grade.DEGRADED,
            text=f"{sight.label} lies apart from what the other sights say, {distance:.1f} mm in "
            "x and y or by its height or turn; it was left out",
            hint="take it again: the arm may still have moved, or a figure was mistyped",
            samples=(sight.label,),
        )
        for sight, distance in dropped
    ]
    findings += [
        Finding(
            code="flat-map",
            grade=Grade.DEGRADED,
            text=f"{joint} hardly moves over a part of its commands",
            hint="the servo may stand against a stop there: narrow its limits",
        )
        for joint in found.flat
    ]
    if found.held:
        figures = ", ".join(found.held)
        findings.append(
            Finding(
                code="sag-not-seen",
                grade=Grade.DEGRADED,
                text=f"the sights do not tell these figures of sag: {figures}",
                hint="take poses with the same angle of a joint and another reach: elbow bent, "
                "elbow stretched, hand level, hand down",
            )
        )
    return findings + _wide_findings(found, arm)


def _few_sights(count: int) -> Finding:
    return Finding(
        code="few-sights",
        grade=Grade.DEGRADED,
        text=f"{count} sights are too few to state how exactly each servo is known; "
        f"{SIGHTS_FOR_REGION} are enough",
        hint="take more poses; the figure of the sights that were left out holds nonetheless",
    )


def _wide_findings(found: ServoFit, arm: LynxArm) -> list[Finding]:
    wide = []
    for joint, name in enumerate(JOINTS):
        band = found.band_deg(joint)
        worst = int(band.argmax())
        if band[worst] > _WIDE_DEG:
            wide.append((name, float(found.knots_deg[joint][worst]), float(band[worst])))
    if not wide:
        return []
    name, angle, half = max(wide, key=lambda entry: entry[2])
    best = next_pose(found, arm)
    hint = "take more sights"
    if best is not None:
        words = ", ".join(f"{value:.0f}" for value in best[0])
        hint += f", the next with the joints commanded to ({words}) deg"
    return [
        Finding(
            code="wide-band",
            grade=Grade.DEGRADED,
            text=f"{name} commanded to {angle:.0f} deg is known to ± {half:.1f} deg only (95 %)",
            hint=hint,
        )
    ]


def _check_mm(
    found: ServoFit,
    fresh: Sequence[Sight],
    arm: LynxArm,
    mounts: Sequence[Mount],
    noise: MarkerNoise,
) -> Array:
    """Return how far in x and y fresh sights lie from what is predicted of them."""
    if not fresh:
        return np.empty(0)
    model = ServoModel(fresh, arm.geometry, mounts, noise, found.knots_deg)
    off = model.six(found.parameters)
    return np.hypot(off[:, 0], off[:, 1])


def _accuracy(
    found: ServoFit,
    left: Residues,
    checks: Array,
    used: Sequence[Sight],
    arm: LynxArm,
    *,
    has_region: bool,
) -> Accuracy:
    held = checks if checks.size else left.left_out_mm
    commanded = np.array([sight.commanded_deg for sight in used])
    predicted = gripper_deviation(found, commanded, arm.geometry)
    return Accuracy(
        fit_rms=_rms(left.inside_mm),
        held_out_rms=_rms(held),
        held_out_max=float(held.max()),
        held_out_count=int(held.size),
        how=(f"{checks.size} fresh sights" if checks.size else "leave-one-out")
        + " of the marker in x and y, the camera's noise included",
        predicted_rms=_rms(predicted) if has_region else None,
        predicted_max=float(2.0 * predicted.max()) if has_region else None,
    )


def _samples(
    used: Sequence[Sight],
    left: Residues,
    dropped: Sequence[tuple[Sight, float]],
    fresh: Sequence[Sight],
    checks: Array,
) -> tuple[Sample, ...]:
    rows = [
        _sample(
            sight,
            residual_mm=float(left.inside_mm[index]),
            held_out_mm=float(left.left_out_mm[index]),
        )
        for index, sight in enumerate(used)
    ]
    rows += [_sample(sight, held_out_mm=apart) for sight, apart in dropped]
    rows += [_sample(sight, held_out_mm=float(checks[index])) for index, sight in enumerate(fresh)]
    return tuple(rows)


def _sample(sight: Sight, *, held_out_mm: float, residual_mm: float | None = None) -> Sample:
    seen = sight.seen
    return Sample(
        label=sight.label,
        given=sight.commanded_deg,
        measured=(seen.x_mm, seen.y_mm, seen.z_mm, seen.a_deg, seen.b_deg, seen.c_deg),
        residual_mm=residual_mm,
        held_out_mm=held_out_mm,
        is_used=residual_mm is not None,
    )


def _names(found: ServoFit) -> tuple[str, ...]:
    knots = [
        f"{name} at {angle:.1f} deg"
        for name, angles in zip(JOINTS, found.knots_deg, strict=True)
        for angle in angles
    ]
    return (*knots, *(f"sag of the {name}" if i < 3 else name for i, name in enumerate(SAG_NAMES)))


def _parameters(found: ServoFit, *, has_region: bool) -> tuple[Parameter, ...]:
    deviation = np.sqrt(np.diag(found.covariance))
    names = _names(found)
    free = set(found.free.tolist())
    return tuple(
        Parameter(
            name=name,
            value=float(found.parameters[index]),
            unit="" if index == len(names) - 1 else "deg",
            deviation=float(deviation[index]) if has_region and index in free else None,
        )
        for index, name in enumerate(names)
    )


def _region(found: ServoFit) -> str:
    spans = (
        f"{name} {knots[0]:.0f} to {knots[-1]:.0f}"
        for name, knots in zip(JOINTS, found.knots_deg, strict=True)
    )
    return f"commanded angles: {', '.join(spans)} deg; with the fingers' load as measured"


def _not_known(found: ServoFit, sights: Sequence[Sight], *, has_region: bool) -> tuple[str, ...]:
    said = [
        "the sag with another load in the fingers than while it was measured",
        "the upper arm's own sag apart from J2's map, in which it is contained",
        "errors of the markers' places in the hand and of the arm's lengths: they are taken as "
        "given and would be fitted as turns of the joints",
    ]
    if not has_region:
        said.append(
            f"how exactly maps and sag are known: only {SIGHTS_FOR_REGION} sights or more tell"
        )
    if not any(sight.came_from for sight in sights):
        said.append("the play of the gears: from which side the joints came was not noted")
    said += [f"sag: {name} was not measured" for name in found.held]
    return tuple(said)


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))
