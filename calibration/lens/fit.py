"""Lens and board poses from views of a board: bundle adjustment with full covariance.

Zhang's method (2000) as OpenCV has it gives the start; then Gauss and Newton with the poses
eliminated view by view (Schur complement), so that what the poses leave open about the lens
is in its covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from cell.geometry import LensModel
from cell.vision.boards import Board

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

NAMES = ("focal_u_px", "focal_v_px", "centre_u_px", "centre_v_px", "k1", "k2", "p1", "p2", "k3")
"""Order of a lens's nine parameters."""

_STEPS = 30
_DONE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoardView:
    """Corners of a board seen in a picture.

    Attributes:
        label: Name of the view.
        ids: Numbers of the corners, (n,).
        pixels: Where they are, (n, 2).
    """

    label: str
    ids: NDArray[np.int64]
    pixels: Points


@dataclass(frozen=True, slots=True, kw_only=True)
class LensPrior:
    """What is known of a lens beforehand, and which parameters it has.

    Attributes:
        has_square_pixels: Whether both focal lengths are the same: so it is of every industrial
            sensor.
        radial: How many of k1, k2, k3 it has.
        has_tangential: Whether it has p1 and p2: lens and sensor are not parallel.
        centre_px: Standard deviation of the optical axis about the picture's middle. A lens
            of long focal length hardly tells its centre from a tilt of the camera.
    """

    has_square_pixels: bool = True
    radial: int = 2
    has_tangential: bool = False
    centre_px: float = 40.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LensFit:
    """A fitted lens.

    Attributes:
        lens: The lens, for pictures of the size it was fitted on.
        lens_covariance: Of its nine parameters in the order of `NAMES`, zero where one was
            held, (9, 9).
        free: Names of those that were fitted; square pixels have `focal_px`.
        values: Of those.
        covariance: Of those.
        rms_px: Root mean square of the residuals along an axis.
        residuals: Seen less fitted pixels, view by view.
        poses: Rotation vector and translation (mm) of camera-from-board, view by view, (6,).
    """

    lens: LensModel
    lens_covariance: Matrix
    free: tuple[str, ...]
    values: Points
    covariance: Matrix
    rms_px: float
    residuals: tuple[Points, ...]
    poses: tuple[Points, ...]


def fit_lens(
    board: Board,
    views: Sequence[BoardView],
    width_px: int,
    height_px: int,
    prior: LensPrior,
    start: tuple[Points, Sequence[Points]] | None = None,
) -> LensFit:
    """Fit a lens to views of a board.

    Args:
        board: The board.
        views: Where its corners were seen.
        width_px: Width of the pictures.
        height_px: Height of the pictures.
        prior: Which parameters the lens has, and what is known of them.
        start: Values and poses to begin with, such as those of a fit with one view more.

    Raises:
        FitFailed: There are fewer than three views, or they do not determine it.
    """
    if len(views) < 3:
        raise FitFailed(f"{len(views)} views do not determine a lens; take eight or more")
    middle = np.array([(width_px - 1) / 2.0, (height_px - 1) / 2.0])
    free, spread = _parameters(prior)
    if start is None:
        values, poses = _start(board, views, width_px, height_px, prior, spread)
    else:
        values, poses = start[0].copy(), list(start[1])
    weight = np.zeros(len(free))
    expected = np.zeros(len(free))
    for index, name in enumerate(free):
        if name.startswith("centre"):
            weight[index] = 1.0 / prior.centre_px**2
            expected[index] = middle[0] if name == "centre_u_px" else middle[1]
    total = np.inf
    for _ in range(_STEPS):
        normal, gradient, squares, count, steps = _reduced(
            board, views, spread @ values, poses, spread
        )
        variance = max(squares / max(2 * count - 6 * len(views) - len(free), 1), 1e-8)
        normal = normal / variance + np.diag(weight)
        gradient = gradient / variance + weight * (expected - values)
        try:
            change = np.linalg.solve(normal, gradient)
        except np.linalg.LinAlgError as error:
            raise FitFailed("the views do not determine the lens; tilt the board more") from error
        values = values + change
        poses = [pose + own - gain @ change for pose, (own, gain) in zip(poses, steps, strict=True)]
        if abs(total - squares) <= _DONE * max(squares, 1e-12):
            break
        total = squares
    if not np.isfinite(values).all() or values[0] <= 0:
        raise FitFailed("the views do not determine the lens; tilt the board more")
    covariance = np.asarray(np.linalg.inv(normal), np.float64)
    lens = _lens(spread @ values, width_px, height_px)
    residuals = tuple(
        view.pixels - project(board.points_mm[view.ids], spread @ values, pose)
        for view, pose in zip(views, poses, strict=True)
    )
    return LensFit(
        lens=lens,
        lens_covariance=spread @ covariance @ spread.T,
        free=free,
        values=values,
        covariance=covariance,
        rms_px=float(np.sqrt(variance)),
        residuals=residuals,
        poses=tuple(poses),
    )


def pose_of(board: Board, view: BoardView, lens: LensModel) -> tuple[Points, Points]:
    """Return a view's pose (6,) and residuals (n, 2) with a known lens.

    Raises:
        FitFailed: The corners do not determine it.
    """
    points = board.points_mm[view.ids]
    found, turn, shift = cv2.solvePnP(
        points, view.pixels, lens.matrix, lens.coefficients, flags=cv2.SOLVEPNP_IPPE
    )
    if not found:
        raise FitFailed(f"{view.label}: the corners do not determine where the board was")
    turn, shift = cv2.solvePnPRefineLM(
        points, view.pixels, lens.matrix, lens.coefficients, turn, shift
    )
    pose = np.concatenate([np.ravel(turn), np.ravel(shift)]).astype(np.float64)
    values = np.concatenate([np.diag(lens.matrix)[:2], lens.matrix[:2, 2], lens.coefficients])
    return pose, view.pixels - project(points, values, pose)


