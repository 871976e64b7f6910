"""Which look to take next, and how exactly the gripper will meet what the camera saw."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan2, cos, degrees, hypot, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.eye_in_hand.refine import NAMES, EyeFit, look_slopes
from calibration.eye_in_hand.samples import Noise
from cell.geometry.eye_in_hand import EyeInHand, direction, turned

Array = NDArray[np.float64]

PICTURE_PX: Final = (512, 480)
"""Columns and rows in which objects are found."""
_MARGIN_PX: Final = 20.0
_STEP_DEG: Final = 5.0
_PER_DEG: Final = np.pi / 180.0
_WEIGHT: Final = np.array([1.0, 1.4, 1.7, 1.0, 1.0])
"""How far (mm) a unit of each parameter moves a place: angles over 82 and about 100 mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Suggestion:
    """A look to take.

    Attributes:
        j1_deg: Joint 1.
        j2_deg: Joint 2.
        u_px: Column where the point will appear.
        v_px: Row where the point will appear.
        gain: Share of the parameters' weighted variance that it is expected to take away.
    """

    j1_deg: float
    j2_deg: float
    u_px: float
    v_px: float
    gain: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """Where the two joints may stand.

    Attributes:
        joint_min_deg: Least angles of joints 1 and 2.
        joint_max_deg: Greatest angles of joints 1 and 2.
    """

    joint_min_deg: tuple[float, float] = (0.0, 0.0)
    joint_max_deg: tuple[float, float] = (200.0, 135.0)


def viewing_joints(
    eye: EyeInHand, point_mm: tuple[float, float], reach: Reach, step_deg: float = _STEP_DEG
) -> Array:
    """Return joints (n, 2) from which a point on the table falls into the picture."""
    (low_1, low_2), (high_1, high_2) = reach.joint_min_deg, reach.joint_max_deg
    grid = np.stack(
        np.meshgrid(
            np.arange(low_1, high_1 + 1e-9, step_deg), np.arange(low_2, high_2 + 1e-9, step_deg)
        ),
        axis=-1,
    ).reshape(-1, 2)
    pixels = eye.pixels(np.array(point_mm), grid, height_mm=0.0)
    inside = (pixels > _MARGIN_PX) & (pixels < np.array(PICTURE_PX) - _MARGIN_PX)
    return grid[inside.all(axis=1)]


def next_look(fit: EyeFit, reach: Reach, noise: Noise) -> Suggestion | None:
    """Return the look that sharpens the parameters most; None if the point is seen from nowhere.

    Each look adds its slopes to the information; what that leaves of the variances, weighted
    by how far a parameter moves a place, is compared.
    """
    joints = viewing_joints(fit.eye, fit.point_mm, reach, step_deg=2.5)
    if not len(joints):
        return None
    free = [i for i in fit.free if i < 7]
    count = len(fit.free)
    slopes = np.zeros((len(joints), 2, count))
    seven = look_slopes(fit.eye, fit.point_mm, joints, noise.look_px)
    slopes[:, :, [fit.free.index(i) for i in free]] = seven[:, :, free]
    weight = np.zeros(count)
    for position, index in enumerate(fit.free):
        weight[position] = _WEIGHT[index] if index < 5 else 0.0
    more = fit.information + np.einsum("nij,nik->njk", slopes, slopes)
    after = np.einsum("njj,j->n", np.linalg.inv(more), weight**2)
    before = float(np.diag(np.linalg.inv(fit.information)) @ weight**2)
    best = int(after.argmin())
    u, v = fit.eye.pixels(np.array(fit.point_mm), joints[best], height_mm=0.0)
    return Suggestion(
        j1_deg=float(joints[best, 0]),
        j2_deg=float(joints[best, 1]),
        u_px=float(u),
        v_px=float(v),
        gain=1.0 - float(after[best]) / before,
    )


def gripping_joints(eye: EyeInHand, point_mm: tuple[float, float]) -> tuple[float, float] | None:
    """Return joints 1 and 2 with the gripper over a point; None out of reach."""
    l1, l2 = eye.link_1_mm, eye.link_2_mm
    square = point_mm[0] ** 2 + point_mm[1] ** 2
    cosine = (square - l1**2 - l2**2) / (2.0 * l1 * l2)
    if not -1.0 <= cosine <= 1.0 or hypot(*point_mm) < 1e-6:
        return None
    bend = acos(cosine)
    first = atan2(point_mm[1], point_mm[0]) - atan2(l2 * sin(bend), l1 + l2 * cos(bend))
    return degrees(first), degrees(bend)


def grip_slopes(eye: EyeInHand, pixels: Array, seen_deg: Array, over_deg: Array) -> Array:
    """Return how each of the five parameters moves gripper against seen object, (n, 2, 5).

    The gripper is sent by the same link lengths that the object was placed with, so an error
    of a link counts only as far as the arm stands otherwise than when it looked.
    """
    both = seen_deg.sum(axis=1)
    towards = both + eye.b_angle_deg - 180.0
    ahead = turned(eye.ahead_mm(pixels), both + 180.0 - eye.angle_error_deg)
    return np.stack(
        [
            direction(towards),
            eye.d_t_c_mm * _PER_DEG * direction(towards + 90.0),
            -_PER_DEG * turned(ahead, 90.0),
            direction(seen_deg[:, 0]) - direction(over_deg[:, 0]),
            direction(both) - direction(over_deg.sum(axis=1)),
        ],
        axis=-1,
    )


def predicted_miss(
    fit: EyeFit, *, grid_px: float = 100.0, held_deviation: float = 1.0
) -> tuple[float, float]:
    """Return how far the gripper will miss an object because of the fit: rms and worst 95 %.

    Objects all over the picture, the arm standing where the point was looked at, within reach
    of the gripper.

    Args:
        fit: The fit.
        grid_px: How far apart the objects stand in the picture.
        held_deviation: Standard deviation put in for a held parameter (mm or deg).
    """
    eye = fit.eye
    covariance = fit.covariance.copy()
    for name in fit.held:
        index = NAMES.index(name)
        covariance[index, index] = held_deviation**2
    columns = np.arange(6.0, PICTURE_PX[0], grid_px)
    rows = np.arange(6.0, PICTURE_PX[1], grid_px)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    seen = viewing_joints(eye, fit.point_mm, Reach(), step_deg=15.0)
    variances = []
    for stand in seen:
        places = eye.places(pixels, stand)
        over = [gripping_joints(eye, (float(x), float(y))) for x, y in places]
        kept = [i for i, joints in enumerate(over) if joints is not None]
        if not kept:
            continue
        slopes = grip_slopes(
            eye,
            pixels[kept],
            np.broadcast_to(stand, (len(kept), 2)),
            np.array([joints for joints in over if joints is not None]),
        )
        variances.append(np.einsum("nij,jk,nik->n", slopes, covariance, slopes))
    if not variances:
        return float("nan"), float("nan")
    squares = np.concatenate(variances)
    return float(np.sqrt(squares.mean())), float(2.0 * np.sqrt(squares.max()))
