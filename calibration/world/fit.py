"""The lattice fitted to points whose robot places are known.

x = step · R(angle) · l + origin is linear in (step·cos, step·sin, ox, oy), so that the fit is
exact least squares in closed form; with a fixed step it is the rotation of Kabsch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.statistics import region_factor
from cell.geometry import LatticeMap

Points = NDArray[np.float64]
Matrix = NDArray[np.float64]

NAMES = ("step_mm", "angle_deg", "origin_x_mm", "origin_y_mm")
UNITS = ("mm", "deg", "mm", "mm")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LatticeFit:
    """A fitted lattice.

    Attributes:
        lattice: The map.
        covariance: Of step, angle (deg) and origin in the order of `NAMES`, (4, 4); the
            step's row is zero where it was fixed.
        freedom: Degrees of freedom of the noise if it came from the residuals; None if it
            was stated.
        residuals_mm: Fitted less measured robot points, (n, 2).
        noise_mm: Standard deviation along an axis that the covariance goes by.
    """

    lattice: LatticeMap
    covariance: Matrix
    freedom: int | None
    residuals_mm: Points
    noise_mm: float

    def region_factor(self, dimensions: int, probability: float = 0.95) -> float:
        """Return the squared Mahalanobis distance that bounds regions of a probability."""
        return region_factor(dimensions, self.freedom, probability)

    def covariance_at(self, cells: Points) -> Matrix:
        """Return the covariances (n, 2, 2), in mm², of where lattice points (n, 2) lie."""
        slope = _slopes(self.lattice, cells)
        return np.asarray(slope @ self.covariance @ slope.transpose(0, 2, 1))


def fit_lattice(
    cells: Points, points_mm: Points, *, step_mm: float | None = None, noise_mm: float | None = None
) -> LatticeFit:
    """Fit the lattice.

    Args:
        cells: Lattice points, (n, 2), n ≥ 2.
        points_mm: Robot x, y of each, (n, 2).
        step_mm: The step, if it is known; else it is fitted.
        noise_mm: Standard deviation of the points along each axis; None takes it from the
            residuals.

    Raises:
        FitFailed: The points do not determine it, or leave nothing over to tell the noise by.
    """
    if len(cells) < 2:
        raise FitFailed("one point does not determine the lattice; take two or more")
    middle, target = cells.mean(axis=0), points_mm.mean(axis=0)
    w = (cells - middle) @ (1.0, 1.0j)
    z = (points_mm - target) @ (1.0, 1.0j)
    spread = float((np.abs(w) ** 2).sum())
    if spread < 1e-9:
        raise FitFailed("all points are the same lattice point; take them far apart")
    factor = complex((w.conj() * z).sum() / spread)
    if abs(factor) < 1e-9:
        raise FitFailed("the robot points do not differ; take them far apart")
    if step_mm is not None:
        factor *= step_mm / abs(factor)
    origin = complex(target @ (1.0, 1.0j)) - factor * complex(middle @ (1.0, 1.0j))
    lattice = LatticeMap(
        step_mm=abs(factor),
        angle_deg=_tidy(math.degrees(math.atan2(factor.imag, factor.real))),
        origin_x_mm=origin.real,
        origin_y_mm=origin.imag,
    )
    miss = mapped(lattice, cells) - points_mm
    free = 3 if step_mm is not None else 4
    freedom = 2 * len(cells) - free
    if noise_mm is None and freedom < 1:
        raise FitFailed(
            f"{len(cells)} points leave nothing over to tell how exact they are; take more, or "
            "state how exact they are"
        )
    sigma = noise_mm if noise_mm is not None else math.sqrt(float((miss**2).sum()) / freedom)
    slope = _slopes(lattice, cells).reshape(-1, 4)
    used = slope[:, 1:] if step_mm is not None else slope
    covariance = np.zeros((4, 4))
    covariance[4 - free :, 4 - free :] = sigma**2 * np.linalg.inv(used.T @ used)
    return LatticeFit(
        lattice=lattice,
        covariance=covariance,
        freedom=None if noise_mm is not None else freedom,
        residuals_mm=miss,
        noise_mm=sigma,
    )


def mapped(lattice: LatticeMap, cells: Points) -> Points:
    """Return robot points (n, 2) of lattice points (n, 2)."""
    return np.array([lattice.to_robot(x, y) for x, y in cells.tolist()]).reshape(-1, 2)


def _slopes(lattice: LatticeMap, cells: Points) -> Matrix:
    """Return d (x, y) / d (step, angle in deg, origin), (n, 2, 4)."""
    offset = mapped(lattice, cells) - (lattice.origin_x_mm, lattice.origin_y_mm)
    slope = np.zeros((len(cells), 2, 4))
    slope[:, :, 0] = offset / lattice.step_mm
    slope[:, 0, 1] = -offset[:, 1] * math.pi / 180.0
    slope[:, 1, 1] = offset[:, 0] * math.pi / 180.0
    slope[:, 0, 2] = slope[:, 1, 3] = 1.0
    return slope


def _tidy(angle_deg: float) -> float:
    """Return an angle, a multiple of 90 exactly where only rounding keeps it off."""
    turn = round(angle_deg / 90.0) * 90.0
    return turn if abs(angle_deg - turn) < 1e-9 else angle_deg