def project(points_mm: Points, values: Points, pose: Points) -> Points:
    """Return pixels (n, 2) of board points by nine lens parameters and a pose (6,)."""
    pixels, _ = _projected(points_mm, values, pose)
    return pixels


def _projected(points_mm: Points, values: Points, pose: Points) -> tuple[Points, Matrix]:
    matrix = np.array([[values[0], 0.0, values[2]], [0.0, values[1], values[3]], [0.0, 0.0, 1.0]])
    pixels, slope = cv2.projectPoints(points_mm, pose[:3], pose[3:], matrix, values[4:9])
    return np.asarray(pixels, np.float64).reshape(-1, 2), np.asarray(slope, np.float64)


def _parameters(prior: LensPrior) -> tuple[tuple[str, ...], Matrix]:
    """Return names of the free parameters, and lens = spread · values."""
    rows: list[tuple[str, tuple[int, ...]]] = (
        [("focal_px", (0, 1))]
        if prior.has_square_pixels
        else [("focal_u_px", (0,)), ("focal_v_px", (1,))]
    )
    rows += [("centre_u_px", (2,)), ("centre_v_px", (3,))]
    rows += [(name, (at,)) for name, at in (("k1", 4), ("k2", 5))[: prior.radial]]
    if prior.has_tangential:
        rows += [("p1", (6,)), ("p2", (7,))]
    if prior.radial > 2:
        rows.append(("k3", (8,)))
    spread = np.zeros((9, len(rows)))
    for column, (_, entries) in enumerate(rows):
        spread[list(entries), column] = 1.0
    return tuple(name for name, _ in rows), spread


def _start(
    board: Board,
    views: Sequence[BoardView],
    width_px: int,
    height_px: int,
    prior: LensPrior,
    spread: Matrix,
) -> tuple[Points, list[Points]]:
    """Return OpenCV's solution, without distortion but k1, as free values and poses."""
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    flags |= cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_FIX_ASPECT_RATIO
    flags |= cv2.CALIB_USE_INTRINSIC_GUESS
    if prior.radial < 1:
        flags |= cv2.CALIB_FIX_K1
    points = [board.points_mm[view.ids].astype(np.float32) for view in views]
    pixels = [view.pixels.astype(np.float32).reshape(-1, 1, 2) for view in views]
    focal = _focal_guess(points, pixels, width_px, height_px)
    middle = ((width_px - 1) / 2.0, (height_px - 1) / 2.0)
    guess = np.array([[focal, 0.0, middle[0]], [0.0, focal, middle[1]], [0.0, 0.0, 1.0]])
    try:
        _, matrix, bends, turns, shifts = cv2.calibrateCamera(
            points, pixels, (width_px, height_px), guess, np.zeros(5), flags=flags
        )
    except cv2.error as error:
        raise FitFailed("the views do not determine the lens; tilt the board more") from error
    lens = np.zeros(9)
    lens[0] = matrix[0, 0]
    lens[1] = matrix[1, 1]
    lens[2], lens[3] = middle
    lens[4] = np.ravel(bends)[0]
    values = np.linalg.pinv(spread) @ lens
    poses = [
        np.concatenate([np.ravel(t), np.ravel(s)]).astype(np.float64)
        for t, s in zip(turns, shifts, strict=True)
    ]
    return values, poses


def _focal_guess(
    points: Sequence[NDArray[np.float32]],
    pixels: Sequence[NDArray[np.float32]],
    width_px: int,
    height_px: int,
) -> float:
    """Return Zhang's focal length, kept within what lenses have; 1.2 widths where it fails."""
    matrix = cv2.initCameraMatrix2D(list(points), list(pixels), (width_px, height_px), 1.0)
    focal = float(matrix[0, 0])
    if not np.isfinite(focal):
        return 1.2 * width_px
    return min(max(focal, 0.3 * width_px), 20.0 * width_px)


_Step = tuple[Points, Matrix]


def _reduced(
    board: Board,
    views: Sequence[BoardView],
    lens: Points,
    poses: Sequence[Points],
    spread: Matrix,
) -> tuple[Matrix, Points, float, int, list[_Step]]:
    """Return the lens's normal equations with the poses eliminated, and how poses follow."""
    size = spread.shape[1]
    normal, gradient = np.zeros((size, size)), np.zeros(size)
    squares, count = 0.0, 0
    steps: list[_Step] = []
    for view, pose in zip(views, poses, strict=True):
        fitted, slope = _projected(board.points_mm[view.ids], lens, pose)
        miss = (view.pixels - fitted).ravel()
        own, optics = slope[:, :6], slope[:, 6:15] @ spread
        inverse = np.linalg.inv(own.T @ own + 1e-12 * np.eye(6))
        gain = inverse @ (own.T @ optics)
        alone = inverse @ (own.T @ miss)
        normal += optics.T @ optics - (optics.T @ own) @ gain
        gradient += optics.T @ miss - (optics.T @ own) @ alone
        squares += float(miss @ miss)
        count += len(view.ids)
        steps.append((alone, gain))
    return normal, gradient, squares, count, steps


def _lens(values: Points, width_px: int, height_px: int) -> LensModel:
    focal_u, focal_v, centre_u, centre_v, k1, k2, p1, p2, k3 = (float(v) for v in values)
    return LensModel(
        width_px=width_px, height_px=height_px, focal_u_px=focal_u, focal_v_px=focal_v,
        centre_u_px=centre_u, centre_v_px=centre_v, k1=k1, k2=k2, p1=p1, p2=p2, k3=k3,
    )  # fmt: skip
