from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.homography.noise import PairNoise
from calibration.homography.place_fit import fit_place
from calibration.homography.plane_fit import fit_plane
from calibration.statistics import mahalanobis_squared
from cell.geometry import CameraView
from cell.profile import load_profile
from tests.calibration.hidden_truth import PLAYGROUND_CORNERS_MM, hidden, true_view

TOP = 71.5
NOISE = PairNoise(pixel_px=0.5, placement_mm=0.3)
MORE = ((500.0, -25.0), (420.0, 100.0))


def views(count: int) -> list[CameraView]:
    profile = load_profile("mash")
    return [true_view(hidden(profile, seed)) for seed in range(count)]


@pytest.mark.parametrize(("count", "is_known"), [(4, True), (6, True), (6, False)])
def test_regions_of_mapped_points_hold_the_truth_in_95_of_100_homographies(
    count: int, is_known: bool
) -> None:
    random = np.random.default_rng([count, is_known])
    straight = [
        CameraView(replace(v.lens, k1=0.0, k2=0.0), v.robot_from_camera) for v in views(100)
    ]
    points = np.array(PLAYGROUND_CORNERS_MM + MORE)[:count]
    held = 0
    for index in range(1000):
        view = straight[index % 100]
        lain = points + random.normal(0.0, NOISE.placement_mm, points.shape)
        pixels = view.to_picture(lain, TOP) + random.normal(0.0, NOISE.pixel_px, points.shape)
        fit = fit_plane(pixels, points, NOISE, is_noise_known=is_known)
        place = random.uniform((300.0, -350.0), (700.0, 300.0), (1, 2))
        at = view.to_picture(place, TOP)
        miss = (fit.to_robot(at) - place)[0]
        held += mahalanobis_squared(miss, fit.covariance_at(at)[0]) <= fit.region_factor(2)
    assert 930 <= held <= 970, held


def test_regions_hold_the_truth_where_the_lens_is_known() -> None:
    random = np.random.default_rng(77)
    points = np.array(PLAYGROUND_CORNERS_MM)
    held = 0
    for view in views(100):
        lain = points + random.normal(0.0, NOISE.placement_mm, points.shape)
        pixels = view.to_picture(lain, TOP) + random.normal(0.0, NOISE.pixel_px, points.shape)
        fit = fit_place(pixels, points, TOP, view.lens, NOISE)
        place = random.uniform((300.0, -350.0), (700.0, 300.0), (1, 2))
        at = view.to_picture(place, TOP)
        miss = (fit.to_robot(at) - place)[0]
        held += mahalanobis_squared(miss, fit.covariance_at(at)[0]) <= fit.region_factor(2)
    # 95 % of 100 are 95 with a deviation of 2.2; 200 whole cells are in the benchmarks.
    assert 88 <= held <= 99, held


def test_four_exact_pairs_give_back_the_cameras_place() -> None:
    points = np.array(PLAYGROUND_CORNERS_MM)
    for view in views(5):
        fit = fit_place(view.to_picture(points, TOP), points, TOP, view.lens, NOISE)
        np.testing.assert_allclose(
            fit.view.robot_from_camera.matrix, view.robot_from_camera.matrix, atol=1e-5
        )
