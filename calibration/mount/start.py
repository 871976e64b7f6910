"""Where the fit begins: lens by Zhang's method, then hand and eye linearly.

With B robot-from-flange, X flange-from-camera, A camera-from-target and Y robot-from-target,
every view has B X A = Y, and two views have (B₂⁻¹ B₁) X = X (A₂ A₁⁻¹). Rotation vectors of
both sides differ by X's rotation alone, which the SVD of their products gives (Park and Martin
1994). What is left is linear in X's and Y's shifts and in the target's scale: the arm knows
millimetres, whatever somebody typed for the target's size.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.mount.model import (
    HEIGHT_PX,
    WIDTH_PX,
    MountState,
    MountView,
    transform,
    turn_vector,
)
from cell.geometry import Transform

Points = NDArray[np.float64]

_LEAST_TURN_RAD = np.radians(2.0)
_PARALLEL = 0.002


def start_of(views: Sequence[MountView]) -> MountState:
    """Return lens, mount, target's place and scale to begin with.

    Raises:
        FitFailed: There are fewer than three views, or all are turned about one axis.
    """
    if len(views) < 3:
        raise FitFailed(f"{len(views)} views do not determine a lens and a mount; take ten or more")
    lens, seen = _zhang(views)
    held = [view.robot_from_flange for view in views]
    mount_turn = _hand_eye_turn(held, seen)
    target_turn = _mean_turn(
        [b.rotation @ mount_turn @ a.rotation for b, a in zip(held, seen, strict=True)]
    )
    rows, wanted = [], []
    for b, a in zip(held, seen, strict=True):
        along = b.rotation @ mount_turn @ a.translation_mm
        rows.append(np.hstack([along[:, None], b.rotation, -np.eye(3)]))
        wanted.append(-b.translation_mm)
    solved, _, rank, _ = np.linalg.lstsq(np.vstack(rows), np.concatenate(wanted), rcond=None)
    if rank < 7 or not np.isfinite(solved).all() or solved[0] <= 0:
        raise FitFailed("the views do not determine where the camera hangs; tilt the hand more")
    return MountState(
        lens=lens,
        flange_from_camera=transform(mount_turn, solved[1:4]),
        targets=(transform(target_turn, solved[4:7]),),
        scale=float(solved[0]),
    )


def second_turn_deg(views: Sequence[MountView]) -> float:
    """Return how far the hand was turned about a second axis, RMS: 0 if all about one.

    Turns about one axis alone leave the camera's place along it open (Tsai and Lenz 1989).
    """
    if len(views) < 2:
        return 0.0
    middle = _mean_turn([view.robot_from_flange.rotation for view in views])
    turns = np.array([turn_vector(middle.T @ v.robot_from_flange.rotation) for v in views])
    spread = np.linalg.eigvalsh(turns.T @ turns / len(views))
    return float(np.degrees(np.sqrt(max(float(spread[1]), 0.0))))


def tilts(views: Sequence[MountView], apart_deg: float = 5.0) -> int:
    """Return from how many directions, so far apart or more, the hand looked."""
    chosen: list[Points] = []
    for view in views:
        axis = view.robot_from_flange.rotation[:, 2]
        if all(float(axis @ other) < np.cos(np.radians(apart_deg)) for other in chosen):
            chosen.append(axis)
    return len(chosen)


def _zhang(views: Sequence[MountView]) -> tuple[Points, list[Transform]]:
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    flags |= cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_FIX_ASPECT_RATIO
    flags |= cv2.CALIB_USE_INTRINSIC_GUESS
    points = [view.points_mm.astype(np.float32) for view in views]
    pixels = [view.pixels.astype(np.float32).reshape(-1, 1, 2) for view in views]
    middle = ((WIDTH_PX - 1) / 2.0, (HEIGHT_PX - 1) / 2.0)
    guess = np.array([[WIDTH_PX, 0.0, middle[0]], [0.0, WIDTH_PX, middle[1]], [0.0, 0.0, 1.0]])
    try:
        _, matrix, bends, turns, shifts = cv2.calibrateCamera(
            points, pixels, (WIDTH_PX, HEIGHT_PX), guess, np.zeros(5), flags=flags
        )
    except cv2.error as error:
        raise FitFailed("the views do not determine the lens; tilt the hand more") from error
    lens = np.array([matrix[0, 0], *middle, np.ravel(bends)[0], 0.0])
    if not np.isfinite(lens).all():
        raise FitFailed("the views do not determine the lens; tilt the hand more")
    seen = [
        transform(np.asarray(cv2.Rodrigues(turn)[0], np.float64), np.ravel(shift))
        for turn, shift in zip(turns, shifts, strict=True)
    ]
    return lens, seen


def _hand_eye_turn(held: Sequence[Transform], seen: Sequence[Transform]) -> Points:
    products = np.zeros((3, 3))
    for i, j in itertools.combinations(range(len(held)), 2):
        hand = turn_vector(held[j].rotation.T @ held[i].rotation)
        eye = turn_vector(seen[j].rotation @ seen[i].rotation.T)
        # A turn near half a turn has two opposite vectors, and a small one mostly noise.
        if _LEAST_TURN_RAD < np.linalg.norm(hand) < 0.9 * np.pi:
            products += np.outer(hand, eye)
    left, values, right = np.linalg.svd(products)
    if values[0] <= 0 or values[1] < _PARALLEL * values[0]:
        raise FitFailed("the hand was turned about one axis alone; tilt it to several sides")
    flip = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
    return np.asarray(left @ flip @ right, np.float64)


def _mean_turn(turns: Sequence[Points]) -> Points:
    left, _, right = np.linalg.svd(np.sum(turns, axis=0))
    flip = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
    return np.asarray(left @ flip @ right, np.float64)
