"""All cameras, the screen's place under the robot and the placed blocks, fitted together.

The dense places on the glass fix each camera up to what one plane cannot tell: how far away
a camera with a long lens is. The tops of placed blocks are a second height, and they and the
touched points tie the screen to the robot. Where a block really lies is fitted, too, so that
two cameras that see it do not count its scatter twice.

Parameters, in this order: corner x, corner y, angle of the screen; x and y of each block;
eleven numbers of each camera (`camera_model.NAMES`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.least_squares import Fit, Matrix, Vector, differences, fit
from calibration.screen import camera_model as model
from calibration.screen.camera_model import LensPrior
from calibration.screen.decode import Correspondences
from cell.geometry import CameraView, Transform

Points = NDArray[np.float64]

SCREEN_NAMES: Final = ("corner_x", "corner_y", "angle")
_SCREEN: Final = len(SCREEN_NAMES)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScreenPlace:
    """Where the screen lies, and how exactly that is known before anything is measured.

    Attributes:
        corner_mm: Robot x, y of the picture's upper left corner.
        angle_deg: Angle from robot X to the picture's rightward direction.
        height_mm: Height of the glass above the robot's base plane.
        pixel_mm: Size of a pixel, from the panel's data sheet.
        deviation_mm: How far off the corner may be; infinite if nothing shall be taken on
            trust.
        deviation_deg: How far off the angle may be.
    """

    corner_mm: tuple[float, float]
    angle_deg: float
    height_mm: float
    pixel_mm: float
    deviation_mm: float = math.inf
    deviation_deg: float = math.inf

    def robot_from_screen(self) -> Transform:
        """Return the frame of `camera_model` in the robot's."""
        angle = math.radians(self.angle_deg)
        right = np.array([math.cos(angle), math.sin(angle), 0.0])
        down = np.array([right[1], -right[0], 0.0])
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = right, down, (0.0, 0.0, -1.0)
        half = 0.5 * self.pixel_mm
        matrix[:3, 3] = np.array([*self.corner_mm, self.height_mm]) + half * (right + down)
        return Transform(matrix)


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """A place of the screen whose robot coordinates were read from the arm, or typed.

    Attributes:
        label: Its name.
        place_px: Column and row on the screen.
        robot_mm: Robot x and y.
        deviation_mm: How exactly a person or a tool meets it, along each axis.
    """

    label: str
    place_px: tuple[float, float]
    robot_mm: tuple[float, float]
    deviation_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedBlock:
    """A block that the arm put down and cameras found.

    Attributes:
        label: Its name.
        robot_mm: Robot x and y where it was put.
        height_mm: Height of its top above the glass.
        deviation_mm: How exactly blocks come to lie, along each axis.
        seen_px: u and v of its top's centre, by camera.
        finding_px: How exactly the centre is found, along each axis.
    """

    label: str
    robot_mm: tuple[float, float]
    height_mm: float
    deviation_mm: float
    seen_px: Mapping[str, tuple[float, float]]
    finding_px: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Observations:
    """Everything that was measured.

    Attributes:
        seen: What each camera sees of the screen.
        screen: What is known of the screen's place.
        touches: Touched points.
        blocks: Placed blocks.
        priors: What is known of the lenses; nothing but the default of those left out.
        top_mm: Height of block tops above the glass, where accuracy is stated.
    """

    seen: Mapping[str, Correspondences]
    screen: ScreenPlace
    top_mm: float = 33.0
    touches: Sequence[Touch] = ()
    blocks: Sequence[PlacedBlock] = ()
    priors: Mapping[str, LensPrior] = field(default_factory=dict)

    @property
    def cameras(self) -> tuple[str, ...]:
        """The cameras, in their order."""
        return tuple(self.seen)

    def prior(self, camera: str) -> LensPrior:
        """Return what is known of a camera's lens."""
        return self.priors.get(camera, LensPrior())

    def offset(self, camera: str) -> int:
        """Return the index of a camera's first parameter."""
        return _SCREEN + 2 * len(self.blocks) + model.COUNT * self.cameras.index(camera)

    def camera(self, parameters: Vector, name: str) -> Vector:
        """Return the eleven numbers of a camera."""
        first = self.offset(name)
        return parameters[first : first + model.COUNT]

    def place(self, parameters: Vector) -> ScreenPlace:
        """Return where the screen lies."""
        x, y, angle = (float(k) for k in parameters[:_SCREEN])
        return replace(self.screen, corner_mm=(x, y), angle_deg=math.degrees(angle))

    def view(self, parameters: Vector, name: str) -> CameraView:
        """Return a camera with lens and place in the robot frame."""
        camera = self.camera(parameters, name)
        robot_from_screen = self.place(parameters).robot_from_screen()
        return CameraView(
            model.lens_of(camera), robot_from_screen @ model.screen_from_camera(camera)
        )

    def names(self) -> tuple[str, ...]:
        """Return the parameters' names."""
        blocks = [f"{block.label} {axis}" for block in self.blocks for axis in ("x", "y")]
        cameras = [f"{camera} {name}" for camera in self.cameras for name in model.NAMES]
        return (*SCREEN_NAMES, *blocks, *cameras)

    def units(self) -> tuple[str, ...]:
        """Return the parameters' units."""
        blocks = ["mm"] * (2 * len(self.blocks))
        return ("mm", "mm", "rad", *blocks, *(model.UNITS * len(self.cameras)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScreenFit:
    """What came out.

    Attributes:
        given: What was measured.
        fit: Parameters, covariance, residuals.
        rms_px: Of each camera's dense places.
        deviation_px: What they were taken to scatter by, camera by camera.
    """

    given: Observations
    fit: Fit
    rms_px: Mapping[str, float]
    deviation_px: Mapping[str, float]

    def view(self, camera: str) -> CameraView:
        """Return a camera with lens and place."""
        return self.given.view(self.fit.parameters, camera)

    def place(self) -> ScreenPlace:
        """Return where the screen lies."""
        return self.given.place(self.fit.parameters)

    def lens_covariance(self, camera: str) -> Points:
        """Return a lens's covariance (9, 9) in the order of `calibration.lens.fit.NAMES`.

        Pixels are taken as square and p1, p2, k3 as 0: the first two rows are the same, those
        of the last three zero.
        """
        # Rows of `camera_model.NAMES`: one focal length, centre u, centre v, k1, k2.
        spread = np.zeros((9, 5))
        spread[[0, 1, 2, 3, 4, 5], [0, 0, 1, 2, 3, 4]] = 1.0
        chosen = [self.given.offset(camera) + k for k in range(5)]
        own = self.fit.covariance[np.ix_(chosen, chosen)]
        return np.asarray(spread @ own @ spread.T)

    def covariance_at(self, camera: str, points_mm: Points, above_glass_mm: float) -> Points:
        """Return the covariance (n, 2, 2) of robot x, y where a camera sees points (n, 2)."""
        height_mm = self.given.screen.height_mm + above_glass_mm
        pixels = self.view(camera).to_picture(points_mm, height_mm)
        chosen = [*range(_SCREEN), *(self.given.offset(camera) + k for k in range(model.COUNT))]

        def mapped(part: Vector) -> Vector:
            parameters = self.fit.parameters.copy()
            parameters[chosen] = part
            return self.given.view(parameters, camera).to_robot(pixels, height_mm).ravel()

        slopes = differences(mapped, self.fit.parameters[chosen]).reshape(len(points_mm), 2, -1)
        covariance = self.fit.covariance[np.ix_(chosen, chosen)]
        return np.asarray(np.einsum("nik,kl,njl->nij", slopes, covariance, slopes))


_CONDENSED: Final = 400
LEAST_DEVIATION_PX: Final = 0.05
"""Dense places lie closer to a fit than the model is true; no better is believed."""


def fit_screen(given: Observations) -> ScreenFit:
    """Fit everything.

    Raises:
        FitFailed: A camera sees too little of the screen, or nothing ties it to the robot.
    """
    start = [*given.screen.corner_mm, math.radians(given.screen.angle_deg)]
    for block in given.blocks:
        start += block.robot_mm
    deviation: dict[str, float] = {}
    condensed: dict[str, _Condensed] = {}
    for name, seen in given.seen.items():
        found = model.fit_alone(seen, given.screen.pixel_mm, given.prior(name), LEAST_DEVIATION_PX)
        off = found.residuals[: 2 * len(seen)] * LEAST_DEVIATION_PX
        deviation[name] = max(float(np.sqrt(np.mean(off**2))), LEAST_DEVIATION_PX)
        condensed[name] = _condensed(seen, found.parameters, given.screen.pixel_mm, deviation[name])
        start += found.parameters.tolist()
    problem = _Problem(given, condensed)
    begin = np.array(start)
    begin[:_SCREEN] = problem.first_guess(begin)
    result = fit(
        problem.residuals, begin, jacobian=problem.jacobian, is_noise_known=True, tolerance=1e-8
    )
    rms = {name: _rms_px(given, result.parameters, name) for name in given.cameras}
    return ScreenFit(given=given, fit=result, rms_px=rms, deviation_px=deviation)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Condensed:
    """Neighbouring places of the screen, averaged.

    Attributes:
        points: Their middles on the glass, screen frame, (n, 3).
        pixels: Where they are seen, (n, 2).
        deviation_px: Standard deviation of each along an axis, (n, 1).
    """

    points: Points
    pixels: Points
    deviation_px: Points


def _condensed(
    seen: Correspondences, camera: Vector, pixel_mm: float, deviation_px: float
) -> _Condensed:
    """Return places averaged over squares of the picture.

    What is averaged are distances from a camera that fits already: the bend of lens and
    perspective within a square cancels, and no information is lost.
    """
    points = model.on_glass(seen.places, pixel_mm)
    off = seen.pixels - model.project(camera, points)
    side = max(np.sqrt(np.prod(np.ptp(seen.pixels, axis=0)) / _CONDENSED), 1.0)
    column, row = (seen.pixels // side).astype(int).T
    _, group = np.unique(row * 100_000 + column, return_inverse=True)
    count = np.bincount(group).astype(np.float64)

    def mean(values: Points) -> Points:
        sums = [np.bincount(group, values[:, k]) for k in range(values.shape[1])]
        return np.asarray(np.stack(sums, axis=1) / count[:, None])

    middles = mean(points)
    return _Condensed(
        points=middles,
        pixels=model.project(camera, middles) + mean(off),
        deviation_px=deviation_px / np.sqrt(count)[:, None],
    )


def _rms_px(given: Observations, parameters: Vector, name: str) -> float:
    """Return the distance of a camera's places from where the fit puts them, along an axis."""
    seen = given.seen[name]
    points = model.on_glass(seen.places, given.screen.pixel_mm)
    off = model.project(given.camera(parameters, name), points) - seen.pixels
    return float(np.sqrt(np.mean(off**2)))


class _Problem:
    """Residuals in standard deviations, and their slopes camera by camera."""

    def __init__(self, given: Observations, dense: Mapping[str, _Condensed]) -> None:
        self._given = given
        self._condensed = dense

    def residuals(self, parameters: Vector) -> Vector:
        dense = [self.dense(parameters, name) for name in self._given.cameras]
        return np.concatenate([*dense, self._sparse(parameters)])

    def jacobian(self, parameters: Vector) -> Matrix:
        parts = []
        for name in self._given.cameras:
            slopes = differences(
                lambda camera, name=name: self._dense(camera, name),  # type: ignore[misc]
                self._given.camera(parameters, name),
            )
            wide = np.zeros((len(slopes), parameters.size))
            first = self._given.offset(name)
            wide[:, first : first + model.COUNT] = slopes
            parts.append(wide)
        return np.concatenate([*parts, differences(self._sparse, parameters)])

    def dense(self, parameters: Vector, name: str) -> Vector:
        return self._dense(self._given.camera(parameters, name), name)

    def first_guess(self, parameters: Vector) -> Vector:
        """Return the screen's place that fits touched points and blocks best (Procrustes).

        The blocks are taken to lie where the first camera that saw one sees it.
        """
        screen, robot = [], []
        pixel_mm = self._given.screen.pixel_mm
        for touch in self._given.touches:
            screen.append((np.array(touch.place_px) + 0.5) * pixel_mm)
            robot.append(touch.robot_mm)
        for block in self._given.blocks:
            name = next(iter(block.seen_px), None)
            if name is not None:
                camera = self._given.camera(parameters, name)
                view = CameraView(model.lens_of(camera), model.screen_from_camera(camera))
                seen = view.to_robot(np.array(block.seen_px[name]), -block.height_mm)
                screen.append(seen + 0.5 * pixel_mm)
                robot.append(block.robot_mm)
        if len(robot) < 2:
            return parameters[:_SCREEN]
        return _procrustes(np.array(screen), np.array(robot))

    def _dense(self, camera: Vector, name: str) -> Vector:
        dense = self._condensed[name]
        off = model.project(camera, dense.points) - dense.pixels
        return np.asarray((off / dense.deviation_px).ravel())

    def _sparse(self, parameters: Vector) -> Vector:
        given = self._given
        place = given.place(parameters)
        screen_from_robot = place.robot_from_screen().inverse()
        parts = [
            given.prior(name).residuals(given.camera(parameters, name)) for name in given.cameras
        ]
        for index, block in enumerate(given.blocks):
            first = _SCREEN + 2 * index
            lies = parameters[first : first + 2]
            parts.append((lies - block.robot_mm) / block.deviation_mm)
            top = np.array([*lies, given.screen.height_mm + block.height_mm])
            in_screen = screen_from_robot.rotation @ top + screen_from_robot.translation_mm
            for name, pixel in block.seen_px.items():
                seen = model.project(given.camera(parameters, name), in_screen[None])[0]
                parts.append((seen - pixel) / block.finding_px)
        for touch in given.touches:
            lies = place_in_robot(place, np.array(touch.place_px))
            parts.append((lies - touch.robot_mm) / touch.deviation_mm)
        parts.append(self._trust(parameters))
        return np.concatenate(parts)

    def _trust(self, parameters: Vector) -> Vector:
        """Return how far the screen's place is off what was known of it before."""
        known = self._given.screen
        if not math.isfinite(known.deviation_mm):
            return np.empty(0)
        off_mm = (parameters[:2] - known.corner_mm) / known.deviation_mm
        turned = math.remainder(float(parameters[2]) - math.radians(known.angle_deg), math.tau)
        return np.append(off_mm, turned / math.radians(known.deviation_deg))


def place_in_robot(screen: ScreenPlace, places: Points) -> Points:
    """Return robot x, y (..., 2) of columns and rows (..., 2) of the screen."""
    frame = screen.robot_from_screen()
    flat = np.asarray(places, np.float64) * screen.pixel_mm
    return np.asarray(flat @ frame.rotation[:2, :2].T + frame.translation_mm[:2])


def _procrustes(screen: Points, robot: Points) -> Vector:
    """Return corner x, y and angle that bring points (n, 2) over robot points (n, 2)."""
    flipped = screen * (1.0, -1.0)
    a, b = flipped - flipped.mean(axis=0), robot - robot.mean(axis=0)
    angle = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    cos, sin = math.cos(angle), math.sin(angle)
    turned = flipped @ np.array([[cos, sin], [-sin, cos]])
    corner = robot.mean(axis=0) - turned.mean(axis=0)
    return np.array([*corner.tolist(), angle])
