"""Where a camera stands, from pairs at a known height, its lens being known.

Six parameters instead of the homography's eight, so that four pairs leave two residuals;
and the map holds at every height. The lens's own uncertainty goes into what is stated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.homography.dlt import homography
from calibration.homography.noise import PairNoise, whitener
from calibration.least_squares import fit
from calibration.statistics import region_factor
from cell.geometry import CameraView, LensModel, Transform

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

PARAMETERS = 6
LENS_NAMES = (
    "focal_u_px",
    "focal_v_px",
    "centre_u_px",
    "centre_v_px",
    "k1",
    "k2",
    "p1",
    "p2",
    "k3",
)
"""Order of the lens's parameters in a covariance."""
_LENS_STEPS = (0.1, 0.1, 0.1, 0.1, 1e-4, 1e-4, 1e-5, 1e-5, 1e-4)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlaceFit:
    """Where a camera stands.

    Attributes:
        view: Lens and place.
        height_mm: Height of the pairs.
        covariance: Of rotation vector (rad, of camera-from-robot, applied after the fitted
            rotation) and translation (mm, of camera-from-robot), then of the lens's
            parameters in the order of `LENS_NAMES`, shape (15, 15).
        freedom: None: the noise was stated.
        residuals_mm: Fitted less given robot points at that height, shape (n, 2).
        noise_ratio: Spread of the residuals as a multiple of the stated noise.
    """

    view: CameraView
    height_mm: float
    covariance: Matrix
    freedom: None
    residuals_mm: Points
    noise_ratio: float | None

    def to_robot(self, pixels: Points) -> Points:
        """Return robot x, y in mm (n, 2) of pixels (n, 2) at the height of the pairs."""
        return self.view.to_robot(pixels, self.height_mm)

    def to_picture(self, points_mm: Points) -> Points:
        """Return pixels (n, 2) of robot points (n, 2) at the height of the pairs."""
        return self.view.to_picture(points_mm, self.height_mm)

    def covariance_at(self, pixels: Points, height_mm: float | None = None) -> Matrix:
        """Return the covariances (n, 2, 2), in mm², of where pixels are mapped to."""
        height = self.height_mm if height_mm is None else height_mm
        slopes = []
        for change in _changes(self.view):
            up, down = change(1.0), change(-1.0)
            slopes.append(up.to_robot(pixels, height) - down.to_robot(pixels, height))
        steps = np.array([2.0 * step for step in (*_PLACE_STEPS, *_LENS_STEPS)])
        slope = np.stack(slopes, axis=-1) / steps
        return np.asarray(slope @ self.covariance @ slope.transpose(0, 2, 1))

    def region_factor(self, dimensions: int, probability: float = 0.95) -> float:
        """Return the squared Mahalanobis distance that bounds regions of a probability."""
        return region_factor(dimensions, self.freedom, probability)


_PLACE_STEPS = (1e-5, 1e-5, 1e-5, 1e-2, 1e-2, 1e-2)


def fit_place(
    pixels: Points,
    points_mm: Points,
    height_mm: float,
    lens: LensModel,
    noise: PairNoise,
    lens_covariance: Matrix | None = None,
) -> PlaceFit:
    """Fit where a camera stands.

    Args:
        pixels: u, v as seen, shape (n, 2), n ≥ 4.
        points_mm: Robot x, y, shape (n, 2).
        height_mm: Height of the points.
        lens: The camera's lens.
        noise: How exactly the pairs are known.
        lens_covariance: Of the lens's parameters in the order of `LENS_NAMES`, (9, 9); None
            takes the lens for exact.

    Raises:
        FitFailed: The pairs do not determine it.
    """
    start = _start(lens, pixels, points_mm, height_mm)
    white = whitener(noise.in_picture(_robot_slopes(start, points_mm, height_mm)))
    base = start.robot_from_camera.inverse()

    def view(parameters: Points) -> CameraView:
        return CameraView(lens, _moved(base, parameters).inverse())

    def residuals(parameters: Points) -> Points:
        try:
            miss = view(parameters).to_picture(points_mm, height_mm) - pixels
        except ValueError:
            return np.full(pixels.size, np.inf)
        return np.asarray((white @ miss[..., None]).ravel())

    found = fit(residuals, np.zeros(PARAMETERS), is_noise_known=True, steps=30)
    best = view(found.parameters)
    # About the fitted place the parameters are small again, and so are their covariances.
    slopes = _slopes(best, points_mm, height_mm)
    place = (white @ slopes[..., :PARAMETERS]).reshape(-1, PARAMETERS)
    optics = (white @ slopes[..., PARAMETERS:]).reshape(-1, len(LENS_NAMES))
    inverse = np.linalg.inv(place.T @ place)
    sigma = np.zeros((9, 9)) if lens_covariance is None else lens_covariance
    gain = -inverse @ place.T @ optics
    covariance = np.block(
        [[inverse + gain @ sigma @ gain.T, gain @ sigma], [sigma @ gain.T, sigma]]
    )
    freedom = found.freedom
    return PlaceFit(
        view=best,
        height_mm=height_mm,
        covariance=covariance,
        freedom=None,
        residuals_mm=best.to_robot(pixels, height_mm) - points_mm,
        noise_ratio=float(np.sqrt(found.residuals @ found.residuals / freedom)),
    )


