"""The five parameters of an eye in hand together, from many looks at one point.

The point's own place is fitted along and thrown away. What the samples can tell apart:

- In looks alone link 2 and the part of the camera's offset along it are one sum, since both
  turn with J1 + J2: only the gripper over the point (a touch) parts them.
- The picture's turn, angle_error, is seen from a point that falls on different pixels, as it
  does whenever the arm stands otherwise: only one pose has it on a given pixel. A line whose
  direction nobody knows says nothing about it, however often it is looked at: turn and
  direction are one sum. A line of known direction does.
- The camera's offset is parted from the point's place by turning J1 + J2, link 1 from both by
  turning J2.

What the samples do not tell is held at the value that was known before, and said to be.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.eye_in_hand.samples import Samples, joints_of
from calibration.least_squares import Fit, fit
from calibration.statistics import mahalanobis_squared, region_factor
from cell.geometry.eye_in_hand import EyeInHand, direction, turned

Array = NDArray[np.float64]

NAMES: Final = ("d_t_c", "b_angle", "angle_error", "link_1", "link_2")
UNITS: Final = ("mm", "deg", "deg", "mm", "mm")
_FIELDS: Final = ("d_t_c_mm", "b_angle_deg", "angle_error_deg", "link_1_mm", "link_2_mm")
_PER_DEG: Final = np.pi / 180.0
UNSEEN: Final = np.array([10.0, 10.0, 10.0, 10.0, 10.0])
"""A parameter whose predicted standard deviation (mm, deg) is above this is not seen at all."""
_HOLD: Final = ((), (4,), (2,), (2, 4), (3,), (3, 4), (2, 3), (2, 3, 4))
"""What to hold, in the order in which it is tried."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EyeFit:
    """A refined eye in hand.

    Attributes:
        eye: With the fitted parameters.
        point_mm: Where the looked-at point lies.
        covariance: Of the five parameters in the order of `NAMES`, shape (5, 5); zero in rows
            and columns of held ones.
        held: Names of the parameters that the samples do not tell.
        fit: The fit; its residuals are in standard deviations: looks (column, row), touches
            (x, y), lines.
        information: Inverse of the covariance of all that was fitted at the stated noise.
        free: Indices of the fitted ones among parameters, point and line.
        look_unit_mm: A look's stated standard deviation on the table, right and up, shape (2,).
    """

    eye: EyeInHand
    point_mm: tuple[float, float]
    covariance: Array
    held: tuple[str, ...]
    fit: Fit
    information: Array
    free: tuple[int, ...]
    look_unit_mm: Array

    @property
    def parameters(self) -> Array:
        """The five, in the order of `NAMES`."""
        return parameters_of(self.eye)

    @property
    def noise_factor(self) -> float:
        """How much larger the noise is than stated."""
        return float(np.sqrt(self.fit.scale))

    def holds(self, truth: EyeInHand, probability: float = 0.95) -> bool:
        """Return whether the joint region of the fitted parameters contains a truth."""
        at = [i for i in self.free if i < len(NAMES)]
        offset = parameters_of(truth)[at] - self.parameters[at]
        distance = mahalanobis_squared(offset, self.covariance[np.ix_(at, at)])
        return distance <= region_factor(len(at), self.fit.freedom, probability)


def parameters_of(eye: EyeInHand) -> Array:
    """Return the five parameters, in the order of `NAMES`."""
    return np.array(
        [eye.d_t_c_mm, eye.b_angle_deg, eye.angle_error_deg, eye.link_1_mm, eye.link_2_mm]
    )


def with_parameters(eye: EyeInHand, values: Array) -> EyeInHand:
    """Return an eye with other five parameters."""
    d_t_c, b_angle, angle_error, link_1, link_2 = (float(value) for value in values[:5])
    return replace(
        eye,
        d_t_c_mm=d_t_c,
        b_angle_deg=b_angle,
        angle_error_deg=angle_error,
        link_1_mm=link_1,
        link_2_mm=link_2,
    )


