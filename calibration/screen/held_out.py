"""How far each placed block or touched point lies from a fit without it.

The fit is not repeated: leaving out a point changes the parameters, to first order, by
(N - JᵀC⁻¹J)⁻¹ JᵀC⁻¹ r with its slopes J, its residual r and its covariance C, N being the
information of all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.least_squares import Vector, differences
from calibration.screen.joint_fit import (
    SCREEN_NAMES,
    PlacedBlock,
    ScreenFit,
    Touch,
    place_in_robot,
)

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """One point and its distances.

    Attributes:
        label: Its name.
        residual_mm: Along robot x and y, from the fit with it.
        held_out_mm: Along robot x and y, from the fit without it.
        expected_mm: Standard deviation along an axis that its own scatter accounts for.
    """

    label: str
    residual_mm: tuple[float, float]
    held_out_mm: tuple[float, float]
    expected_mm: float

    @property
    def distance_mm(self) -> float:
        """How far it lies from the fit without it."""
        return float(np.hypot(*self.held_out_mm))


def left_out(found: ScreenFit) -> tuple[LeftOut, ...]:
    """Return every touched point and every block of each camera, left out one by one."""
    points = [_left_out_touch(found, touch) for touch in found.given.touches]
    for block in found.given.blocks:
        points += [_left_out_block(found, block, camera) for camera in block.seen_px]
    return tuple(points)


def _left_out_touch(found: ScreenFit, touch: Touch) -> LeftOut:
    place = np.array(touch.place_px)

    def off(parameters: Vector) -> Vector:
        return place_in_robot(found.given.place(parameters), place) - touch.robot_mm

    covariance = touch.deviation_mm**2 * np.eye(2)
    residual, without = _without(found, off, covariance)
    return LeftOut(
        label=touch.label,
        residual_mm=residual,
        held_out_mm=without,
        expected_mm=touch.deviation_mm,
    )


def _left_out_block(found: ScreenFit, block: PlacedBlock, camera: str) -> LeftOut:
    height_mm = found.given.screen.height_mm + block.height_mm
    pixel = np.array(block.seen_px[camera])

    def off(parameters: Vector) -> Vector:
        view = found.given.view(parameters, camera)
        return np.asarray(view.to_robot(pixel, height_mm) - block.robot_mm, np.float64)

    def at(pixels: Vector) -> Vector:
        return np.asarray(found.view(camera).to_robot(pixels, height_mm), np.float64)

    scale = differences(at, pixel)
    covariance = block.deviation_mm**2 * np.eye(2) + block.finding_px**2 * scale @ scale.T
    residual, without = _without(found, off, covariance)
    label = block.label if len(block.seen_px) == 1 else f"{block.label} ({camera})"
    return LeftOut(
        label=label,
        residual_mm=residual,
        held_out_mm=without,
        expected_mm=float(np.sqrt(0.5 * np.trace(covariance))),
    )


def _without(
    found: ScreenFit, off: Callable[[Vector], Vector], covariance: Points
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return a point's distances with it and without it in the fit."""
    parameters = found.fit.parameters
    count = len(SCREEN_NAMES) + 2 * len(found.given.blocks)
    # Where blocks really lie is not asked: what is left is the screen and the cameras.
    chosen = [*range(len(SCREEN_NAMES)), *range(count, parameters.size)]

    def part(values: Vector) -> Vector:
        changed = parameters.copy()
        changed[chosen] = values
        return off(changed)

    residual = off(parameters)
    slopes = differences(part, parameters[chosen])
    known = found.fit.covariance[np.ix_(chosen, chosen)]
    size = np.sqrt(np.diag(known))
    information = np.linalg.inv(known / np.outer(size, size))
    scaled = slopes * size
    inverse = np.linalg.inv(covariance)
    rest = information - scaled.T @ inverse @ scaled
    change = np.linalg.solve(rest, scaled.T @ inverse @ residual)
    without = residual + scaled @ change
    return (
        (float(residual[0]), float(residual[1])),
        (float(without[0]), float(without[1])),
    )
