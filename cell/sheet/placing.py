"""Where a sheet lies, fitted to the corners of its markers in pictures.

A point p of the plan lies in the robot frame at

    x = corner_x + s (cos a · p_x + sin a · p_y)
    y = corner_y + s (sin a · p_x - cos a · p_y)

with the sheet's angle a and the print's scale s. Gauss and Newton's method on the distances
in pixels; the covariance is σ² (JᵀJ)⁻¹ with σ² from the residuals, so it holds what the
pictures scatter and not what the cameras' own calibrations are off by.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cell.geometry import TableView
from cell.sheet.errors import SheetError

Points = NDArray[np.float64]

_STEPS = 15
_DONE = 1e-10


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sighting:
    """A marker seen by a camera.

    Attributes:
        index: Which of the sheet's markers it is.
        view: Where the picture lies in the robot frame.
        plan_mm: Its corners on the plan, (4, 2).
        pixels: Its corners in the picture, (4, 2).
    """

    index: int
    view: TableView
    plan_mm: Points
    pixels: Points


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SheetPlace:
    """Where a sheet lies.

    Attributes:
        corner_mm: Robot x, y of the plan's corner (0, 0).
        angle_deg: Angle from robot x to plan x, counter-clockwise.
        scale: Millimetres on the paper for each millimetre of the plan.
        covariance: Of corner x, corner y in mm and the angle in degrees, (3, 3); with a
            fitted scale as fourth, (4, 4). Not a number without more than is needed.
        sigma_px: Standard deviation of a marker's corner in the pictures.
        freedom: Residuals less parameters.
    """

    corner_mm: tuple[float, float]
    angle_deg: float
    scale: float
    covariance: Points
    sigma_px: float
    freedom: int

    def to_robot(self, plan_mm: Points) -> Points:
        """Return robot x, y (..., 2) of points of the plan (..., 2)."""
        angle = math.radians(self.angle_deg)
        parameters = np.array([*self.corner_mm, angle, self.scale])
        return _robot(parameters, plan_mm)

    def deviation_mm(self, plan_mm: Points) -> Points:
        """Return the standard deviation (n,) of where points of the plan (n, 2) lie."""
        angle = math.radians(self.angle_deg)
        slope = _slopes(np.array([*self.corner_mm, angle, self.scale]), plan_mm)
        slope = slope[..., : self.covariance.shape[0]]
        slope[..., 2] *= math.pi / 180.0
        spread = np.einsum("nik,kl,nil->n", slope, self.covariance, slope)
        return np.asarray(np.sqrt(spread))


def fit_place(
    sightings: Sequence[Sighting],
    surface_mm: float,
    *,
    scale: float | None = 1.0,
    start: SheetPlace | None = None,
) -> SheetPlace:
    """Return where the sheet lies.

    Args:
        sightings: The markers seen, in one picture or several.
        surface_mm: Height of the sheet above the robot's base plane.
        scale: The print's scale; None fits it, too.
        start: A place nearby, if one is known.

    Raises:
        SheetError: There is nothing to fit, or a view does not know the sheet's height.
    """
    if not sightings:
        raise SheetError("no marker of the sheet is in the pictures")
    try:
        looks = _by_view(sightings)
        parameters = _start(looks, surface_mm, scale) if start is None else _known(start, scale)
        count = 4 if scale is None else 3
        for _ in range(_STEPS):
            residuals, jacobian = _linear(looks, surface_mm, parameters, count)
            step = np.linalg.lstsq(jacobian, residuals, rcond=None)[0]
            parameters[:count] += step
            if np.abs(step).max() < _DONE:
                break
        residuals, jacobian = _linear(looks, surface_mm, parameters, count)
    except ValueError as error:
        raise SheetError(
            f"the camera's calibration does not tell where the sheet is: {error}"
        ) from error
    freedom = residuals.size - count
    sigma_squared = float(residuals @ residuals) / freedom
    covariance = sigma_squared * np.linalg.inv(jacobian.T @ jacobian)
    units = np.array([1.0, 1.0, 180.0 / math.pi, 1.0])[:count]
    return SheetPlace(
        corner_mm=(float(parameters[0]), float(parameters[1])),
        angle_deg=math.degrees(math.remainder(float(parameters[2]), math.tau)),
        scale=float(parameters[3]),
        covariance=np.asarray(covariance * np.outer(units, units), np.float64),
        sigma_px=math.sqrt(sigma_squared),
        freedom=freedom,
    )


def miss_mm(place: SheetPlace, sighting: Sighting, surface_mm: float) -> Points:
    """Return how far (4,) a marker's corners lie from where a place has them."""
    seen = sighting.view.to_robot(sighting.pixels, surface_mm)
    return np.asarray(np.linalg.norm(seen - place.to_robot(sighting.plan_mm), axis=-1))