class _Model:
    """Residuals and slopes, in standard deviations, of the five, the point and the line."""

    def __init__(self, samples: Samples, eye: EyeInHand, height_mm: float) -> None:
        self._eye = eye
        noise = samples.noise
        self.joints = samples.look_joints
        self.both = self.joints.sum(axis=1)
        self.seen = eye.ahead_mm(samples.pixels, height_mm=height_mm)
        pixel = np.array([eye.scale_u_mm, eye.scale_v_mm])
        shrink = 1.0 - height_mm / eye.camera_height_mm
        self.unit = 1.0 / (pixel * shrink * noise.look_px)
        self.touches = samples.touch_joints
        self.touch_unit = 1.0 / noise.touch_mm
        self.lines = samples.lines
        line_joints = joints_of(samples.lines).sum(axis=1)
        self.line_sum = line_joints + [line.alpha_deg for line in samples.lines]
        self.known = np.array(
            [np.nan if line.direction_deg is None else line.direction_deg for line in self.lines]
        )
        self.line_unit = 1.0 / noise.line_deg
        self.needs_line = bool(np.isnan(self.known).any())

    @property
    def count(self) -> int:
        """How many parameters there are with the point and the line."""
        return 8 if self.needs_line else 7

    def residuals(self, p: Array) -> Array:
        """Return (2 looks + 2 touches + lines,)."""
        looks = (self._ahead(p) - self.seen) * self.unit
        touched = (self._gripper(p, self.touches) - p[5:7]) * self.touch_unit
        return np.concatenate([looks.ravel(), touched.ravel(), self._line_residuals(p)])

    def slopes(self, p: Array) -> Array:
        """Return the Jacobian of `residuals`, shape (n, count)."""
        looks, touches = len(self.joints), len(self.touches)
        matrix = np.zeros((2 * (looks + touches) + len(self.lines), p.size))
        back = p[2] - 180.0 - self.both
        towards = self.both + p[1] - 180.0
        ahead = self._ahead(p)
        columns = [
            -turned(direction(towards), back),
            -p[0] * _PER_DEG * turned(direction(towards + 90.0), back),
            _PER_DEG * turned(ahead, 90.0),
            -turned(direction(self.joints[:, 0]), back),
            -turned(direction(self.both), back),
            direction(back),
            direction(back + 90.0),
        ]
        for index, column in enumerate(columns):
            matrix[: 2 * looks, index] = (column * self.unit).ravel()
        rows = slice(2 * looks, 2 * (looks + touches))
        first, both = self.touches[:, 0], self.touches.sum(axis=1)
        for index, column in ((3, direction(first)), (4, direction(both))):
            matrix[rows, index] = (column * self.touch_unit).ravel()
        matrix[2 * looks : 2 * (looks + touches) : 2, 5] = -self.touch_unit
        matrix[2 * looks + 1 : 2 * (looks + touches) : 2, 6] = -self.touch_unit
        if self.lines:
            rows = slice(2 * (looks + touches), None)
            matrix[rows, 2] = -self.line_unit
            if self.needs_line:
                matrix[rows, 7] = np.where(np.isnan(self.known), -self.line_unit, 0.0)
        return matrix

    def _ahead(self, p: Array) -> Array:
        """Return how far right of and above the reference pixel the point should be seen."""
        towards = direction(self.both + p[1] - 180.0)
        away = p[5:7] - self._gripper(p, self.joints) - p[0] * towards
        return turned(away, p[2] - 180.0 - self.both)

    def _gripper(self, p: Array, joints: Array) -> Array:
        place: Array = p[3] * direction(joints[:, 0]) + p[4] * direction(joints.sum(axis=1))
        return place

    def _line_residuals(self, p: Array) -> Array:
        if not self.lines:
            return np.empty(0)
        towards = np.where(np.isnan(self.known), p[7] if self.needs_line else 0.0, self.known)
        miss = self.line_sum - p[2] - towards
        folded: Array = ((miss + 90.0) % 180.0 - 90.0) * self.line_unit
        return folded


