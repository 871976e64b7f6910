"""From views of a target to what the calibration of a camera on the flange leaves behind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.camera_values import place_value
from calibration.errors import FitFailed
from calibration.mount.accuracy import held_out_mm, miss_mm, rms, table_deviations_mm
from calibration.mount.fit import ArmNoise, MountFit
from calibration.mount.mistakes import LEAST_VIEWS, Explained, explain, judge_poses, judge_unit
from calibration.mount.model import LENS_NAMES, MountState, MountView, transform, turned
from calibration.mount.start import start_of
from calibration.record import Accuracy, Correlation, Measurement, Parameter, Region, Sample
from calibration.statistics import region_factor, strong_correlations
from calibration.verdict import Finding, Grade, worst
from cell.geometry import Transform

Points = NDArray[np.float64]

KIND = "mount"
NAMES = (*LENS_NAMES, "a_deg", "b_deg", "c_deg", "x_mm", "y_mm", "z_mm")
_UNITS = ("px", "px", "px", "", "", "deg", "deg", "deg", "mm", "mm", "mm")
_TURN_STEP_RAD = 1e-5


def judged(
    camera: str,
    target: str,
    views: Sequence[MountView],
    noise: ArmNoise,
    *,
    surface_mm: float,
    quality_mm: float,
    pictures: Mapping[str, str],
    findings: Sequence[Finding] = (),
) -> Measurement:
    """Return the calibration that views give.

    Args:
        camera: Name of the camera.
        target: What was looked at, for people.
        views: Where its points were seen, from where.
        noise: How exact the arm is.
        surface_mm: Height of the table, at which accuracy is stated.
        quality_mm: Held-out error that is asked for.
        pictures: Digests of the pictures by view.
        findings: What was found while they were taken.
    """
    found = [*findings, *judge_poses(views)]
    if worst(found) is Grade.BAD or len(views) < LEAST_VIEWS:
        return failed(camera, found)
    try:
        start = start_of(views)
        unit = judge_unit(start.scale)
        if unit is not None:
            return failed(camera, [*found, unit])
        state = MountState(
            lens=start.lens, flange_from_camera=start.flange_from_camera, targets=start.targets
        )
        explained = explain(views, state, noise)
    except FitFailed as error:
        undetermined = Finding(code="undetermined", grade=Grade.BAD, text=str(error))
        return failed(camera, [*found, undetermined])
    found += explained.findings
    held = held_out_mm(explained.views, explained.fit, noise)
    known = [one for one in held if one is not None]
    is_good = worst(found) is not Grade.BAD
    if is_good and known and rms(np.concatenate(known)) > quality_mm:
        found.append(
            Finding(
                code="quality-not-met",
                grade=Grade.DEGRADED,
                text=f"poses that were left out miss by {rms(np.concatenate(known)):.2f} mm, "
                f"{quality_mm:g} mm were asked for",
                hint="take more poses, focus the lens, and see that the camera sits fast",
            )
        )
    return _measurement(camera, target, explained, held, noise, surface_mm, pictures, found)


def failed(camera: str, findings: Sequence[Finding]) -> Measurement:
    """Return a calibration that sets nothing."""
    return Measurement(
        kind=KIND,
        subject=camera,
        method="nothing was fitted",
        findings=tuple(findings),
        details={"camera": camera},
        not_known=("anything: nothing was fitted",),
    )


def _measurement(
    camera: str,
    target: str,
    explained: Explained,
    held: Sequence[Points | None],
    noise: ArmNoise,
    surface_mm: float,
    pictures: Mapping[str, str],
    found: Sequence[Finding],
) -> Measurement:
    fit, views = explained.fit, explained.views
    covariance = printed_covariance(fit)
    pose = fit.state.flange_from_camera.to_pose()
    numbers = (*fit.state.lens.tolist(), pose.a_deg, pose.b_deg, pose.c_deg,
               pose.x_mm, pose.y_mm, pose.z_mm)  # fmt: skip
    known = [one for one in held if one is not None]
    spread = table_deviations_mm(
        fit.state, fit.covariance, [view.robot_from_flange for view in views], surface_mm
    )
    return Measurement(
        kind=KIND,
        subject=camera,
        method=f"bundle adjustment of lens, mount and target over {len(views)} poses of the arm "
        f"that look at {target}, the arm's own exactness in it",
        samples=(*_samples(views, fit, held, pictures),
                 *(Sample(label=label, is_used=False, picture=pictures.get(label, ""))
                   for label in explained.left_out)),
        parameters=tuple(
            Parameter(name=name, value=float(value), unit=unit, deviation=float(sigma))
            for name, value, unit, sigma in zip(
                NAMES, numbers, _UNITS, np.sqrt(np.diag(covariance)), strict=True
            )
        ),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        correlations=tuple(
            Correlation(first=a, second=b, value=c)
            for a, b, c in strong_correlations(covariance, NAMES)
        ),
        accuracy=Accuracy(
            fit_rms=rms(np.concatenate([miss_mm(view, fit.state) for view in views])),
            held_out_rms=rms(np.concatenate(known)) if known else None,
            held_out_max=float(max(one.max() for one in known)) if known else None,
            held_out_count=sum(len(one) for one in known),
            how="corners of each pose by a fit without it, on the table" if known else "",
            predicted_rms=math.sqrt(float((spread**2).sum(axis=1).mean())) if len(spread) else None,
            predicted_max=math.sqrt(region_factor(2, None)) * float(spread.max())
            if len(spread) else None,
        ),
        region=Region(text="the table, seen from poses like those that were used"),
        findings=tuple(found),
        values={} if worst(found) is Grade.BAD else {
            f"cameras.{camera}.lens": _lens_value(fit.state),
            f"cameras.{camera}.mount": place_value(pose),
        },
        details={
            "camera": camera,
            "target": target,
            "target_place": place_value(fit.state.targets[0].to_pose()),
            "sigma_px": fit.sigma_px,
            "arm_position_mm": noise.position_mm,
            "arm_angle_deg": noise.angle_deg,
            "strain": fit.strain,
            "strain_freedom": fit.freedom,
        },
        not_known=(
            "what the arm is off by all over, such as its base or the tool's length: lens and "
            "mount take up some of it",
            "how the lens changes with focus and temperature",
        ),
    )  # fmt: skip


def printed_covariance(fit: MountFit) -> Points:
    """Return the covariance (11, 11) in the order of `NAMES`: the angles as a profile has them."""
    base = fit.state.flange_from_camera
    slopes = np.eye(11)
    columns = []
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = _TURN_STEP_RAD
        up, down = (
            _angles(transform(base.rotation @ turned(sign * step), base.translation_mm))
            for sign in (1.0, -1.0)
        )
        columns.append((up - down + 180.0) % 360.0 - 180.0)
    slopes[5:8, 5:8] = np.stack(columns, axis=1) / (2.0 * _TURN_STEP_RAD)
    return np.asarray(slopes @ fit.covariance[:11, :11] @ slopes.T)


def _angles(one: Transform) -> Points:
    pose = one.to_pose()
    return np.array([pose.a_deg, pose.b_deg, pose.c_deg])


def _samples(
    views: Sequence[MountView],
    fit: MountFit,
    held: Sequence[Points | None],
    pictures: Mapping[str, str],
) -> tuple[Sample, ...]:
    found = []
    for view, miss, out in zip(views, fit.residuals, held, strict=True):
        pose = view.robot_from_flange.to_pose()
        found.append(
            Sample(
                label=view.label,
                given=(pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg),
                measured=(float(len(view.pixels)),),
                residual=(rms(np.linalg.norm(miss, axis=1)),),
                residual_mm=rms(miss_mm(view, fit.state)),
                held_out_mm=None if out is None else rms(out),
                picture=pictures.get(view.label, ""),
            )
        )
    return tuple(found)


def _lens_value(state: MountState) -> JsonValue:
    focal, centre_u, centre_v, k1, k2 = state.lens.tolist()
    return {
        "focal_px": [focal, focal], "centre_px": [centre_u, centre_v],
        "k1": k1, "k2": k2, "p1": 0.0, "p2": 0.0, "k3": 0.0,
    }  # fmt: skip