def _robot(parameters: Points, plan: Points) -> Points:
    x, y, angle, scale = parameters
    cos, sin = scale * math.cos(angle), scale * math.sin(angle)
    return np.stack(
        [x + cos * plan[..., 0] + sin * plan[..., 1], y + sin * plan[..., 0] - cos * plan[..., 1]],
        axis=-1,
    )


def _slopes(parameters: Points, plan: Points) -> Points:
    """Return derivatives (n, 2, 4) of robot x, y by the parameters."""
    offset = _robot(np.array([0.0, 0.0, parameters[2], parameters[3]]), plan)
    slopes = np.zeros((*plan.shape, 4))
    slopes[..., 0, 0] = slopes[..., 1, 1] = 1.0
    slopes[..., 0, 2], slopes[..., 1, 2] = -offset[..., 1], offset[..., 0]
    slopes[..., :, 3] = offset / parameters[3]
    return slopes


def _known(start: SheetPlace, scale: float | None) -> Points:
    return np.array([*start.corner_mm, math.radians(start.angle_deg), scale or start.scale])


def _by_view(sightings: Sequence[Sighting]) -> tuple[Sighting, ...]:
    """Return the sightings with all corners of one view together, which maps them at once."""
    together: dict[int, list[Sighting]] = {}
    for one in sightings:
        together.setdefault(id(one.view), []).append(one)
    return tuple(
        replace(
            those[0],
            plan_mm=np.concatenate([one.plan_mm for one in those]),
            pixels=np.concatenate([one.pixels for one in those]),
        )
        for those in together.values()
    )


def _start(sightings: Sequence[Sighting], surface_mm: float, scale: float | None) -> Points:
    """Return the least-squares place by millimetres, which is linear with a free scale."""
    plan = np.concatenate([one.plan_mm for one in sightings])
    robot = np.concatenate([one.view.to_robot(one.pixels, surface_mm) for one in sightings])
    zero, one = np.zeros(len(plan)), np.ones(len(plan))
    rows_x = np.stack([one, zero, plan[:, 0], plan[:, 1]], axis=1)
    rows_y = np.stack([zero, one, -plan[:, 1], plan[:, 0]], axis=1)
    matrix = np.concatenate([rows_x, rows_y])
    target = np.concatenate([robot[:, 0], robot[:, 1]])
    x, y, cos, sin = np.linalg.lstsq(matrix, target, rcond=None)[0]
    return np.array([x, y, math.atan2(sin, cos), scale or math.hypot(cos, sin)])


def _linear(
    sightings: Sequence[Sighting], surface_mm: float, parameters: Points, count: int
) -> tuple[Points, Points]:
    """Return seen less expected pixels (n,) and the expected ones' slopes (n, count)."""
    residuals, slopes = [], []
    for one in sightings:
        points = _robot(parameters, one.plan_mm)
        expected = one.view.to_picture(points, surface_mm)
        by_robot = np.stack(
            [
                one.view.to_picture(points + offset, surface_mm)
                - one.view.to_picture(points - offset, surface_mm)
                for offset in (np.array([0.5, 0.0]), np.array([0.0, 0.5]))
            ],
            axis=-1,
        )
        residuals.append((one.pixels - expected).ravel())
        chain = by_robot @ _slopes(parameters, one.plan_mm)
        slopes.append(chain.reshape(-1, 4)[:, :count])
    return np.concatenate(residuals), np.concatenate(slopes)
