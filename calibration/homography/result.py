"""From pairs to what a calibration leaves behind: fit, verdict, accuracy, values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.camera_values import place_value
from calibration.errors import FitFailed
from calibration.homography.dlt import homography
from calibration.homography.judging import Pairs, judge_pairs
from calibration.homography.knowledge import CameraKnowledge, TableFit
from calibration.homography.noise import PairNoise
from calibration.homography.outliers import judge_noise
from calibration.homography.place_fit import PlaceFit, place_parameters
from calibration.homography.plane_fit import PlaneFit
from calibration.homography.planning import predicted_error
from calibration.homography.sampling import Pair
from calibration.playground import PLAYGROUND_MM
from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.statistics import strong_correlations
from calibration.verdict import Finding, Grade, worst

Points = NDArray[np.float64]

KIND = "homography"
_ENTRIES: tuple[str, ...] = ("h11", "h12", "h13", "h21", "h22", "h23", "h31", "h32")
_ENTRY_UNITS: tuple[str, ...] = ("mm/px", "mm/px", "mm", "mm/px", "mm/px", "mm", "1/px", "1/px")


def judged(
    known: CameraKnowledge,
    fitted: Sequence[Pair],
    fresh: Sequence[Pair],
    noise: PairNoise,
    *,
    quality_mm: float,
    by_arm: bool,
    findings: Sequence[Finding] = (),
) -> Measurement:
    """Return the calibration that pairs give.

    Args:
        known: The camera.
        fitted: Pairs to fit on.
        fresh: Pairs to test on.
        noise: How exactly the pairs are known.
        quality_mm: Held-out error that is asked for.
        by_arm: Whether the arm placed the object.
        findings: What was found while they were taken.
    """
    pairs = pairs_of(fitted)
    before = None if known.before is None else known.to_robot_before
    found = [*findings, *judge_pairs(pairs, before)]
    if worst(found) is Grade.BAD:
        return failed(known, fitted, found)
    try:
        fit = known.fit(pairs.pixels, pairs.points_mm, noise)
    except FitFailed as error:
        found.append(_bad("undetermined", str(error), "take other points"))
        return failed(known, fitted, found)
    everything = pairs_of([*fitted, *fresh])
    found += judge_noise(everything, known, noise, by_arm=by_arm)
    samples, accuracy = _tested(known, fit, fitted, fresh, noise)
    stated = accuracy.stated
    if stated is not None and stated > quality_mm:
        found.append(
            Finding(
                code="quality-not-met",
                grade=Grade.DEGRADED,
                text=f"the {'predicted' if accuracy.held_out_rms is None else 'held-out'} error is "
                f"{stated:.2f} mm, {quality_mm:g} mm were asked for",
                hint="take more points"
                + ("" if known.lens is not None else ", or calibrate the lens first"),
            )
        )
    parameters, covariance = _parameters(fit)
    strong = strong_correlations(covariance, [p.name for p in parameters])
    return Measurement(
        kind=KIND,
        subject=known.camera,
        method=_method(known, len(fitted), by_arm=by_arm),
        samples=samples,
        parameters=parameters,
        covariance=tuple(tuple(float(v) for v in row) for row in covariance),
        correlations=tuple(Correlation(first=a, second=b, value=c) for a, b, c in strong),
        accuracy=accuracy,
        region=_region(known, pairs),
        findings=tuple(found),
        values={} if worst(found) is Grade.BAD else _values(known, fit, pairs),
        details=_details(known, fit, pairs, noise),
        stands_on=known.stands_on if isinstance(fit, PlaceFit) else (),
        not_known=_not_known(known, fit, fitted),
    )


def failed(
    known: CameraKnowledge, pairs: Sequence[Pair], findings: Sequence[Finding]
) -> Measurement:
    """Return a calibration that sets nothing, with what was found."""
    return Measurement(
        kind=KIND,
        subject=known.camera,
        method="nothing was fitted",
        samples=tuple(
            Sample(label=p.label, given=p.point_mm, measured=p.pixel, picture=p.picture)
            for p in pairs
        ),
        findings=tuple(findings),
        details={"camera": known.camera, "guid": known.guid},
        not_known=("anything: nothing was fitted",),
    )


def pairs_of(pairs: Sequence[Pair]) -> Pairs:
    """Return pairs as arrays."""
    return Pairs(
        tuple(pair.label for pair in pairs),
        np.array([pair.pixel for pair in pairs], np.float64).reshape(-1, 2),
        np.array([pair.point_mm for pair in pairs], np.float64).reshape(-1, 2),
    )


def _tested(
    known: CameraKnowledge,
    fit: TableFit,
    fitted: Sequence[Pair],
    fresh: Sequence[Pair],
    noise: PairNoise,
) -> tuple[tuple[Sample, ...], Accuracy]:
    pairs = pairs_of(fitted)
    left_out = _leave_one_out(known, pairs, noise)
    samples = [
        _sample(pair, fit, left_out[index], is_used=True) for index, pair in enumerate(fitted)
    ]
    tests = [_sample(pair, fit, None, is_used=False) for pair in fresh]
    held = [s.held_out_mm for s in tests if s.held_out_mm is not None]
    how = "fresh, with their own scatter and finding error in it"
    if not held:
        held = [value for value in left_out if value is not None]
        how = "leave-one-out" if held else ""
    rms, largest = predicted_error(fit)
    return (*samples, *tests), Accuracy(
        fit_rms=float(np.sqrt((fit.residuals_mm**2).sum(axis=1).mean())),
        held_out_rms=float(np.sqrt(np.mean(np.square(held)))) if held else None,
        held_out_max=max(held) if held else None,
        held_out_count=len(held),
        how=how,
        predicted_rms=rms,
        predicted_max=largest,
    )


def _sample(pair: Pair, fit: TableFit, held_out_mm: float | None, *, is_used: bool) -> Sample:
    miss = fit.to_robot(np.array([pair.pixel]))[0] - np.array(pair.point_mm)
    off = float(np.hypot(*miss))
    return Sample(
        label=pair.label,
        given=pair.point_mm,
        measured=pair.pixel,
        residual=(float(miss[0]), float(miss[1])),
        residual_mm=off,
        held_out_mm=held_out_mm if is_used else off,
        is_used=is_used,
        picture=pair.picture,
    )


def _leave_one_out(known: CameraKnowledge, pairs: Pairs, noise: PairNoise) -> list[float | None]:
    """Return each pair's distance from a fit without it; None where too few would be left."""
    if len(pairs.labels) < 5:
        return [None] * len(pairs.labels)
    held: list[float | None] = []
    for index in range(len(pairs.labels)):
        rest = pairs.without(index)
        try:
            fit = known.fit(rest.pixels, rest.points_mm, noise)
        except FitFailed:
            held.append(None)
            continue
        miss = fit.to_robot(pairs.pixels[[index]])[0] - pairs.points_mm[index]
        held.append(float(np.hypot(*miss)))
    return held


