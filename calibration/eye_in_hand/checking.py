"""Whether an eye in hand still is as it was measured, at fresh points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from calibration.eye_in_hand.judge import Fresh
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.verdict import Finding, Grade
from cell.geometry.eye_in_hand import EyeInHand
from cell.profile.ibm7545 import EyeInHandProfile

Array = NDArray[np.float64]

LIMIT_MM: Final = 2.0
"""Larger misses of the gripper do not pick an IC reliably."""

_BAD: Final = 2.0
_LEAST: Final = 3
_ALIKE: Final = 0.4
"""Scatter of misses about their mean, as a share of it, up to which they are one shift."""


def eye_of(record: CalibrationRecord) -> EyeInHand:
    """Return the eye in hand that a record sets.

    Raises:
        CalibrationError: It sets none.
    """
    value, links = record.values.get("arm.eye_in_hand"), record.values.get("arm.link_mm")
    if value is None or not isinstance(links, list) or len(links) != 2:
        raise CalibrationError(f"calibration {record.identity[:8]} holds no eye in hand to check")
    first, second = (float(one) for one in links if isinstance(one, int | float))
    return EyeInHandProfile.model_validate(value).value((first, second))


def checked(record: CalibrationRecord, fresh: Sequence[Fresh], limit_mm: float) -> Measurement:
    """Return how far the gripper misses fresh points that it is shown.

    Args:
        record: The calibration.
        fresh: Points seen by the camera and met by the gripper, at the table's height.
        limit_mm: Misses up to this are good.

    Raises:
        CalibrationError: The record holds no eye in hand.
    """
    eye = eye_of(record)
    offsets = np.array([_offset_mm(eye, one) for one in fresh]).reshape(-1, 2)
    off = np.hypot(*offsets.T)
    return Measurement(
        kind=record.kind,
        subject=record.subject,
        method=f"the eye in hand of {record.identity[:8]} held against {len(fresh)} fresh points",
        samples=tuple(
            Sample(
                label=one.look.label,
                given=(one.look.j1_deg, one.look.j2_deg, one.touch.j1_deg, one.touch.j2_deg),
                measured=(one.look.u_px, one.look.v_px),
                residual=(float(miss[0]), float(miss[1])),
                held_out_mm=float(np.hypot(*miss)),
                is_used=False,
            )
            for one, miss in zip(fresh, offsets, strict=True)
        ),
        accuracy=Accuracy(
            held_out_rms=float(np.sqrt(np.mean(off**2))),
            held_out_max=float(off.max()),
            held_out_count=len(off),
            how="gripper against seen point, fresh ones, with their own touch in it",
        ),
        findings=_findings(offsets, fresh, limit_mm),
        based_on=(record.identity,),
    )


def _offset_mm(eye: EyeInHand, fresh: Fresh) -> Array:
    """Return where a point seems to be less where the gripper met it, robot x and y."""
    look, touch = fresh.look, fresh.touch
    seen = eye.places(
        np.array([look.u_px, look.v_px]), np.array([look.j1_deg, look.j2_deg]), height_mm=0.0
    )
    offset: Array = seen - eye.gripper(np.array([touch.j1_deg, touch.j2_deg]))
    return offset


def _findings(offsets: Array, fresh: Sequence[Fresh], limit_mm: float) -> tuple[Finding, ...]:
    off = np.hypot(*offsets.T)
    if off.max() <= limit_mm:
        return ()
    grade = Grade.BAD if off.max() > _BAD * limit_mm else Grade.DEGRADED
    labels = tuple(one.look.label for one, miss in zip(fresh, off, strict=True) if miss > limit_mm)
    told = f"the gripper misses fresh points by up to {off.max():.1f} mm, {limit_mm:g} mm are good"
    shift = _shift_on_link(offsets, fresh)
    if shift is not None:
        return (
            Finding(
                code="camera-moved",
                grade=grade,
                text=f"{told}; seen from link 2 all miss alike, by ({shift[0]:+.1f}, "
                f"{shift[1]:+.1f}) mm along and across it: the camera moved on the link",
                hint="fasten the camera, and calibrate its eye in hand again",
                samples=labels,
            ),
        )
    return (
        Finding(
            code="eye-moved",
            grade=grade,
            text=told,
            hint="look whether the arm was homed, the camera sits firmly and the points lie at "
            "the table's height; then calibrate its eye in hand again",
            samples=labels,
        ),
    )


def _shift_on_link(offsets: Array, fresh: Sequence[Fresh]) -> Array | None:
    """Return the shift along and across link 2 that all misses share, None if they do not."""
    if len(fresh) < _LEAST:
        return None
    turn = np.radians([-(one.look.j1_deg + one.look.j2_deg) for one in fresh])
    cos, sin = np.cos(turn), np.sin(turn)
    x, y = offsets.T
    on_link = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
    mean: Array = on_link.mean(axis=0)
    scatter = np.hypot(*(on_link - mean).T)
    # Of a camera that hangs straight down alone; one that was turned also misses otherwise.
    return mean if float(scatter.max()) <= _ALIKE * float(np.hypot(*mean)) else None