def refine(
    samples: Samples, eye: EyeInHand, *, height_mm: float = 0.0, may_hold: bool = True
) -> EyeFit:
    """Fit the five parameters of an eye in hand.

    Args:
        samples: Looks, touches and lines.
        eye: What was known before; scales and reference pixel are taken from it, and what the
            samples do not tell.
        height_mm: Height of the looked-at point over the table.
        may_hold: Whether parameters that are not seen are held; otherwise they are refused.

    Raises:
        FitFailed: There are too few looks, or they tell too little.
    """
    if len(samples.looks) < 3:
        raise FitFailed(
            f"{len(samples.looks)} looks at the point are too few; take 8 or more, from "
            "different angles of both joints"
        )
    model = _Model(samples, eye, height_mm)
    start = _start(model, eye)
    for hold in _HOLD if may_hold else _HOLD[:1]:
        free = tuple(i for i in range(start.size) if i not in hold)
        values = start.copy()
        for index in hold:
            values[index] = parameters_of(eye)[index]
        found = _fitted(model, values, free)
        if found is not None:
            break
    else:
        raise FitFailed(
            "the looks do not tell where the camera sits: they were taken from too similar "
            "angles; turn joint 1 and joint 2 by 20 deg or more between looks"
        )
    values[list(free)] = found.parameters
    values[1] %= 360.0
    values[2] = (values[2] + 180.0) % 360.0 - 180.0
    covariance = np.zeros((values.size, values.size))
    covariance[np.ix_(free, free)] = found.covariance
    return EyeFit(
        eye=with_parameters(eye, values),
        point_mm=(float(values[5]), float(values[6])),
        covariance=covariance[:5, :5],
        held=tuple(NAMES[i] for i in range(5) if i not in free),
        fit=found,
        information=found.jacobian.T @ found.jacobian,
        free=free,
        look_unit_mm=1.0 / model.unit,
    )


def look_slopes(eye: EyeInHand, point_mm: tuple[float, float], joints: Array, look_px: float,
                height_mm: float = 0.0) -> Array:  # fmt: skip
    """Return what looks from joints (n, 2) would tell: slopes (n, 2, 7), in deviations."""
    samples = Samples(looks=())
    model = _Model(samples, eye, height_mm)
    model.joints, model.both = joints, joints.sum(axis=1)
    model.unit = model.unit * samples.noise.look_px / look_px
    matrix = model.slopes(np.array([*parameters_of(eye), *point_mm]))
    return matrix.reshape(len(joints), 2, 7)


def _start(model: _Model, eye: EyeInHand) -> Array:
    """Return where to begin: a linear fit with link 1 as known and the picture's scale free."""
    count = len(model.joints)
    matrix = np.zeros((2 * count, 6))
    ahead, aside = direction(model.both), direction(model.both + 90.0)
    x, y = model.seen[:, :1], model.seen[:, 1:]
    for index, column in enumerate((ahead, aside, x * ahead + y * aside, x * aside - y * ahead)):
        matrix[:, index] = column.ravel()
    matrix[0::2, 4] = matrix[1::2, 5] = -1.0
    target = -eye.link_1_mm * direction(model.joints[:, 0]).ravel()
    along, across, c, s, px, py = np.linalg.lstsq(matrix, target, rcond=1e-6)[0]
    turn = 180.0 - np.degrees(np.arctan2(s, c)) if np.hypot(c, s) > 0.05 else eye.angle_error_deg
    offset = np.array([along - eye.link_2_mm, across])
    line = [] if not model.needs_line else [model.line_sum[np.isnan(model.known)][0] - turn]
    return np.array(
        [
            np.hypot(*offset),
            180.0 + np.degrees(np.arctan2(offset[1], offset[0])),
            turn,
            eye.link_1_mm,
            eye.link_2_mm,
            px,
            py,
            *line,
        ]
    )


def _fitted(model: _Model, start: Array, free: tuple[int, ...]) -> Fit | None:
    """Return the fit of the free parameters; None if the samples do not tell all of them."""
    at = list(free)

    def whole(part: Array) -> Array:
        values = start.copy()
        values[at] = part
        return values

    if not _is_seen(model.slopes(start)[:, at], free):
        return None
    try:
        found = fit(
            lambda part: model.residuals(whole(part)),
            start[at],
            jacobian=lambda part: model.slopes(whole(part))[:, at],
        )
    except FitFailed:
        return None
    return found if _is_seen(found.jacobian, free) else None


def _is_seen(slopes: Array, free: tuple[int, ...]) -> bool:
    deviation = predicted_deviation(slopes)
    five = [position for position, index in enumerate(free) if index < 5]
    return bool((deviation[five] < UNSEEN[[free[position] for position in five]]).all())


def predicted_deviation(slopes: Array) -> Array:
    """Return the standard deviations that slopes (n, p) promise; infinite where they tell none."""
    length = np.sqrt((slopes**2).sum(axis=0))
    if len(slopes) < slopes.shape[1] or (length < 1e-12).any():
        return np.full(slopes.shape[1], np.inf)
    _, values, right = np.linalg.svd(slopes / length, full_matrices=False)
    inverse = np.where(values > 1e-9 * values[0], values, 1e-12)
    deviation: Array = np.sqrt(((right.T / inverse) ** 2).sum(axis=1)) / length
    return deviation
