"""The homography that takes points of one plane to points of another.

Direct linear transformation with the normalisation of Hartley and Zisserman, Multiple View
Geometry, 2nd ed., algorithm 4.2. Four pairs determine it exactly: then it is worked out from
the projective bases that the two fours form, which costs a tenth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

_Triple = tuple[float, float, float]
_LEAST_SHARE = 1e-6
_RANK_TOLERANCE = 1e-7


def homography(source: Points, target: Points) -> Matrix:
    """Return the homography from source to target points, shape (3, 3), last entry 1.

    With more than four pairs it is the one of least algebraic error between normalised
    points.

    Args:
        source: Shape (n, 2), n ≥ 4.
        target: Shape (n, 2).

    Raises:
        FitFailed: There are fewer than four pairs, three of four lie on a line, or all do.
    """
    if source.shape != target.shape or source.ndim != 2 or source.shape[1] != 2:
        raise ValueError(f"points of shape {source.shape} cannot be paired with {target.shape}")
    if len(source) < 4:
        raise FitFailed(f"{len(source)} pairs do not determine a homography; take four or more")
    if len(source) == 4:
        return _of_four(source.tolist(), target.tolist())
    return _of_many(source, target)


def _of_four(source: Sequence[Sequence[float]], target: Sequence[Sequence[float]]) -> Matrix:
    """Return T · S⁻¹, where S and T take the canonical projective basis to the points."""
    s, su, sv = _basis(source)
    t, tx, ty = _basis(target)
    # Adjugate of S: its inverse up to a factor, which a homography ignores.
    (a, b, c), (d, e, f), (g, h, i) = s
    adjugate = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    product = [
        [sum(t[row][k] * adjugate[k][column] for k in range(3)) for column in range(3)]
        for row in range(3)
    ]
    # Back from coordinates about the two middles: shift the target, then the source.
    for column in range(3):
        product[0][column] += tx * product[2][column]
        product[1][column] += ty * product[2][column]
    for row in product:
        row[2] -= su * row[0] + sv * row[1]
    last = product[2][2]
    if last == 0.0:
        raise FitFailed("the first pixel of the picture lies on the horizon; check the pairs")
    return np.array(product) / last


def _basis(
    points: Sequence[Sequence[float]],
) -> tuple[tuple[_Triple, _Triple, _Triple], float, float]:
    """Return the matrix that takes e1, e2, e3 and (1, 1, 1) to four points, and their middle."""
    mu = sum(point[0] for point in points) / 4.0
    mv = sum(point[1] for point in points) / 4.0
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = ((x - mu, y - mv) for x, y in points)
    # Twice the areas of the triangles; the weights of the basis are their quotients.
    abc = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    dbc = (bx - dx) * (cy - dy) - (cx - dx) * (by - dy)
    adc = (dx - ax) * (cy - ay) - (cx - ax) * (dy - ay)
    abd = (bx - ax) * (dy - ay) - (dx - ax) * (by - ay)
    size = max(math.hypot(bx - ax, by - ay), math.hypot(cx - ax, cy - ay),
               math.hypot(dx - ax, dy - ay), math.hypot(cx - bx, cy - by))  # fmt: skip
    if min(abs(abc), abs(dbc), abs(adc), abs(abd)) <= _LEAST_SHARE * size * size:
        raise FitFailed("three of the four points lie on a line; take points that span an area")
    a, b, c = dbc / abc, adc / abc, abd / abc
    return ((a * ax, b * bx, c * cx), (a * ay, b * by, c * cy), (a, b, c)), mu, mv


def _of_many(source: Points, target: Points) -> Matrix:
    source_norm, s = _normalised(source)
    target_norm, t = _normalised(target)
    u, v = source_norm.T
    x, y = target_norm.T
    one, none = np.ones_like(u), np.zeros_like(u)
    rows = np.concatenate(
        [
            np.stack([u, v, one, none, none, none, -x * u, -x * v, -x], axis=1),
            np.stack([none, none, none, u, v, one, -y * u, -y * v, -y], axis=1),
        ]
    )
    _, values, right = np.linalg.svd(rows, full_matrices=False)
    if values[-2] < _RANK_TOLERANCE * values[0]:
        raise FitFailed("the points lie on a line; take points that span an area")
    matrix = np.linalg.inv(t) @ right[-1].reshape(3, 3) @ s
    return np.asarray(matrix / matrix[2, 2])


def _normalised(points: Points) -> tuple[Points, Matrix]:
    """Return points about 0 with mean distance √2, and the matrix that makes them so."""
    middle = points.mean(axis=0)
    distance = float(np.sqrt(((points - middle) ** 2).sum(axis=1)).mean())
    if distance == 0.0:
        raise FitFailed("all points are the same")
    scale = math.sqrt(2.0) / distance
    matrix = np.array(
        [[scale, 0.0, -scale * middle[0]], [0.0, scale, -scale * middle[1]], [0.0, 0.0, 1.0]]
    )
    return (points - middle) * scale, matrix


def apply(matrix: Matrix, points: Points) -> Points:
    """Return points (..., 2) taken through a homography (3, 3)."""
    mapped = points @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(mapped[..., :2] / mapped[..., 2:])


def local_scale(matrix: Matrix, points: Points) -> Matrix:
    """Return the derivatives (n, 2, 2) of a homography at points (n, 2)."""
    weight = points @ matrix[2, :2] + matrix[2, 2]
    mapped = apply(matrix, points)
    return np.asarray(
        (matrix[None, :2, :2] - mapped[:, :, None] * matrix[None, None, 2, :2])
        / weight[:, None, None]
    )