def _parameters(fit: TableFit) -> tuple[tuple[Parameter, ...], Points]:
    names, units = _ENTRIES, _ENTRY_UNITS
    if isinstance(fit, PlaneFit):
        values, covariance = fit.matrix.ravel()[:8], fit.covariance
    else:
        names, units, values, covariance = place_parameters(fit)
    deviations = np.sqrt(np.diag(covariance))
    return tuple(
        Parameter(name=name, value=float(value), unit=unit, deviation=float(deviation))
        for name, unit, value, deviation in zip(names, units, values, deviations, strict=True)
    ), covariance


def _values(known: CameraKnowledge, fit: TableFit, pairs: Pairs) -> dict[str, JsonValue]:
    camera = f"cameras.{known.camera}"
    # Whoever asks for a plane map alone gets the best homography of the pairs as seen.
    matrix = fit.matrix if isinstance(fit, PlaneFit) else homography(pairs.pixels, pairs.points_mm)
    values: dict[str, JsonValue] = {
        f"{camera}.plane_map": [[float(v) for v in row] for row in matrix],
        f"{camera}.plane_map_guid": known.guid,
        f"{camera}.plane_map_date": None,
        f"{camera}.place": None,
    }
    if isinstance(fit, PlaceFit):
        values[f"{camera}.place"] = place_value(fit.view.robot_from_camera.to_pose())
    return values


def _details(
    known: CameraKnowledge, fit: TableFit, pairs: Pairs, noise: PairNoise
) -> dict[str, JsonValue]:
    return {
        "camera": known.camera,
        "guid": known.guid,
        "height_mm": known.height_mm,
        "with_lens": isinstance(fit, PlaceFit),
        "pixel_noise_px": noise.pixel_px,
        "placement_noise_mm": noise.placement_mm,
        "noise_ratio": fit.noise_ratio,
        "pixels": [[float(v) for v in row] for row in pairs.pixels],
        "points_mm": [[float(v) for v in row] for row in pairs.points_mm],
    }


def _method(known: CameraKnowledge, count: int, *, by_arm: bool) -> str:
    who = "the arm" if by_arm else "a person"
    if known.lens is None:
        return f"homography (normalised DLT, geometric error) of {count} points placed by {who}"
    return f"place of the camera, its lens known, from {count} points placed by {who}"


def _region(known: CameraKnowledge, pairs: Pairs) -> Region:
    (x0, y0), (x1, y1) = pairs.points_mm.min(axis=0), pairs.points_mm.max(axis=0)
    height = f"{known.height_mm:g} mm above the base plane"
    return Region(
        text=(
            f"block tops, {height}, between the points; accuracy is predicted over the playground"
            if known.lens is None
            else f"any height near the block tops ({height}); accuracy is predicted over the "
            "playground"
        ),
        outline_mm=tuple(
            PLAYGROUND_MM if known.lens is not None
            else ((float(x0), float(y0)), (float(x1), float(y0)), (float(x1), float(y1)),
                  (float(x0), float(y1)))
        ),
    )  # fmt: skip


def _not_known(known: CameraKnowledge, fit: TableFit, pairs: Sequence[Pair]) -> tuple[str, ...]:
    texts = []
    if isinstance(fit, PlaneFit):
        texts.append(
            "what the lens bends: the predicted error leaves it out and is too small by it"
        )
        texts.append("other heights than that of the block tops")
    elif known.lens_covariance is None:
        texts.append("how well the lens is known: it is taken for exact")
    if len(pairs) == 4 and known.before is None:
        texts.append(
            "a mistake in one pair of less than some 6 % of the distances: four pairs leave "
            "nothing over to see it by"
        )
    if any(p.seen is not None and p.seen.is_side_hidden for p in pairs) and known.before is None:
        texts.append("how tilt and lens stretch the object's face: up to half a pixel a point")
    return tuple(texts)


def _bad(code: str, text: str, hint: str) -> Finding:
    return Finding(code=code, grade=Grade.BAD, text=text, hint=hint)
