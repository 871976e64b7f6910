from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.geometry import CameraView, LensModel, PlaneMap, PlaneView, Pose, Transform

LENS = LensModel(
    width_px=1280, height_px=960, focal_u_px=950.0, focal_v_px=948.0, centre_u_px=655.0,
    centre_v_px=470.0, k1=-0.12, k2=0.03, p1=0.0008, p2=-0.0006, k3=-0.004,
)  # fmt: skip
VIEW = CameraView(LENS, Transform.from_pose(Pose(500, -20, 1500, 178.0, 2.5, 91.0)))


def grid() -> NDArray[np.float64]:
    u, v = np.meshgrid(np.linspace(0, 1279, 9), np.linspace(0, 959, 7))
    return np.stack([u, v], axis=-1).reshape(-1, 2)


def test_the_lens_agrees_with_opencv() -> None:
    directions = LENS.to_directions(grid())
    rays = np.concatenate([directions, np.ones((len(directions), 1))], axis=1)
    theirs, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), LENS.matrix, LENS.coefficients)
    assert np.abs(theirs[:, 0] - grid()).max() < 1e-7


def test_pixels_come_back_through_the_lens() -> None:
    assert np.abs(LENS.to_picture(LENS.to_directions(grid())) - grid()).max() < 1e-8


@pytest.mark.parametrize("height_mm", [0.0, 38.5, 71.5])
def test_pixels_come_back_from_the_table(height_mm: float) -> None:
    there = VIEW.to_robot(grid(), height_mm)
    assert np.abs(VIEW.to_picture(there, height_mm) - grid()).max() < 1e-7


def test_the_plane_map_of_a_view_maps_ideal_pixels_as_the_view_does() -> None:
    plane = PlaneView(VIEW.plane_map(71.5), 71.5)
    mapped = plane.to_robot(LENS.to_ideal(grid()), 71.5)
    assert np.abs(mapped - VIEW.to_robot(grid(), 71.5)).max() < 1e-7


def test_a_resized_lens_sees_the_same_directions() -> None:
    small = LENS.resized(640)
    halves = (grid() + 0.5) / 2 - 0.5
    assert np.abs(small.to_directions(halves) - LENS.to_directions(grid())).max() < 1e-9


def test_a_plane_view_refuses_a_height_it_was_not_measured_at() -> None:
    plane = PlaneView(PlaneMap(((1, 0, 0), (0, 1, 0), (0, 0, 1))), 71.5)
    with pytest.raises(ValueError, match="holds at 71.5 mm, not at 38.5 mm"):
        plane.to_robot(grid(), 38.5)


def test_a_pixel_over_the_horizon_is_refused() -> None:
    level = CameraView(LENS, Transform.from_pose(Pose(0, 0, 500, -90.0, 0.0, 0.0)))
    with pytest.raises(ValueError, match="horizon"):
        level.to_robot(grid(), 0.0)


def test_a_point_behind_the_camera_is_refused() -> None:
    with pytest.raises(ValueError, match="behind"):
        VIEW.project(np.array([[500.0, 0.0, 3000.0]]))
