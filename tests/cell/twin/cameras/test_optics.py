from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.devices.camera import MODES
from cell.geometry import Pose, Transform
from cell.twin.cameras.optics import (
    GridSpreader,
    Lens,
    coarse_rays,
    lens_for_mode,
    pixel_rays,
)
from tests.cell.twin.cameras.stage import PROFILE

LENSES = {name: lens_for_mode(placing, MODES[3]) for name, placing in PROFILE.twin.cameras.items()}
STRONG = Lens(
    width_px=1280,
    height_px=960,
    focal_px=1000,
    centre_u_px=640,
    centre_v_px=480,
    k1=-0.2,
    k2=0.03,
)


def some_points(lens: Lens, seed: int = 3) -> NDArray[np.float64]:
    generator = np.random.default_rng(seed)
    depth = generator.uniform(100, 3000, 400)
    x = generator.uniform(-0.5, 0.5, 400) * lens.width_px / lens.focal_px * depth
    y = generator.uniform(-0.5, 0.5, 400) * lens.height_px / lens.focal_px * depth
    return np.stack([x, y, depth], axis=1)


@pytest.mark.parametrize("lens", [*LENSES.values(), STRONG], ids=[*LENSES, "strong"])
def test_projection_agrees_with_opencv(lens: Lens) -> None:
    points = some_points(lens)
    matrix = np.array(
        [[lens.focal_px, 0, lens.centre_u_px], [0, lens.focal_px, lens.centre_v_px], [0, 0, 1]]
    )
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), matrix, np.array([lens.k1, lens.k2, 0.0, 0.0])
    )
    np.testing.assert_allclose(lens.project(points), expected[:, 0], atol=1e-6)


@pytest.mark.parametrize("lens", [*LENSES.values(), STRONG], ids=[*LENSES, "strong"])
def test_undistortion_inverts_projection(lens: Lens) -> None:
    generator = np.random.default_rng(1)
    pixels = generator.uniform((0, 0), (lens.width_px, lens.height_px), (500, 2))
    rays = np.column_stack([lens.undistort(pixels), np.ones(500)])
    np.testing.assert_allclose(lens.project(rays), pixels, atol=1e-6)


def test_distortion_moves_the_corners_and_not_the_centre() -> None:
    straight = Lens(width_px=1280, height_px=960, focal_px=1000, centre_u_px=640, centre_v_px=480)
    points = np.array([[0.0, 0.0, 1000.0], [600.0, 440.0, 1000.0]])
    moved = np.linalg.norm(STRONG.project(points) - straight.project(points), axis=1)
    assert moved[0] == 0.0
    assert moved[1] > 30.0


def test_points_far_outside_never_fold_back_into_the_picture() -> None:
    slopes = np.linspace(0.9, 50.0, 400)
    points = np.stack([slopes, np.zeros(400), np.ones(400)], axis=1)
    u_px = STRONG.project(points)[:, 0]
    assert (np.diff(u_px) > 0).all()
    assert (u_px > 1280).all()


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: str(mode.number))
def test_every_mode_shows_the_same_field_of_view(mode: object) -> None:
    placing = PROFILE.twin.cameras["top"]
    small = next(m for m in MODES if m is mode)
    lens, full = lens_for_mode(placing, small), lens_for_mode(placing, MODES[3])
    points = some_points(full)
    share = small.width_px / 1280
    np.testing.assert_allclose(
        lens.project(points) + 0.5, (full.project(points) + 0.5) * share, atol=1e-9
    )


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: str(mode.number))
@pytest.mark.parametrize("name", list(LENSES))
def test_interpolated_rays_are_exact_to_a_tenth_of_a_pixel(name: str, mode: object) -> None:
    chosen = next(m for m in MODES if m is mode)
    lens = lens_for_mode(PROFILE.twin.cameras[name], chosen)
    coarse = np.ascontiguousarray(coarse_rays(lens)[..., :2], np.float32)
    spread = GridSpreader(lens).spread(coarse)
    error_px = np.abs(spread - pixel_rays(lens)[..., :2]) * lens.focal_px
    assert error_px.max() < 0.1


def test_vignetting_takes_its_share_in_the_corners() -> None:
    lens = lens_for_mode(PROFILE.twin.cameras["top"], MODES[3])
    share = lens.brightness(np.array([[640.0, 480.0], [0.0, 0.0]]))
    assert share[0] == 1.0
    assert share[1] == pytest.approx(1.0 - lens.vignetting)


def test_top_camera_reproduces_the_printed_homography_within_two_millimetres() -> None:
    placing = PROFILE.twin.cameras["top"]
    pose = Pose(*placing.position_mm, *placing.rotation_deg)
    camera_from_robot = Transform.from_pose(pose).inverse()
    rows = PROFILE.cameras["top"].plane_map
    assert rows is not None
    homography = np.array(rows)
    step = PROFILE.lattice.step_mm
    x0, y0 = PROFILE.lattice.origin_mm
    tops = np.array([(x0 - step * j, y0 + step * i, 71.5) for i in range(12) for j in range(12)])
    pixels = LENSES["top"].project(camera_from_robot.apply(tops))
    mapped = np.column_stack([pixels, np.ones(len(pixels))]) @ homography.T
    error_mm = np.linalg.norm(mapped[:, :2] / mapped[:, 2:] - tops[:, :2], axis=1)
    assert error_mm.max() < 2.0
