import math

import pytest

from cell.contact import Footprint, Jaw, aligned_yaw_deg, push_out


def cube(x: float, y: float, yaw_deg: float = 0.0) -> Footprint:
    return Footprint(x_mm=x, y_mm=y, yaw_deg=yaw_deg, length_mm=33.0, width_mm=33.0)


def jaw(x: float = 0.0, y: float = 0.0) -> Jaw:
    return Jaw(x_mm=x, y_mm=y, axis=(0.0, 1.0), finger_width_mm=20.0, finger_thickness_mm=8.0)


def test_span_of_a_cube_between_the_fingers_is_its_width() -> None:
    span = jaw().span(cube(0.0, 4.0))
    assert span is not None
    assert span == pytest.approx((4.0 - 16.5, 4.0 + 16.5))


def test_span_of_a_cube_beside_the_fingers_is_none() -> None:
    assert jaw().span(cube(27.0, 0.0)) is None


def test_span_counts_only_what_lies_between_the_fingers_sides() -> None:
    turned = cube(0.0, 0.0, 45.0)
    span = jaw().span(turned)
    assert span is not None
    assert span[1] - span[0] == pytest.approx(33.0 * math.sqrt(2), abs=1e-6)
    shifted = jaw(20.0).span(turned)
    assert shifted is not None
    assert shifted[1] - shifted[0] < 33.0 * math.sqrt(2) - 10.0


def test_span_of_a_cylinder_is_its_diameter() -> None:
    disc = Footprint(x_mm=0.0, y_mm=0.0, yaw_deg=0.0, length_mm=33.0, width_mm=33.0, is_round=True)
    span = jaw().span(disc)
    assert span is not None
    assert span[1] - span[0] == pytest.approx(33.0, abs=0.3)


def test_push_out_takes_the_shortest_way() -> None:
    shift = push_out(cube(30.0, 5.0).polygon(), cube(0.0, 0.0).polygon())
    assert shift is not None
    assert shift == pytest.approx((3.0, 0.0))


def test_push_out_of_separate_outlines_is_none() -> None:
    assert push_out(cube(33.5, 0.0).polygon(), cube(0.0, 0.0).polygon()) is None


def test_push_out_frees_turned_outlines() -> None:
    fixed = cube(0.0, 0.0, 30.0)
    moved = cube(20.0, 12.0, 10.0)
    shift = push_out(moved.polygon(), fixed.polygon())
    assert shift is not None
    freed = cube(20.0 + shift[0] * 1.001, 12.0 + shift[1] * 1.001, 10.0)
    assert push_out(freed.polygon(), fixed.polygon()) is None


@pytest.mark.parametrize(
    ("yaw_deg", "axis_deg", "aligned_deg"),
    [
        (3.0, 90.0, 0.0),
        (-4.0, 90.0, 0.0),
        (47.0, 90.0, 90.0),
        (100.0, 90.0, 90.0),
        (5.0, 10.0, 10.0),
    ],
)
def test_a_box_turns_its_nearest_face_to_the_fingers(
    yaw_deg: float, axis_deg: float, aligned_deg: float
) -> None:
    assert aligned_yaw_deg(yaw_deg, axis_deg) == pytest.approx(aligned_deg)


def test_contains_knows_boxes_and_circles() -> None:
    assert cube(0.0, 0.0).contains(16.0, 16.0)
    disc = Footprint(x_mm=0.0, y_mm=0.0, yaw_deg=0.0, length_mm=33.0, width_mm=33.0, is_round=True)
    assert not disc.contains(16.0, 16.0)
    assert disc.contains(16.0, 0.0)
