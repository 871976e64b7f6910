from __future__ import annotations

import pytest

from cell.geometry import LatticeMap

MASH = LatticeMap(step_mm=20, angle_deg=90, origin_x_mm=710, origin_y_mm=-265)


@pytest.mark.parametrize(
    ("lattice", "robot"),
    [((0, 0), (710, -265)), ((11, 0), (710, -45)), ((0, 11), (490, -265)), ((11, 11), (490, -45))],
)
def test_corners_of_the_world_lie_where_the_printed_matrix_puts_them(
    lattice: tuple[int, int], robot: tuple[float, float]
) -> None:
    assert MASH.to_robot(*lattice) == robot


@pytest.mark.parametrize("origin", [(710.0, -265.0), (711.0, -600.0)])
def test_map_is_the_printed_matrix_with_its_last_row_put_right(
    origin: tuple[float, float],
) -> None:
    # Rows as printed, [[0, -20, tx], [20, 0, ty], [0, 0, 1]]; the source has 0 0 0 last.
    rows = ((0, -20, origin[0]), (20, 0, origin[1]), (0, 0, 1))
    lattice = LatticeMap(step_mm=20, angle_deg=90, origin_x_mm=origin[0], origin_y_mm=origin[1])
    for point in [(0, 0), (3, 7), (11, 11), (-2, 5)]:
        x, y, w = (row[0] * point[0] + row[1] * point[1] + row[2] for row in rows)
        assert lattice.to_robot(*point) == (x / w, y / w)


def test_origin_given_in_the_text_lies_past_the_arm() -> None:
    text = LatticeMap(step_mm=20, angle_deg=90, origin_x_mm=711, origin_y_mm=-600)
    x, y = text.to_robot(0, 0)
    assert (x * x + y * y) ** 0.5 == pytest.approx(930, abs=0.5)


def test_right_is_towards_robot_y_and_up_is_against_robot_x() -> None:
    x, y = MASH.to_robot(4, 4)
    assert MASH.to_robot(5, 4) == (x, y + 20)
    assert MASH.to_robot(4, 5) == (x - 20, y)


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 90.0, 180.0, -90.0, 450.0, 123.4])
def test_there_and_back_is_the_same_point(angle_deg: float) -> None:
    lattice = LatticeMap(step_mm=17.5, angle_deg=angle_deg, origin_x_mm=12, origin_y_mm=-34)
    for point in [(0.0, 0.0), (3.25, -7.5), (11.0, 11.0)]:
        assert lattice.to_lattice(*lattice.to_robot(*point)) == pytest.approx(point, abs=1e-12)


def test_angle_turns_lattice_x_counter_clockwise_from_robot_x() -> None:
    lattice = LatticeMap(step_mm=10, angle_deg=30, origin_x_mm=0, origin_y_mm=0)
    assert lattice.to_robot(1, 0) == pytest.approx((8.660254, 5.0))
    assert lattice.to_robot(0, 1) == pytest.approx((-5.0, 8.660254))
