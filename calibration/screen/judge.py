"""What is wrong with a calibration by the screen, each mistake by its name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.playground import playground_grid
from calibration.screen import camera_model as model
from calibration.screen.decode import Correspondences, ScreenMap
from calibration.screen.held_out import LeftOut, left_out
from calibration.screen.joint_fit import Observations, ScreenFit, fit_screen
from calibration.statistics import chi_square_quantile
from calibration.verdict import Finding, Grade
from cell.devices.camera_features import CameraFeature
from cell.geometry import CameraView

Points = NDArray[np.float64]

DEMANDED_MM = 0.4
"""What the method promises, root mean square over the playground."""

_BAD_MM = 1.0
_MISFIT_PX = (0.6, 1.5)
_LEAST_COVERED = 0.85
_HIDDEN = 0.06
_SCALE_SURE = 4.0
_LEAST_SCALE = 0.003
_TURNED_DEG = 20.0
_AUTO: tuple[str, ...] = ("shutter", "gain", "exposure", "white_balance_red", "white_balance_blue")
_ODD_ONE = 4.0
_LEAST_SCATTER_MM = 0.1
_BAD_POINT_MM = 3.0


def judge_features(camera: str, features: Sequence[CameraFeature]) -> tuple[Finding, ...]:
    """Return what a camera adjusts by itself while patterns change under it."""
    auto = [f.name for f in features if f.control != "manual" and f.name in _AUTO]
    if not auto:
        return ()
    return (
        Finding(
            code="auto-exposure",
            grade=Grade.BAD,
            text=f"camera {camera} adjusts {', '.join(auto)} by itself: its levels change with "
            "every pattern",
            hint="set them by hand (`cell camera set`, or calibrate camera-settings) and begin "
            "again",
        ),
    )


def judge_map(camera: str, seen: ScreenMap, found: Correspondences) -> tuple[Finding, ...]:
    """Return what a camera's map of the screen says before anything is fitted."""
    if len(found) < 4:
        return ()
    findings = []
    a, *_ = np.linalg.lstsq(
        np.column_stack([found.pixels, np.ones(len(found))]), found.places, rcond=None
    )
    if np.linalg.det(a[:2]) < 0.0:
        findings.append(
            Finding(
                code="picture-mirrored",
                grade=Grade.BAD,
                text=f"camera {camera} sees the screen's picture mirrored",
                hint="switch off mirroring in the television's menu or in the camera's driver",
            )
        )
    hidden = hidden_share(seen)
    if hidden > _HIDDEN:
        findings.append(
            Finding(
                code="arm-in-picture",
                grade=Grade.DEGRADED,
                text=f"{100 * hidden:.0f} % of the screen that camera {camera} looks at show no "
                "pattern: the arm, blocks or something else lies over it",
                hint="bring the arm aside and clear the playground",
            )
        )
    return tuple(findings)


def hidden_share(seen: ScreenMap) -> float:
    """Return which share of the screen inside its hull in the picture is not read."""
    sure = cv2.morphologyEx(
        seen.is_sure.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)
    )
    points = cv2.findNonZero(sure)
    if points is None:
        return 1.0
    hull = np.zeros(sure.shape, np.uint8)
    cv2.fillConvexPoly(hull, cv2.convexHull(points), 1)
    return float(1.0 - sure[hull > 0].mean())


def judge_scale(given: Observations, views: dict[str, CameraView]) -> tuple[Finding, ...]:
    """Return whether distances on the screen are what its data sheet says, and its direction.

    Args:
        given: What was measured.
        views: Each camera in the screen's frame, fitted alone.
    """
    screen, robot, spread = _pairs(given, views)
    if len(screen) < 2:
        return ()
    a, b = screen - screen.mean(axis=0), robot - robot.mean(axis=0)
    a = a * (1.0, -1.0)
    along, across = float(np.sum(a * b)), float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    size = float(np.sum(a * a))
    scale = math.hypot(along, across) / size
    deviation = float(np.sqrt(np.mean(np.square(spread)))) / math.sqrt(size)
    angle_deg = math.degrees(math.atan2(across, along))
    findings = []
    if abs(scale - 1.0) > max(_SCALE_SURE * deviation, _LEAST_SCALE):
        pixel_mm = given.screen.pixel_mm
        findings.append(
            Finding(
                code="screen-scaled",
                grade=Grade.BAD,
                text=f"distances on the screen are {scale:.4f} ± {deviation:.4f} times what the "
                f"profile's display.pixel_mm = {pixel_mm:g} makes of them; a pixel would have "
                f"{scale * pixel_mm:.5f} mm",
                hint="switch off overscan (the television's picture size: dot by dot) and the "
                "browser's zoom, or correct display.pixel_mm if this is another panel",
            )
        )
    turned = math.remainder(angle_deg - given.screen.angle_deg, 360.0)
    if abs(turned) > _TURNED_DEG:
        findings.append(
            Finding(
                code="screen-turned",
                grade=Grade.BAD,
                text=f"the picture lies at {angle_deg % 360.0:.1f} deg in the robot frame, the "
                f"profile has display.angle_deg = {given.screen.angle_deg:g}",
                hint="correct display.angle_deg, or the picture's rotation in the desktop's "
                "settings",
            )
        )
    return tuple(findings)


def judge_fit(found: ScreenFit, points: Sequence[LeftOut]) -> tuple[Finding, ...]:
    """Return what the fit says."""
    findings = [f for name in found.given.cameras for f in _judge_camera(found, name)]
    if not found.given.touches and not found.given.blocks:
        findings.append(
            Finding(
                code="not-tied-to-robot",
                grade=Grade.DEGRADED,
                text="no point ties the screen to the robot: the screen's place is taken from the "
                "profile",
                hint="place blocks or touch points (way = blocks or touch)",
            )
        )
    return (*findings, *_judge_points(found, points))


