"""From touched corners or pictures of a sheet to a measurement that can be kept."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.statistics import strong_correlations
from calibration.store_place.checks import reach_finding, screen_finding
from calibration.store_place.fitting import (
    CORNERS,
    Touched,
    deviations_mm,
    fit_corners,
)
from calibration.store_place.mistakes import misfit_finding, named_mistake, scale_finding
from calibration.verdict import Finding, Grade
from cell.profile import Profile, StoreProfile
from cell.sheet import SheetLayout
from cell.sheet.reading import Look, SheetReading, read_sheet
from cell.store import StorePlan

KIND = "store-place"

_NAMES = ("corner x", "corner y", "angle")
_UNITS = ("mm", "mm", "deg")
_GRADES = {"note": Grade.OK, "warning": Grade.DEGRADED, "failure": Grade.BAD}
_ANY_PLACE = ("moved", "wrong-way")
"""Findings that the sheet is not where it was, which is why its place is measured."""

Points = NDArray[np.float64]


def measure_touched(touched: Touched, profile: Profile, plan: StorePlan) -> Measurement:
    """Return where touched corners have the sheet, and how good that is.

    Raises:
        FitFailed: They are fewer than two, or all at one place.
    """
    fitted = fit_corners(touched)
    mistake = named_mistake(touched, profile.store)
    findings = [one for one in (mistake, scale_finding(touched.scale)) if one is not None]
    if mistake is None:
        misfit = misfit_finding(touched, fitted)
        findings += [] if misfit is None else [misfit]
    samples = tuple(
        Sample(
            label=CORNERS[index],
            given=tuple(touched.plan_mm[index].tolist()),
            measured=tuple(touched.points_mm[index].tolist()),
            residual=tuple(fitted.residuals_mm[index].tolist()),
            residual_mm=float(np.linalg.norm(fitted.residuals_mm[index])),
            held_out_mm=fitted.held_out_mm[index] if fitted.held_out_mm else None,
        )
        for index in range(len(touched.points_mm))
    )
    not_known = ["how good the arm's own positions are"]
    if not fitted.held_out_mm:
        not_known.append("how well it holds at points that were not fitted on: touch more corners")
    return _measurement(
        "rigid motion with the least squares to touched corners",
        samples,
        fitted.corner_mm,
        fitted.angle_deg,
        fitted.covariance,
        findings,
        profile,
        plan,
        size_mm=touched.size_mm,
        held_out=fitted.held_out_mm,
        how="leave-one-out over corners",
        fit_rms=_rms([one.residual_mm or 0.0 for one in samples]),
        not_known=not_known,
        details={"noise_mm": touched.noise_mm, "ruler_mm": 100.0 * touched.scale},
    )


def measure_seen(
    looks: Sequence[Look],
    digests: Sequence[str],
    camera: str,
    layout: SheetLayout,
    profile: Profile,
    plan: StorePlan,
    *,
    ruler_mm: float | None,
) -> Measurement:
    """Return where pictures have the sheet, and how good that is.

    Args:
        looks: The pictures.
        digests: Of the pictures, for the record.
        camera: Which camera looked.
        layout: The sheet.
        profile: The cell's profile.
        plan: The store.
        ruler_mm: What the sheet's ruler measures; None where it is as it should be.
    """
    reading = read_sheet(
        looks,
        layout,
        surface_mm=profile.heights.surface_mm,
        expected=profile.store,
        ruler_mm=ruler_mm,
    )
    findings = [
        Finding(code=f.code, grade=_GRADES[f.weight], text=f.text, hint=f.hint)
        for f in reading.findings
        if f.code not in _ANY_PLACE
    ]
    findings += [
        Finding(
            code=f.code, grade=Grade.DEGRADED, text=f.text, hint="if it was not laid so, turn it"
        )
        for f in reading.findings
        if f.code == "wrong-way"
    ]
    place = reading.place
    if place is None:
        return Measurement(
            kind=KIND, subject="store", method=_seen_by(camera), findings=tuple(findings)
        )
    held = [one.held_out_mm for one in reading.markers if one.held_out_mm is not None]
    return _measurement(
        _seen_by(camera),
        _seen_samples(reading, layout, digests, looks),
        place.corner_mm,
        place.angle_deg,
        place.covariance[:3, :3],
        findings,
        profile,
        plan,
        size_mm=(float(layout.width_mm), float(layout.height_mm)),
        held_out=held,
        how="leave-one-out over markers",
        fit_rms=_rms([one.residual_mm for one in reading.markers]),
        not_known=[f"what the calibration of the camera {camera} is off by"],
        details={"camera": camera, "scale": place.scale, "markers_seen": len(reading.seen)},
    )


def _seen_by(camera: str) -> str:
    return f"least squares to the corners of the sheet's markers in pictures of {camera}"


def _seen_samples(
    reading: SheetReading, layout: SheetLayout, digests: Sequence[str], looks: Sequence[Look]
) -> tuple[Sample, ...]:
    marked = {one.index: one for one in layout.fiducials}
    only = digests[0] if len(looks) == 1 else ""
    return tuple(
        Sample(
            label=f"marker {one.index}",
            given=(marked[one.index].x_mm, marked[one.index].y_mm),
            measured=tuple(one.corners_px.mean(axis=0).tolist()),
            residual_mm=one.residual_mm,
            held_out_mm=one.held_out_mm,
            picture=only,
        )
        for one in reading.markers
    )


def _measurement(
    method: str,
    samples: tuple[Sample, ...],
    corner_mm: tuple[float, float],
    angle_deg: float,
    covariance: Points,
    findings: Sequence[Finding],
    profile: Profile,
    plan: StorePlan,
    *,
    size_mm: tuple[float, float],
    held_out: Sequence[float],
    how: str,
    fit_rms: float,
    not_known: Sequence[str],
    details: dict[str, str | float | int],
) -> Measurement:
    """Return the measurement, the place checked for reach and screen unless it is a mistake."""
    store = StoreProfile(corner_mm=corner_mm, angle_deg=angle_deg)
    checked = list(findings)
    if all(one.grade is not Grade.BAD for one in checked):
        checks = (
            reach_finding(profile, plan, store),
            screen_finding(profile.display, store, size_mm),
        )
        checked += [one for one in checks if one is not None]
    spread = deviations_mm(
        covariance, angle_deg, np.array([(slot.x_mm, slot.y_mm) for slot in plan.slots])
    )
    deviation = np.sqrt(np.diag(covariance))
    wide, tall = size_mm
    angle = math.radians(angle_deg)
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([along[1], -along[0]])
    outline = [
        np.array(corner_mm) + along * x + across * y
        for x, y in ((0, 0), (wide, 0), (wide, tall), (0, tall))
    ]
    return Measurement(
        kind=KIND,
        subject="store",
        method=method,
        samples=samples,
        parameters=tuple(
            Parameter(name=name, value=value, unit=unit, deviation=float(sigma))
            for name, value, unit, sigma in zip(
                _NAMES, (*corner_mm, angle_deg), _UNITS, deviation, strict=True
            )
        ),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        correlations=tuple(
            Correlation(first=first, second=second, value=value)
            for first, second, value in strong_correlations(covariance, _NAMES)
        ),
        accuracy=Accuracy(
            fit_rms=fit_rms,
            held_out_rms=_rms(held_out) if held_out else None,
            held_out_max=max(held_out) if held_out else None,
            held_out_count=len(held_out),
            how=how if held_out else "",
            predicted_rms=_rms(spread.tolist()),
            predicted_max=float(2.4477 * spread.max()),
        ),
        region=Region(
            text="the store's sheet", outline_mm=tuple((float(x), float(y)) for x, y in outline)
        ),
        findings=tuple(checked),
        values={"store.corner_mm": list(corner_mm), "store.angle_deg": angle_deg},
        details=dict(details),
        not_known=tuple(not_known),
    )


def _rms(values: Sequence[float]) -> float:
    return math.sqrt(sum(v * v for v in values) / len(values))
