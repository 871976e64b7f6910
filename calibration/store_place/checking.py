"""Whether the store's sheet still lies where a record has it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.procedure import Procedure
from calibration.record import Accuracy, CalibrationRecord, Measurement, Sample
from calibration.store_place.fitting import deviations_mm, placed
from calibration.store_place.measurement import KIND
from calibration.store_place.procedure import store_place
from calibration.verdict import Finding, Grade

_MOVED_MM = 1.0
_LOST_MM = 3.0
_SIGMAS = 3.0

Points = NDArray[np.float64]


def check_store_place(site: Site, record: CalibrationRecord) -> Procedure:
    """Measure the sheet's place anew and compare every slot with a record.

    Raises:
        CalibrationError: The record or the cell has no store's place.
    """
    kept = _parameters(record)
    fresh = yield from store_place(site)
    findings = list(fresh.findings)
    samples: tuple[Sample, ...] = ()
    accuracy = Accuracy(how="no slot was compared")
    if fresh.parameters and site.plan is not None:
        slots = np.array([(slot.x_mm, slot.y_mm) for slot in site.plan.slots])
        now = _parameters(fresh)
        off = np.linalg.norm(placed(now, slots) - placed(kept, slots), axis=1)
        samples = tuple(
            Sample(label=f"slot {slot.number}", held_out_mm=float(miss))
            for slot, miss in zip(site.plan.slots, off, strict=True)
        )
        accuracy = Accuracy(
            held_out_rms=float(np.sqrt(np.mean(off**2))),
            held_out_max=float(off.max()),
            held_out_count=len(off),
            how="slots measured anew",
        )
        both = np.hypot(_spread(fresh, now, slots), _spread(record, kept, slots))
        worst = int(np.argmax(off))
        if off[worst] > max(_MOVED_MM, _SIGMAS * float(both[worst])):
            findings.append(
                Finding(
                    code="moved",
                    grade=Grade.BAD if off[worst] > _LOST_MM else Grade.DEGRADED,
                    text=f"slot {site.plan.slots[worst].number} lies {off[worst]:.1f} mm from "
                    "where the record has it",
                    hint="push the sheet back, or calibrate its place again: "
                    "`cell calibrate store-place`",
                )
            )
    return Measurement(
        kind=KIND,
        subject=record.subject,
        method="the place measured anew, slot by slot",
        samples=samples,
        accuracy=accuracy,
        region=record.region,
        findings=tuple(findings),
        based_on=(record.identity,),
        not_known=fresh.not_known,
    )


def _parameters(measured: Measurement) -> Points:
    if len(measured.parameters) != 3:
        raise CalibrationError("the record holds no place of the store; calibrate it again")
    return np.array([one.value for one in measured.parameters])


def _spread(measured: Measurement, parameters: Points, slots: Points) -> Points:
    """Return the standard deviation of every slot; none where it is not known."""
    covariance = np.array(measured.covariance)
    if covariance.shape != (3, 3) or not math.isfinite(float(covariance.sum())):
        return np.zeros(len(slots))
    return deviations_mm(covariance, float(parameters[2]), slots)
