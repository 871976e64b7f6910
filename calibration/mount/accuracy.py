"""How good lens and mount are, in millimetres on the table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.mount.fit import ArmNoise, MountFit, fit_mount
from calibration.mount.model import HEIGHT_PX, WIDTH_PX, MountState, MountView
from cell.geometry import CameraView, Transform

Points = NDArray[np.float64]

_STEPS = np.array([0.1, 0.1, 0.1, 1e-5, 1e-5, *[1e-5] * 3, *[0.01] * 3])
_FURTHEST_MM = 900.0


def miss_mm(view: MountView, state: MountState) -> Points:
    """Return how far (n,) what a view shows lies from where its target has it, on the target.

    Rays of the pixels meet the plane z = 0 of the target.
    """
    target_from_camera = (
        state.targets[view.group].inverse() @ view.robot_from_flange @ state.flange_from_camera
    )
    found = CameraView(state.model(), target_from_camera).to_robot(view.pixels, 0.0)
    return np.asarray(np.linalg.norm(found - view.points_mm[:, :2] * state.scale, axis=1))


def held_out_mm(
    views: Sequence[MountView], fitted: MountFit, noise: ArmNoise
) -> tuple[Points | None, ...]:
    """Return each view's misses by a fit without it; None where the rest tells too little."""
    found: list[Points | None] = []
    for index, view in enumerate(views):
        rest = [*views[:index], *views[index + 1 :]]
        if len(rest) < 3 or all(other.group != view.group for other in rest):
            found.append(None)
            continue
        try:
            found.append(miss_mm(view, fit_mount(rest, fitted.state, noise).state))
        except (FitFailed, ValueError):
            found.append(None)
    return tuple(found)


def table_deviations_mm(
    state: MountState, covariance: Points, flanges: Sequence[Transform], surface_mm: float
) -> Points:
    """Return the longest standard deviation of seen places on the table, (m,).

    Over a grid of the picture, from each place of the flange.

    Args:
        state: Lens and mount.
        covariance: Of them, (11, 11) or larger.
        flanges: robot_from_flange of the looks.
        surface_mm: Height of the table.
    """
    u, v = np.meshgrid(np.linspace(60, WIDTH_PX - 61, 5), np.linspace(60, HEIGHT_PX - 61, 4))
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    spreads = []
    for flange in flanges:
        try:
            here = table_points_mm(state, flange, pixels, surface_mm)
            near = np.linalg.norm(here - flange.translation_mm[:2], axis=1) < _FURTHEST_MM
            slopes = _slopes(state, flange, pixels[near], surface_mm)
        except ValueError:
            continue
        each = np.einsum("nik,kl,njl->nij", slopes, covariance[:11, :11], slopes)
        spreads.append(np.sqrt(np.linalg.eigvalsh(each)))
    if not spreads:
        return np.empty((0, 2))
    return np.concatenate(spreads)


def table_points_mm(
    state: MountState, flange: Transform, pixels: Points, surface_mm: float
) -> Points:
    """Return robot x, y (n, 2) of what pixels show on the table.

    Raises:
        ValueError: A pixel looks over the table's horizon.
    """
    view = CameraView(state.model(), flange @ state.flange_from_camera)
    return view.to_robot(pixels, surface_mm)


def rms(values: Points) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))


def _slopes(state: MountState, flange: Transform, pixels: Points, surface_mm: float) -> Points:
    """Return derivatives (n, 2, 11) of places on the table by lens and mount."""
    alone = replace(state, targets=())
    columns = []
    for index, step in enumerate(_STEPS):
        change = np.zeros(11)
        change[index] = step
        up = table_points_mm(alone.moved(change), flange, pixels, surface_mm)
        down = table_points_mm(alone.moved(-change), flange, pixels, surface_mm)
        columns.append((up - down) / (2.0 * step))
    return np.stack(columns, axis=2)
