"""Names what is wrong with views of a target from a moving flange."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calibration.errors import FitFailed
from calibration.mount.fit import ArmNoise, MountFit, fit_mount
from calibration.mount.model import MountState, MountView
from calibration.mount.start import second_turn_deg, tilts
from calibration.verdict import Finding, Grade

LEAST_VIEWS = 5
GOOD_VIEWS = 10
_LEAST_TURN_DEG = 4.0
_LEAST_TILTS = 3
_SCALE_SLACK = 0.003
_SIGMAS = 4.0
_UNITS = (
    (10.0, "in centimetres"),
    (25.4, "in inches"),
    (1000.0, "in metres"),
    (0.1, "in tenths of a millimetre"),
)
_UNIT_SLACK = 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explained:
    """A fit, and what was found about its views.

    Attributes:
        fit: The fit to the views that are used.
        views: Those views.
        left_out: Labels of those that the others contradict.
        findings: What was found.
    """

    fit: MountFit
    views: tuple[MountView, ...]
    left_out: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()


def judge_poses(views: Sequence[MountView]) -> tuple[Finding, ...]:
    """Return whether poses are many and different enough, before anything is fitted."""
    found = []
    if len(views) < GOOD_VIEWS:
        found.append(
            Finding(
                code="too-few-poses",
                grade=Grade.BAD if len(views) < LEAST_VIEWS else Grade.DEGRADED,
                text=f"the target was seen from {len(views)} poses, {GOOD_VIEWS} or more are "
                "needed",
                hint="take more poses, or see why the target was not found in the others",
            )
        )
    turned = second_turn_deg(views)
    if len(views) >= 2 and turned < _LEAST_TURN_DEG:
        found.append(
            Finding(
                code="no-rotation",
                grade=Grade.BAD,
                text=f"about a second axis the hand was turned by {turned:.1f} deg only (RMS): "
                "where the camera hangs along the first one stays open",
                hint="tilt the hand to several sides by 15 deg and more, not only about the "
                "vertical",
            )
        )
    elif (count := tilts(views)) < _LEAST_TILTS and len(views) >= LEAST_VIEWS:
        found.append(
            Finding(
                code="few-tilts",
                grade=Grade.DEGRADED,
                text=f"the hand looked from {count} directions, {_LEAST_TILTS} are needed",
                hint="tilt it to more sides",
            )
        )
    return tuple(found)


def judge_unit(scale: float) -> Finding | None:
    """Return whether the target's size was given in another unit."""
    for factor, unit in _UNITS:
        if abs(scale / factor - 1.0) < _UNIT_SLACK:
            return _wrong_scale(scale, 0.0, f"; its size seems to be given {unit}")
    return None


def explain(views: Sequence[MountView], start: MountState, noise: ArmNoise) -> Explained:
    """Fit, and name what does not fit.

    A target of another size than given comes out by the arm's millimetres; one that was moved,
    because two places of it explain what one cannot; a single bad view, because the others
    agree without it.

    Raises:
        FitFailed: The views do not determine it.
    """
    fit = fit_mount(views, start, noise)
    used = tuple(views)
    scaled = fit_mount(used, fit.state, noise, with_scale=True)
    scale = scaled.state.scale
    deviation = math.sqrt(float(scaled.covariance[-1, -1])) / scaled.strain_ratio
    is_scaled = abs(scale - 1.0) > max(_SCALE_SLACK, _SIGMAS * deviation)
    if fit.is_consistent or (is_scaled and scaled.is_consistent):
        found = (_wrong_scale(scale, deviation, ""),) if is_scaled else ()
        return Explained(fit=fit, views=used, findings=found)
    return _moved(used, fit, noise) or _without_outlier(used, fit, noise) or Explained(
        fit=fit, views=used, findings=(_inexact(fit, noise),)
    )  # fmt: skip


def _moved(views: tuple[MountView, ...], fit: MountFit, noise: ArmNoise) -> Explained | None:
    """Return the fit with two places of the target, if that explains what one does not."""
    best: tuple[MountFit, int] | None = None
    for split in range(2, len(views) - 1):
        parts = tuple(replace(v, group=int(i >= split)) for i, v in enumerate(views))
        state = replace(fit.state, targets=fit.state.targets * 2)
        try:
            found = fit_mount(parts, state, noise)
        except FitFailed:
            continue
        if best is None or found.strain < best[0].strain:
            best = found, split
    if best is None or not best[0].is_consistent:
        return None
    found, split = best
    first, second = found.state.targets
    middle = np.mean(np.concatenate([v.points_mm for v in views]), axis=0)
    far = float(np.linalg.norm(second.apply(middle) - first.apply(middle)))
    return Explained(
        fit=fit,
        views=views,
        findings=(
            Finding(
                code="target-moved",
                grade=Grade.BAD,
                text=f"between {views[split - 1].label} and {views[split].label} the target, or "
                f"the camera on the hand, moved: it lies {far:.1f} mm elsewhere after",
                hint="fasten both, keep hands off the table, and calibrate again",
                samples=tuple(view.label for view in views[split:]),
            ),
        ),
    )


def _without_outlier(
    views: tuple[MountView, ...], fit: MountFit, noise: ArmNoise
) -> Explained | None:
    if len(views) <= LEAST_VIEWS:
        return None
    tried = []
    for index in range(len(views)):
        rest = (*views[:index], *views[index + 1 :])
        try:
            tried.append((fit_mount(rest, fit.state, noise), rest, views[index].label))
        except FitFailed:
            continue
    if not tried:
        return None
    found, rest, label = min(tried, key=lambda one: one[0].strain)
    if not found.is_consistent:
        return None
    return Explained(
        fit=found,
        views=rest,
        left_out=(label,),
        findings=(
            Finding(
                code="outlier-view",
                grade=Grade.DEGRADED,
                text=f"{label} contradicts the others, which agree without it; it is left out",
                hint="did the arm still move, or did somebody touch it?",
                samples=(label,),
            ),
        ),
    )


def _inexact(fit: MountFit, noise: ArmNoise) -> Finding:
    return Finding(
        code="arm-inexact",
        grade=Grade.DEGRADED,
        text=f"views disagree {fit.strain_ratio:.1f} times as much as an arm exact to "
        f"{noise.position_mm:g} mm and {noise.angle_deg:g} deg would let them; figures are "
        "given for that",
        hint="state how exact the arm really is, see that the camera sits fast, and that the "
        "target is flat",
    )


def _wrong_scale(scale: float, deviation: float, unit: str) -> Finding:
    exact = f" +- {200 * deviation:.2f} %" if deviation else ""
    return Finding(
        code="wrong-scale",
        grade=Grade.BAD,
        text=f"by the arm's millimetres the target is {100 * scale:.2f} %{exact} of the size "
        f"given{unit}",
        hint="measure it: the pitch of the screen's pixels (display.pixel_mm), the sheet's 100 mm "
        "ruler, or a square of the board",
    )