def place_parameters(
    fit: PlaceFit,
) -> tuple[tuple[str, ...], tuple[str, ...], Points, Matrix]:
    """Return names, units, values and covariance (6, 6) of a place: position and A, B, C."""
    values = _pose_values(fit.view)
    columns = []
    for index in range(PARAMETERS):
        change = _Change(fit.view, index)
        moved = _pose_values(change(1.0)) - _pose_values(change(-1.0))
        moved[3:] = (moved[3:] + 180.0) % 360.0 - 180.0
        columns.append(moved / (2.0 * _PLACE_STEPS[index]))
    slope = np.stack(columns, axis=1)
    covariance = slope @ fit.covariance[:PARAMETERS, :PARAMETERS] @ slope.T
    names = ("x", "y", "z", "a", "b", "c")
    return names, ("mm",) * 3 + ("deg",) * 3, values, np.asarray(covariance)


def _pose_values(view: CameraView) -> Points:
    pose = view.robot_from_camera.to_pose()
    return np.array([pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg])


def _start(lens: LensModel, pixels: Points, points_mm: Points, height_mm: float) -> CameraView:
    """Return the place that a homography of undistorted pixels tells (Zhang 2000, 3.1)."""
    directions = lens.to_directions(pixels)
    matrix = homography(points_mm, directions)
    scale = 2.0 / (np.linalg.norm(matrix[:, 0]) + np.linalg.norm(matrix[:, 1]))
    # The points are in front of the camera.
    middle = np.append(points_mm.mean(axis=0), 1.0)
    if matrix[2] @ middle < 0:
        scale = -scale
    first, second, shift = (matrix * scale).T
    left, _, right = np.linalg.svd(np.stack([first, second, np.cross(first, second)], axis=1))
    rotation = left @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(left @ right)))]) @ right
    camera_from_robot = np.eye(4)
    camera_from_robot[:3, :3] = rotation
    camera_from_robot[:3, 3] = shift - rotation[:, 2] * height_mm
    view = CameraView(lens, Transform(camera_from_robot).inverse())
    if view.robot_from_camera.translation_mm[2] <= height_mm:
        raise FitFailed(
            "seen so, the camera would stand below the table: the pairs are in a mirrored order"
        )
    return view


def _moved(base: Transform, change: Points) -> Transform:
    """Return camera-from-robot, turned by a rotation vector (rad) and shifted (mm)."""
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(change[:3]) @ base.rotation
    matrix[:3, 3] = base.translation_mm + change[3:6]
    return Transform(matrix)


def _rotation(vector: Points) -> Matrix:
    """Return the rotation of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    first = math.sin(angle) / angle if angle > 1e-9 else 1.0
    second = (1.0 - math.cos(angle)) / angle**2 if angle > 1e-6 else 0.5
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)


def _changes(view: CameraView) -> list[_Change]:
    return [_Change(view, index) for index in range(PARAMETERS + len(LENS_NAMES))]


@dataclass(frozen=True, slots=True)
class _Change:
    """One parameter of a view, to be moved by so many of its steps."""

    view: CameraView
    index: int

    def __call__(self, steps: float) -> CameraView:
        if self.index < PARAMETERS:
            change = np.zeros(PARAMETERS)
            change[self.index] = steps * _PLACE_STEPS[self.index]
            base = self.view.robot_from_camera.inverse()
            return CameraView(self.view.lens, _moved(base, change).inverse())
        values = lens_values(self.view.lens)
        at = self.index - PARAMETERS
        values[at] += steps * _LENS_STEPS[at]
        return CameraView(with_values(self.view.lens, values), self.view.robot_from_camera)


def lens_values(lens: LensModel) -> Points:
    """Return a lens's parameters in the order of `LENS_NAMES`."""
    return np.array(
        [
            lens.focal_u_px, lens.focal_v_px, lens.centre_u_px, lens.centre_v_px,
            lens.k1, lens.k2, lens.p1, lens.p2, lens.k3,
        ]
    )  # fmt: skip


def with_values(lens: LensModel, values: Points) -> LensModel:
    """Return a lens over the same sensor with parameters in the order of `LENS_NAMES`."""
    focal_u, focal_v, centre_u, centre_v, k1, k2, p1, p2, k3 = (float(v) for v in values)
    return LensModel(
        width_px=lens.width_px,
        height_px=lens.height_px,
        focal_u_px=focal_u,
        focal_v_px=focal_v,
        centre_u_px=centre_u,
        centre_v_px=centre_v,
        k1=k1,
        k2=k2,
        p1=p1,
        p2=p2,
        k3=k3,
    )


def _slopes(view: CameraView, points_mm: Points, height_mm: float) -> Matrix:
    """Return d (u, v) / d parameters, shape (n, 2, 15)."""
    steps = (*_PLACE_STEPS, *_LENS_STEPS)
    columns = []
    for change, step in zip(_changes(view), steps, strict=True):
        up, down = change(1.0), change(-1.0)
        moved = up.to_picture(points_mm, height_mm) - down.to_picture(points_mm, height_mm)
        columns.append(moved / (2.0 * step))
    return np.stack(columns, axis=-1)


def _robot_slopes(view: CameraView, points_mm: Points, height_mm: float) -> Matrix:
    """Return d (u, v) / d (x, y), shape (n, 2, 2)."""
    columns = []
    for step in (np.array([0.5, 0.0]), np.array([0.0, 0.5])):
        up = view.to_picture(points_mm + step, height_mm)
        columns.append(up - view.to_picture(points_mm - step, height_mm))
    return np.stack(columns, axis=-1)
