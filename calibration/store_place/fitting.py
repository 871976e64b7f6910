"""Where a sheet lies, from the robot coordinates of some of its corners.

A touched corner is off as much in x as in y, so the rigid motion with the least sum of squares
has a closed form (Umeyama 1991, in the plane); its covariance σ² (JᵀJ)⁻¹ comes from how exactly
corners are touched.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed

Points = NDArray[np.float64]

CORNERS = ("upper left", "upper right", "lower right", "lower left")
"""The order in which corners are touched: clockwise, as on a sheet read from above."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Touched:
    """Corners of a sheet in the robot frame.

    Attributes:
        size_mm: Width and height of the sheet as it is drawn.
        scale: Millimetres on the paper for each of the drawing.
        points_mm: Robot x, y of 2, 3 or 4 corners in the order of `CORNERS`, (n, 2).
        noise_mm: Standard deviation of a touch in each direction.
    """

    size_mm: tuple[float, float]
    scale: float
    points_mm: Points
    noise_mm: float

    @property
    def plan_mm(self) -> Points:
        """The same corners on the drawing, (n, 2)."""
        wide, tall = self.size_mm
        corners = np.array([(0.0, 0.0), (wide, 0.0), (wide, tall), (0.0, tall)])
        return corners[: len(self.points_mm)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaceFit:
    """Where the sheet lies.

    Attributes:
        corner_mm: Robot x, y of the plan's corner (0, 0).
        angle_deg: Angle from robot x to plan x, counter-clockwise.
        covariance: Of corner x, corner y (mm) and angle (deg), (3, 3).
        residuals_mm: Touched less fitted, (n, 2).
        held_out_mm: Distance of each corner from a fit without it; empty with two corners.
    """

    corner_mm: tuple[float, float]
    angle_deg: float
    covariance: Points
    residuals_mm: Points
    held_out_mm: tuple[float, ...]


def fit_corners(touched: Touched) -> PlaceFit:
    """Fit the sheet's place to touched corners.

    Raises:
        FitFailed: Fewer than two corners, or all at one point.
    """
    if len(touched.points_mm) < 2:
        raise FitFailed("one corner does not tell how the sheet is turned; touch two at least")
    plan = touched.plan_mm * touched.scale
    spread = float(np.ptp(touched.points_mm, axis=0).max())
    if spread < 1.0:
        raise FitFailed(
            f"the corners were touched within {spread:.1f} mm of each other; touch different ones"
        )
    parameters, covariance = _fitted(plan, touched.points_mm, touched.noise_mm)
    count = len(plan)
    held_out = []
    for index in range(count if count > 2 else 0):
        rest = [other for other in range(count) if other != index]
        without, _ = _fitted(plan[rest], touched.points_mm[rest], touched.noise_mm)
        miss = touched.points_mm[index] - placed(without, plan[index])
        held_out.append(float(np.linalg.norm(miss)))
    return PlaceFit(
        corner_mm=(float(parameters[0]), float(parameters[1])),
        angle_deg=math.degrees(math.remainder(math.radians(float(parameters[2])), math.tau)),
        covariance=covariance,
        residuals_mm=touched.points_mm - placed(parameters, plan),
        held_out_mm=tuple(held_out),
    )


def placed(parameters: Points, plan_mm: Points) -> Points:
    """Return robot x, y (..., 2) of points of the paper: corner x, y (mm) and angle (deg)."""
    x, y, angle_deg = parameters
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return np.stack(
        [
            x + cos * plan_mm[..., 0] + sin * plan_mm[..., 1],
            y + sin * plan_mm[..., 0] - cos * plan_mm[..., 1],
        ],
        axis=-1,
    )


def deviations_mm(covariance: Points, angle_deg: float, plan_mm: Points) -> Points:
    """Return the standard deviation (n,), x and y together, of points of the paper (n, 2)."""
    slopes = _slopes(angle_deg, plan_mm)
    return np.asarray(np.sqrt(np.einsum("nik,kl,nil->n", slopes, covariance, slopes)))


def _fitted(plan: Points, points: Points, noise_mm: float) -> tuple[Points, Points]:
    """Return corner x, y, angle in degrees, and their covariance."""
    centre_plan, centre = plan.mean(axis=0), points.mean(axis=0)
    flipped = (plan - centre_plan) * np.array([1.0, -1.0])
    seen = points - centre
    cross = float((flipped[:, 0] * seen[:, 1] - flipped[:, 1] * seen[:, 0]).sum())
    angle = math.degrees(math.atan2(cross, float((flipped * seen).sum())))
    corner = centre - placed(np.array([0.0, 0.0, angle]), centre_plan)
    slopes = _slopes(angle, plan).reshape(-1, 3)
    covariance = noise_mm**2 * np.linalg.inv(slopes.T @ slopes)
    return np.array([*corner, angle]), np.asarray(covariance, np.float64)


def _slopes(angle_deg: float, plan: Points) -> Points:
    """Return derivatives (n, 2, 3) of robot x, y by corner x, corner y and angle in degrees."""
    offset = placed(np.array([0.0, 0.0, angle_deg]), plan) * math.pi / 180.0
    slopes = np.zeros((len(plan), 2, 3))
    slopes[:, 0, 0] = slopes[:, 1, 1] = 1.0
    slopes[:, 0, 2], slopes[:, 1, 2] = -offset[:, 1], offset[:, 0]
    return slopes


def distances_mm(points_mm: Sequence[Sequence[float]] | Points) -> Points:
    """Return the distances (n - 1,) from each point to the next."""
    steps = np.diff(np.asarray(points_mm, np.float64), axis=0)
    return np.asarray(np.linalg.norm(steps, axis=1))
