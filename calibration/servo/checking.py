"""Whether servos still go where their maps tell, at fresh poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.servo.chain import MarkerChain, rotations_of, turn_between
from calibration.servo.samples import JOINTS, MarkerNoise, Mount, Sight
from calibration.verdict import Finding, Grade
from cell.kinematics.lynx import LynxGeometry
from cell.kinematics.servo_map import ArmCorrection
from cell.profile.lynx import LynxCorrectionProfile

Array = NDArray[np.float64]

LIMIT_MM: Final = 2.0
_BAD: Final = 2.0
_EXPLAINED: Final = 0.15
"""Share of the squares that may be left where one joint explains the misses."""
_NOISE: Final = 2.0
"""Mean square, in the stated noise, that is taken for noise and the maps' own errors."""
_LEAST: Final = 3
_SLIPPED_DEG: Final = 1.0


def correction_of(record: CalibrationRecord) -> ArmCorrection:
    """Return the servo maps that a record sets.

    Raises:
        CalibrationError: It sets none.
    """
    value = record.values.get("arm.correction")
    if value is None:
        raise CalibrationError(f"calibration {record.identity[:8]} holds no servo maps to check")
    return ArmCorrection.from_profile(LynxCorrectionProfile.model_validate(value))


def checked(
    record: CalibrationRecord,
    geometry: LynxGeometry,
    sights: Sequence[Sight],
    mounts: Sequence[Mount],
    noise: MarkerNoise,
    limit_mm: float,
) -> Measurement:
    """Return how far from where the maps put it a marker is seen.

    Args:
        record: The calibration.
        geometry: The arm's lengths.
        sights: Fresh poses.
        mounts: How the markers sit on the hand.
        noise: How exactly a marker is seen.
        limit_mm: Misses in x and y up to this are good.

    Raises:
        CalibrationError: The record holds no servo maps.
    """
    correction = correction_of(record)
    frames = {mount.name: mount.tool_from_marker for mount in mounts}
    chain = MarkerChain(geometry, [frames[sight.mount] for sight in sights])
    reached = correction.reached_all(np.array([sight.commanded_deg for sight in sights]))
    places, rotations, slopes = chain.places(reached)
    seen = np.array([(s.seen.x_mm, s.seen.y_mm, s.seen.z_mm) for s in sights])
    turns = turn_between(rotations_of([sight.seen for sight in sights]), rotations)
    misses = np.concatenate([seen - places, turns], axis=1)
    off = np.hypot(misses[:, 0], misses[:, 1])
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the servo maps of {record.identity[:8]} held against {len(sights)} fresh poses",
        samples=tuple(
            Sample(
                label=sight.label,
                given=sight.commanded_deg,
                measured=tuple(float(v) for v in seen[index]),
                residual=tuple(float(v) for v in misses[index, :2]),
                held_out_mm=float(off[index]),
                is_used=False,
            )
            for index, sight in enumerate(sights)
        ),
        accuracy=Accuracy(
            held_out_rms=float(np.sqrt(np.mean(off**2))),
            held_out_max=float(off.max()),
            held_out_count=len(off),
            how="fresh poses, the marker in x and y, the camera's noise included",
        ),
        findings=_findings(misses * noise.units, slopes * noise.units[:, None], off, limit_mm),
        based_on=(record.identity,),
        not_known=("whether the maps hold at angles that the fresh poses have not",),
    )


def _findings(misses: Array, slopes: Array, off: Array, limit_mm: float) -> tuple[Finding, ...]:
    """Judge misses (n, 6) and their slopes by joint angles (n, 6, 5), in standard deviations."""
    largest = float(off.max())
    one = _turned_joint(misses, slopes) if len(off) >= _LEAST else None
    # The wrist moves a marker near it by little, and what the fingers hold by much.
    is_turned = one is not None and abs(one[1]) > _SLIPPED_DEG
    if largest <= limit_mm and not is_turned:
        return ()
    grade = Grade.BAD if largest > _BAD * limit_mm else Grade.DEGRADED
    told = f"the marker is seen up to {largest:.1f} mm from where the maps put it, {limit_mm:g} " \
        "mm are good"  # fmt: skip
    if one is not None:
        joint, turn_deg = one
        return (
            Finding(
                code="servo-slipped",
                grade=grade,
                text=f"{told}; {JOINTS[joint]} turned by {turn_deg:+.1f} deg everywhere "
                "explains it",
                hint=f"tighten the horn of {JOINTS[joint]}'s servo and put it back, or measure the "
                "maps again",
            ),
        )
    return (
        Finding(
            code="servos-changed",
            grade=grade,
            text=told,
            hint="look for loose screws, a marker that was moved or another load in the fingers; "
            "then measure the servo maps again",
        ),
    )


def _turned_joint(misses: Array, slopes: Array) -> tuple[int, float] | None:
    """Return the one joint whose turn by the same angle explains the misses, and the angle."""
    flat = misses.ravel()
    best: tuple[float, int, float] | None = None
    for joint in range(slopes.shape[2]):
        slope = slopes[:, :, joint].ravel()
        strength = float(slope @ slope)
        if strength <= 0.0:
            continue
        turn_deg = float(slope @ flat) / strength
        left = float(np.sum((flat - turn_deg * slope) ** 2)) / float(flat @ flat)
        best = min(best or (left, joint, turn_deg), (left, joint, turn_deg))
    if best is None:
        return None
    left, joint, turn_deg = best
    is_noise = left * float(flat @ flat) <= _NOISE * (flat.size - 1)
    return (joint, turn_deg) if left <= _EXPLAINED or is_noise else None
