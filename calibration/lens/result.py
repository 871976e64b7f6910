"""From views of a board to what a lens calibration leaves behind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.camera_values import lens_value
from calibration.errors import FitFailed
from calibration.lens.fit import BoardView, LensFit, LensPrior, fit_lens, pose_of
from calibration.lens.judging import (
    coverage,
    duplicates,
    few_views,
    judge_distance,
    judge_views,
    tilts,
)
from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.statistics import strong_correlations
from calibration.verdict import Finding, Grade, worst
from cell.vision.boards import Board

Points = NDArray[np.float64]

KIND = "lens"
FULL_WIDTH_PX, FULL_HEIGHT_PX = 1280, 960
_OUTLIER = 3.0
_OUTLIER_PX = 0.6


def judged(
    camera: str,
    guid: str,
    board: Board,
    views: Sequence[BoardView],
    size_px: tuple[int, int],
    prior: LensPrior,
    *,
    quality_px: float,
    distance_mm: float = 0.0,
    pictures: dict[str, str] | None = None,
    findings: Sequence[Finding] = (),
) -> Measurement:
    """Return the calibration that views give.

    Args:
        camera: Name of the camera.
        guid: Its own identity.
        board: The board.
        views: Where its corners are.
        size_px: Width and height of the pictures.
        prior: Which parameters the lens has.
        quality_px: Held-out error that is asked for.
        distance_mm: About how far away the board was; 0 if nobody measured.
        pictures: Digests of the pictures by view.
        findings: What was found while the views were taken.
    """
    found = list(findings)
    same = duplicates(views)
    twice = {label for label, _ in same}
    if same:
        found.append(
            Finding(
                code="duplicate-views",
                grade=Grade.DEGRADED,
                text=f"{len(same)} views show the board where another does and are left out: "
                + ", ".join(f"{a} like {b}" for a, b in same[:4]),
                hint="move and tilt the board between views",
                samples=tuple(sorted(twice)),
            )
        )
    used = [view for view in views if view.label not in twice]
    wide, high = size_px
    if worst(found) is Grade.BAD:
        return failed(camera, guid, found)
    if len(used) < 3:
        return failed(camera, guid, [*found, few_views(len(used))])
    try:
        fit, used, held, bad = _without_outliers(board, used, wide, high, prior)
    except FitFailed as error:
        found.append(Finding(code="undetermined", grade=Grade.BAD, text=str(error)))
        return failed(camera, guid, found)
    if bad:
        found.append(_outlier_finding(bad))
    found += judge_views(used, fit.poses, wide, high)
    found += judge_distance(fit.poses, distance_mm)
    rms = float(np.sqrt(np.mean([value**2 for value in held.values()])))
    if rms > quality_px:
        found.append(
            Finding(
                code="quality-not-met",
                grade=Grade.DEGRADED,
                text=f"views that were left out miss by {rms:.2f} px, {quality_px:g} px were "
                "asked for",
                hint="look whether the board is flat and whether another model of the lens fits",
            )
        )
    return _measurement(
        camera, guid, board, used, fit, held, bad, size_px, pictures or {}, found, rms, prior
    )


def failed(camera: str, guid: str, findings: Sequence[Finding]) -> Measurement:
    """Return a calibration that sets nothing."""
    return Measurement(
        kind=KIND,
        subject=camera,
        method="nothing was fitted",
        findings=tuple(findings),
        details={"camera": camera, "guid": guid},
        not_known=("anything: nothing was fitted",),
    )


def _without_outliers(
    board: Board, views: Sequence[BoardView], wide: int, high: int, prior: LensPrior
) -> tuple[LensFit, list[BoardView], dict[str, float], dict[str, float]]:
    """Fit, leave out views that the others contradict, and fit again."""
    used = list(views)
    bad: dict[str, float] = {}
    while True:
        fit = fit_lens(board, used, wide, high, prior)
        held = _left_out(board, used, wide, high, prior, fit)
        usual = float(np.median(list(held.values())))
        label = max(held, key=lambda name: held[name])
        if held[label] <= max(_OUTLIER * usual, _OUTLIER_PX) or len(used) <= 4:
            return fit, used, held, bad
        bad[label] = held[label]
        used = [view for view in used if view.label != label]


def _left_out(
    board: Board,
    views: Sequence[BoardView],
    wide: int,
    high: int,
    prior: LensPrior,
    full: LensFit,
) -> dict[str, float]:
    """Return for each view how far its corners lie from a fit without it, RMS px."""
    if len(views) < 4:
        pairs = zip(views, full.residuals, strict=True)
        return {view.label: _rms(miss) for view, miss in pairs}
    held = {}
    for index, view in enumerate(views):
        rest = [*views[:index], *views[index + 1 :]]
        poses = [*full.poses[:index], *full.poses[index + 1 :]]
        fit = fit_lens(board, rest, wide, high, prior, (full.values, poses))
        _, miss = pose_of(board, view, fit.lens)
        held[view.label] = _rms(miss)
    return held


def _rms(miss: Points) -> float:
    return float(np.sqrt((miss**2).sum(axis=1).mean()))


def _outlier_finding(bad: dict[str, float]) -> Finding:
    names = ", ".join(f"{label} ({off:.1f} px)" for label, off in bad.items())
    return Finding(
        code="outlier-view",
        grade=Grade.DEGRADED,
        text=f"views that the others contradict are left out: {names}",
        hint="was the board bent, moved during the exposure, or another one?",
        samples=tuple(bad),
    )


def _measurement(
    camera: str,
    guid: str,
    board: Board,
    used: Sequence[BoardView],
    fit: LensFit,
    held: dict[str, float],
    bad: dict[str, float],
    size_px: tuple[int, int],
    pictures: dict[str, str],
    found: Sequence[Finding],
    rms_px: float,
    prior: LensPrior,
) -> Measurement:
    deviations = np.sqrt(np.diag(fit.covariance))
    strong = strong_correlations(fit.covariance, fit.free)
    scale = FULL_WIDTH_PX / size_px[0]
    full = fit.lens.resized(FULL_WIDTH_PX)
    values: dict[str, JsonValue] = {f"cameras.{camera}.lens": lens_value(full)}
    return Measurement(
        kind=KIND,
        subject=camera,
        method=f"bundle adjustment of {len(used)} views of a {board.kind} of {board.columns} x "
        f"{board.rows} squares",
        samples=tuple(
            Sample(
                label=view.label,
                residual=(_rms(miss),),
                held_out_mm=None,
                measured=(float(len(view.ids)), held[view.label]),
                picture=pictures.get(view.label, ""),
            )
            for view, miss in zip(used, fit.residuals, strict=True)
        )
        + tuple(
            Sample(label=label, measured=(0.0, off), is_used=False,
                   picture=pictures.get(label, ""))
            for label, off in bad.items()
        ),
        parameters=tuple(
            Parameter(
                name=name,
                value=float(value),
                unit="px" if "px" in name else "",
                deviation=float(deviation),
            )
            for name, value, deviation in zip(fit.free, fit.values, deviations, strict=True)
        ),
        covariance=tuple(tuple(float(v) for v in row) for row in fit.covariance),
        correlations=tuple(Correlation(first=a, second=b, value=c) for a, b, c in strong),
        accuracy=Accuracy(
            fit_rms=fit.rms_px * float(np.sqrt(2.0)),
            held_out_rms=rms_px,
            held_out_max=max(held.values()),
            held_out_count=len(held),
            how="each view left out in turn, its own pose fitted",
            unit="px",
        ),
        region=Region(text="where corners were seen: see `coverage` of the details, row by row"),
        findings=tuple(found),
        values={} if worst(found) is Grade.BAD else values,
        details={
            "camera": camera,
            "guid": guid,
            "size_px": list(size_px),
            "board": {
                "kind": board.kind, "columns": board.columns, "rows": board.rows,
                "square_mm": board.square_mm, "marker_mm": board.marker_mm,
                "dictionary": board.dictionary,
            },
            "coverage": coverage(used, *size_px).tolist(),
            "tilts_deg": dict(tilts(fit.poses)),
            "lens_covariance": _full_covariance(fit, scale),
            "square_pixels": prior.has_square_pixels,
        },
        not_known=(
            "the size of the squares: lens and pictures look the same with any"
            " (only a measured distance tells)",
            "how the lens changes with focus and temperature",
        ),
    )  # fmt: skip


def _full_covariance(fit: LensFit, scale: float) -> JsonValue:
    """Return the covariance of the nine parameters for pictures of 1280 x 960."""
    factors = np.array([scale] * 4 + [1.0] * 5)
    full = fit.lens_covariance * np.outer(factors, factors)
    return [[float(v) for v in row] for row in full]
