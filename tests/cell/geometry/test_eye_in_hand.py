from __future__ import annotations

from math import acos, atan, cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest

from cell.geometry import JointPositions
from cell.geometry.eye_in_hand import EyeInHand

WINDOW = JointPositions((45.0, 105.0, 0.0, 0.0))


def printed_place(eye: EyeInHand, i: float, j: float, j1: float, j2: float) -> tuple[float, float]:
    """Bloch 4.4-4.14; in 4.9 the distances of the triangle stand where they belong."""
    b_x, b_y = eye.reference_px
    theta = 180 - eye.b_angle_deg - eye.angle_error_deg
    up, right = abs(b_y - j) * eye.scale_v_mm, abs(b_x - i) * eye.scale_u_mm
    gamma = theta + degrees(atan(up / right))
    d_c = sqrt(up**2 + right**2)
    d_t_c = eye.d_t_c_mm
    d_t = sqrt(d_t_c**2 + d_c**2 - 2 * d_t_c * d_c * cos(radians(gamma)))
    beta = degrees(acos((d_t_c**2 + d_t**2 - d_c**2) / (2 * d_t_c * d_t)))
    phi = radians(180 - (eye.b_angle_deg - beta) - (j1 + j2))
    first, both = radians(j1), radians(j1 + j2)
    x = eye.link_2_mm * cos(both) + eye.link_1_mm * cos(first) + d_t * cos(phi)
    y = eye.link_2_mm * sin(both) + eye.link_1_mm * sin(first) - d_t * sin(phi)
    return x, y


def test_the_vectors_are_the_printed_formulas_right_of_and_above_the_reference_pixel() -> None:
    generator = np.random.default_rng(5)
    eye = EyeInHand(face_height_mm=0.0)
    for _ in range(500):
        i, j = generator.uniform(3.001, 511), generator.uniform(0, 456.99)
        j1, j2 = generator.uniform(0, 200), generator.uniform(0, 135)
        ours = eye.to_robot(i, j, JointPositions((j1, j2, 0.0, 0.0)))
        assert ours == pytest.approx(printed_place(eye, i, j, j1, j2), abs=1e-8)


def test_the_printed_formulas_fail_left_of_the_reference_pixel_where_the_vectors_go_on() -> None:
    eye = EyeInHand(face_height_mm=0.0, reference_px=(255.0, 241.0))
    inside, outside = (300.0, 200.0), (210.0, 200.0)
    assert eye.to_robot(*inside, WINDOW) == pytest.approx(
        printed_place(eye, *inside, 45.0, 105.0), abs=1e-8
    )
    assert eye.to_robot(*outside, WINDOW) != pytest.approx(
        printed_place(eye, *outside, 45.0, 105.0), abs=10.0
    )


def test_the_printed_cosine_of_beta_would_be_of_the_wrong_sides() -> None:
    """4.9 prints (d_t_c² + d_c² - d_c²)/(2 d_t_c d_c), which is d_t_c/(2 d_c) and may pass 1."""
    eye = EyeInHand()
    d_c = 40 * eye.scale_u_mm
    assert eye.d_t_c_mm / (2 * d_c) > 1


def test_the_printed_angle_is_the_direction_clockwise_with_alpha_from_the_downward() -> None:
    generator = np.random.default_rng(6)
    eye = EyeInHand()
    for _ in range(200):
        right, down = generator.normal(size=2)
        j1, j2 = generator.uniform(0, 90, 2)
        printed_alpha = atan(right / down) * 180 / pi
        printed = -(printed_alpha + j1 + j2 - 90 - eye.angle_error_deg)
        ours = eye.angle_of(degrees(np.arctan2(-down, right)), JointPositions((j1, j2, 0, 0)))
        assert -90 <= ours < 90
        assert sin(radians(ours + printed)) == pytest.approx(0.0, abs=1e-9)


def test_a_line_has_the_direction_of_two_of_its_points() -> None:
    eye = EyeInHand(face_height_mm=0.0)
    a, b = (100.0, 300.0), (260.0, 180.0)
    alpha = degrees(np.arctan2(120 * eye.scale_v_mm, 160 * eye.scale_u_mm))
    (x1, y1), (x2, y2) = eye.to_robot(*a, WINDOW), eye.to_robot(*b, WINDOW)
    across = (x2 - x1) * sin(radians(eye.angle_of(alpha, WINDOW))) - (y2 - y1) * cos(
        radians(eye.angle_of(alpha, WINDOW))
    )
    assert across == pytest.approx(0.0, abs=1e-9)


def test_the_reference_pixel_lies_at_its_distance_from_the_gripper() -> None:
    eye = EyeInHand()
    x, y = eye.to_robot(3.0, 457.0, WINDOW, height_mm=0.0)
    hand = eye.gripper(np.array([45.0, 105.0]))
    assert np.hypot(x - hand[0], y - hand[1]) == pytest.approx(81.8)


@pytest.mark.parametrize("height_mm", [0.0, 8.0, 30.0, None])
def test_pixels_and_places_are_inverse(height_mm: float | None) -> None:
    generator = np.random.default_rng(7)
    pixels = generator.uniform(0, 480, (100, 2))
    joints = generator.uniform(0, 130, (100, 2))
    eye = EyeInHand()
    places = eye.places(pixels, joints, height_mm=height_mm)
    assert np.abs(eye.pixels(places, joints, height_mm=height_mm) - pixels).max() < 1e-9
    x, y = places[3]
    assert eye.to_picture(
        x, y, JointPositions(tuple(joints[3])), height_mm=height_mm
    ) == pytest.approx(tuple(pixels[3]))


def test_parallax_is_the_printed_correction() -> None:
    """Corner + (centre - corner)·d_ft/d_ct (2.2.3)."""
    eye = EyeInHand()
    corner = np.array([400.0, 60.0])
    corrected = corner + (np.array([255.0, 241.0]) - corner) * 8.0 / 420.0
    joints = np.array([45.0, 105.0])
    assert eye.places(corner, joints) == pytest.approx(
        eye.places(corrected, joints, height_mm=0.0), abs=1e-9
    )


def test_a_point_at_the_camera_s_height_is_refused() -> None:
    with pytest.raises(ValueError, match="420 mm"):
        EyeInHand().to_robot(0, 0, WINDOW, height_mm=420.0)