def coverage(view: CameraView, seen: Correspondences, top_mm: float) -> float:
    """Return which share of the playground lies in the part of the picture that was measured.

    Args:
        view: The camera.
        seen: What it saw of the screen.
        top_mm: Height of the block tops.
    """
    hull = cv2.convexHull(seen.pixels.astype(np.float32))
    pixels = view.to_picture(playground_grid(9, 13), top_mm)
    inside = [
        cv2.pointPolygonTest(hull, (float(u), float(v)), True) > -16.0 for u, v in pixels.tolist()
    ]
    return float(np.mean(inside))


def _judge_camera(found: ScreenFit, name: str) -> list[Finding]:
    findings = []
    rms = found.rms_px[name]
    if rms > _MISFIT_PX[0]:
        findings.append(
            Finding(
                code="lens-misfit",
                grade=Grade.BAD if rms > _MISFIT_PX[1] else Grade.DEGRADED,
                text=f"camera {name} sees places of the screen {rms:.2f} px from where its lens "
                "and place would put them",
                hint="keep camera and screen still; if that was so, the lens needs more "
                "coefficients than k1 and k2, or the screen is not flat",
            )
        )
    view = found.view(name)
    covered = coverage(
        view, found.given.seen[name], found.given.screen.height_mm + found.given.top_mm
    )
    if covered < _LEAST_COVERED:
        findings.append(
            Finding(
                code="little-coverage",
                grade=Grade.DEGRADED,
                text=f"camera {name} saw the pattern in {100 * covered:.0f} % of its picture of "
                "the playground",
                hint="clear the screen and calibrate again, or turn the camera towards the screen",
            )
        )
    predicted = predicted_mm(found, name)
    if predicted[0] > DEMANDED_MM:
        focal, deviation = _focal(found, name)
        findings.append(
            Finding(
                code="depth-unknown" if deviation > 0.02 * focal else "inaccurate",
                grade=Grade.BAD if predicted[0] > _BAD_MM else Grade.DEGRADED,
                text=f"camera {name} would be {predicted[0]:.2f} mm off at the block tops (focal "
                f"length {focal:.0f} ± {deviation:.0f} px)",
                hint="one plane hardly tells how far away a camera is: place more blocks, or "
                "measure the height of its lens over the glass by tape",
            )
        )
    return findings


def predicted_mm(found: ScreenFit, camera: str) -> tuple[float, float]:
    """Return what the covariance predicts at the block tops of the playground.

    Returns:
        Root mean square in mm, and the half axis of the worst place's 95 % ellipse.
    """
    covariances = found.covariance_at(camera, playground_grid(), found.given.top_mm)
    spread = np.trace(covariances, axis1=1, axis2=2)
    axis = np.sqrt(np.linalg.eigvalsh(covariances)[:, -1] * chi_square_quantile(0.95, 2))
    return float(np.sqrt(spread.mean())), float(axis.max())


def _judge_points(found: ScreenFit, points: Sequence[LeftOut]) -> list[Finding]:
    worst = _worst(points)
    if worst is None:
        return []
    is_alone = _is_alone(found, worst)
    return [
        Finding(
            code="misplaced-point" if is_alone else "points-disagree",
            grade=Grade.BAD if worst.distance_mm > _BAD_POINT_MM else Grade.DEGRADED,
            text=f"{worst.label} lies {worst.distance_mm:.2f} mm from where all others put it; "
            f"{worst.expected_mm:.2f} mm along an axis would be usual",
            hint="see whether the block slipped, or the point was mistyped, and take it again"
            if is_alone
            else "see whether the table, the screen or the blocks were moved meanwhile",
            samples=(worst.label,),
        )
    ]


def _worst(points: Sequence[LeftOut]) -> LeftOut | None:
    """Return the point farthest off, None if none lies farther than it may."""
    odd = [p for p in points if p.distance_mm > _ODD_ONE * max(p.expected_mm, _LEAST_SCATTER_MM)]
    return max(odd, key=lambda p: p.distance_mm) if odd and len(points) > 2 else None


def _is_alone(found: ScreenFit, worst: LeftOut) -> bool:
    """Tell whether all others agree without a point."""
    given = found.given
    rest = replace(
        given,
        touches=[touch for touch in given.touches if touch.label != worst.label],
        blocks=[block for block in given.blocks if block.label != worst.label.split(" (")[0]],
    )
    return len(rest.touches) + len(rest.blocks) > 2 and _worst(left_out(fit_screen(rest))) is None


def _pairs(given: Observations, views: dict[str, CameraView]) -> tuple[Points, Points, list[float]]:
    screen, robot, spread = [], [], []
    for touch in given.touches:
        screen.append((np.array(touch.place_px) + 0.5) * given.screen.pixel_mm)
        robot.append(touch.robot_mm)
        spread.append(touch.deviation_mm)
    for block in given.blocks:
        for name, pixel in block.seen_px.items():
            screen.append(views[name].to_robot(np.array(pixel), -block.height_mm))
            robot.append(block.robot_mm)
            spread.append(block.deviation_mm)
    return np.array(screen).reshape(-1, 2), np.array(robot).reshape(-1, 2), spread


def screen_views(given: Observations, parameters: Points) -> dict[str, CameraView]:
    """Return each camera's view in the screen's frame."""
    return {
        name: CameraView(
            model.lens_of(given.camera(parameters, name)),
            model.screen_from_camera(given.camera(parameters, name)),
        )
        for name in given.cameras
    }


def _focal(found: ScreenFit, name: str) -> tuple[float, float]:
    first = found.given.offset(name)
    return float(found.fit.parameters[first]), math.sqrt(float(found.fit.covariance[first, first]))
