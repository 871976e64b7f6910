"""From a fit to a measurement: values for the profile, accuracy, correlations, findings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from pydantic import JsonValue

from calibration.camera_values import lens_value, place_value
from calibration.drift.check import DotReference
from calibration.drift.dots import dot_places
from calibration.playground import PLAYGROUND_MM
from calibration.record import (
    Accuracy,
    Correlation,
    Measurement,
    Parameter,
    Region,
    Sample,
)
from calibration.screen.held_out import LeftOut, left_out
from calibration.screen.joint_fit import ScreenFit, place_in_robot
from calibration.screen.judge import judge_fit, predicted_mm
from calibration.screen.patterns import Panel
from calibration.statistics import chi_square_quantile, strong_correlations
from calibration.verdict import Finding

KIND: Final = "screen"
METHOD: Final = (
    "phase shifts and Gray code on the screen decoded in every picture; lens (focal length, "
    "centre, k1, k2) and place of all cameras, the screen's place and the placed blocks fitted "
    "together"
)
_ASSUMED: Final = (
    "the lens's tangential coefficients and k3: one plane does not tell them from a tilt; taken "
    "as 0, pixels as square",
    "whether the screen is flat and its pixel_mm right beyond what touched points and blocks tell",
    "the heights of glass and blocks: they are the profile's",
)


def measurement(
    found: ScreenFit,
    *,
    panel: Panel,
    dots: Sequence[DotReference],
    findings: Sequence[Finding],
    pictures: Mapping[str, str],
) -> Measurement:
    """Return what was measured.

    Args:
        found: The fit.
        panel: The grey values used.
        dots: Where each camera sees the dots of the check for drift.
        findings: What was found before the fit.
        pictures: Digest of the picture of each sample, by its label.
    """
    points = left_out(found)
    given, fit = found.given, found.fit
    names, units = given.names(), given.units()
    deviations = np.sqrt(np.diag(fit.covariance))
    return Measurement(
        kind=KIND,
        subject="cell",
        method=METHOD,
        samples=(*_dense(found, pictures), *_points(points, found, pictures)),
        parameters=tuple(
            Parameter(name=name, value=float(value), unit=unit, deviation=float(deviation))
            for name, value, unit, deviation in zip(
                names, fit.parameters, units, deviations, strict=True
            )
        ),
        covariance=tuple(tuple(float(k) for k in row) for row in fit.covariance),
        correlations=tuple(
            Correlation(first=first, second=second, value=value)
            for first, second, value in strong_correlations(fit.covariance, names)
        ),
        accuracy=_accuracy(found, panel, points, dots),
        region=Region(
            text="what the cameras see of the screen, from the glass to the block tops",
            outline_mm=PLAYGROUND_MM,
        ),
        findings=(*findings, *judge_fit(found, points)),
        values=_values(found),
        details={
            "bright": panel.bright,
            "gamma": panel.gamma,
            "rms_px": {name: round(rms, 4) for name, rms in found.rms_px.items()},
            "dots": {one.camera: one.rows() for one in dots},
            "lens_covariance": {
                name: [[float(v) for v in row] for row in found.lens_covariance(name)]
                for name in given.cameras
            },
        },
        not_known=_ASSUMED,
    )


def fresh_dots_mm(found: ScreenFit, panel: Panel, seen: DotReference) -> float:
    """Return how far dots, which were not fitted on, lie from their places on the glass.

    The screen's own place counts the same on both sides: what is told is lens, plane and
    screen-to-camera.
    """
    known = seen.known()
    screen = found.place()
    places = dot_places(panel.width_px, panel.height_px)[known]
    robot_mm = found.view(seen.camera).to_robot(seen.pixels[known], screen.height_mm)
    off = robot_mm - place_in_robot(screen, places)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def _values(found: ScreenFit) -> dict[str, JsonValue]:
    values: dict[str, JsonValue] = {}
    for name in found.given.cameras:
        view = found.view(name)
        values[f"cameras.{name}.lens"] = lens_value(view.lens)
        values[f"cameras.{name}.place"] = place_value(view.robot_from_camera.to_pose())
    if found.given.touches or found.given.blocks:
        place = found.place()
        values["display.corner_x_mm"] = place.corner_mm[0]
        values["display.corner_y_mm"] = place.corner_mm[1]
        values["display.angle_deg"] = math.remainder(place.angle_deg, 360.0)
    return values


def _accuracy(
    found: ScreenFit, panel: Panel, points: Sequence[LeftOut], dots: Sequence[DotReference]
) -> Accuracy:
    predicted = [predicted_mm(found, name) for name in found.given.cameras]
    distances = [point.distance_mm for point in points]
    expected = [math.sqrt(2.0) * point.expected_mm for point in points]
    told = [f"{one.camera} {fresh_dots_mm(found, panel, one):.3f} mm" for one in dots]
    parts = []
    rms = max(p[0] for p in predicted)
    map_rms, map_upper = map_error(distances, expected, rms)
    if points:
        parts.append(
            f"{len(points)} points left out one by one, of which placing or touching and finding "
            f"them make {float(np.sqrt(np.mean(np.square(expected)))):.2f} mm"
        )
    if told:
        parts.append(f"fresh dots on the glass: {', '.join(told)}")
    return Accuracy(
        fit_rms=_fit_rms(points),
        held_out_rms=float(np.sqrt(np.mean(np.square(distances)))) if points else None,
        held_out_max=max(distances, default=None),
        held_out_count=len(points),
        how="; ".join(parts),
        predicted_rms=rms,
        predicted_max=max(p[1] for p in predicted),
        map_rms=map_rms,
        map_upper=map_upper,
    )


def map_error(
    distances_mm: Sequence[float], scatter_mm: Sequence[float], predicted_mm: float
) -> tuple[float | None, float | None]:
    """Return how far off a map itself is, and what that stays below with 95 %.

    A point left out lies off by the map's error and its own scatter; their squares add up. The
    sum of the squares of n distances follows chi square with 2 n degrees. By chance less than
    nothing may be left: no less is stated than the covariance predicts.

    Args:
        distances_mm: Of the points left out.
        scatter_mm: What each would lie off (root mean square) if the map were perfect.
        predicted_mm: What the covariance says of the map.
    """
    if not distances_mm:
        return None, None
    found = float(np.mean(np.square(distances_mm)))
    own = float(np.mean(np.square(scatter_mm)))
    freedom = 2 * len(distances_mm)
    most = found * freedom / chi_square_quantile(0.05, freedom)
    left, upper = (math.sqrt(max(square - own, 0.0)) for square in (found, most))
    return max(left, predicted_mm), max(upper, predicted_mm)


def _fit_rms(points: Sequence[LeftOut]) -> float | None:
    if not points:
        return None
    return float(np.sqrt(np.mean([float(np.hypot(*p.residual_mm)) ** 2 for p in points])))


def _dense(found: ScreenFit, pictures: Mapping[str, str]) -> tuple[Sample, ...]:
    samples = []
    for name in found.given.cameras:
        focal = found.fit.parameters[found.given.offset(name)]
        height_mm = float(found.view(name).robot_from_camera.translation_mm[2])
        samples.append(
            Sample(
                label=f"{name}: places on the screen",
                measured=(float(len(found.given.seen[name])),),
                residual=(found.rms_px[name],),
                residual_mm=found.rms_px[name] * height_mm / float(focal),
                picture=pictures.get(name, ""),
            )
        )
    return tuple(samples)


def _points(
    points: Sequence[LeftOut], found: ScreenFit, pictures: Mapping[str, str]
) -> tuple[Sample, ...]:
    given: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {}
    for touch in found.given.touches:
        given[touch.label] = (touch.robot_mm, touch.place_px)
    for block in found.given.blocks:
        for camera, pixel in block.seen_px.items():
            label = block.label if len(block.seen_px) == 1 else f"{block.label} ({camera})"
            given[label] = (block.robot_mm, pixel)
    return tuple(
        Sample(
            label=point.label,
            given=given[point.label][0],
            measured=given[point.label][1],
            residual=point.residual_mm,
            residual_mm=float(np.hypot(*point.residual_mm)),
            held_out_mm=point.distance_mm,
            picture=pictures.get(point.label, ""),
        )
        for point in points
    )
