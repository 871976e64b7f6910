"""What it costs to fit the top camera's map, beside OpenCV."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from benchmarks.measure import Result, median_s
from calibration.homography.dlt import homography
from calibration.homography.noise import PairNoise
from calibration.homography.place_fit import fit_place
from calibration.homography.plane_fit import fit_plane
from calibration.world.fit import fit_lattice, mapped
from cell.geometry import LatticeMap
from cell.profile import load_profile
from tests.calibration.hidden_truth import block_top_mm, hidden, true_view

PICTURE = ((46.8, 821.5), (1175.8, 815.1), (1166.8, 123.0), (44.3, 132.9))
ROBOT = ((700.0, -350.0), (700.0, 300.0), (300.0, 300.0), (300.0, -350.0))


def run() -> list[Result]:
    pixels, points = np.array(PICTURE), np.array(ROBOT)
    narrow, target = pixels.astype(np.float32), points.astype(np.float32)
    noise = PairNoise()
    profile = load_profile("mash")
    view = true_view(hidden(profile, 1))
    top_mm = block_top_mm(profile)
    seen = view.to_picture(points, top_mm)
    opencv_us = _us(lambda: cv2.getPerspectiveTransform(narrow, target), 500)
    cells = np.array([[0.0, 0.0], [11.0, 0.0], [11.0, 11.0], [0.0, 11.0]])
    lattice = LatticeMap(step_mm=20.0, angle_deg=89.0, origin_x_mm=710.0, origin_y_mm=-265.0)
    places = mapped(lattice, cells)
    return [
        Result(
            name="DLT of 4 points", value=_us(lambda: homography(pixels, points), 500), unit="us",
            peer="cv2.getPerspectiveTransform (float32)", peer_value=opencv_us, target=150.0,
        ),
        Result(
            name="the same with covariance", unit="us",
            value=_us(lambda: fit_plane(pixels, points, noise), 50),
            peer="cv2.getPerspectiveTransform (float32)", peer_value=opencv_us,
        ),
        Result(
            name="place of a camera from 4 points, lens known, with covariance",
            value=_us(lambda: fit_place(seen, points, top_mm, view.lens, noise), 5) / 1000.0,
            unit="ms",
        ),
        Result(
            name="lattice from 4 points, with covariance", unit="us",
            value=_us(lambda: fit_lattice(cells, places, noise_mm=0.3), 50),
        ),
    ]  # fmt: skip


def _us(job: Callable[[], object], number: int) -> float:
    return median_s(job, number=number) * 1e6
