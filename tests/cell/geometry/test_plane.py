from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cell.geometry import PlaneMap
from cell.profile import load_profile

# Robot x, y and picture u, v of the published calibration; pair 3 is printed with y = -300.
PAIRS = [
    ((700.0, -350.0), (46.8, 821.5)),
    ((700.0, 300.0), (1175.8, 815.1)),
    ((300.0, 300.0), (1166.8, 123.0)),
    ((300.0, -350.0), (44.3, 132.9)),
]
PRINTED = ((0.0066, 0.5876, 221.9813), (0.5812, -0.0050, -375.5685), (0.0, 0.0, 1.0))


def plane_map() -> PlaneMap:
    rows = load_profile("mash").cameras["top"].plane_map
    assert rows is not None
    return PlaneMap(rows)


def fit(pairs: list[tuple[tuple[float, float], tuple[float, float]]]) -> NDArray[np.float64]:
    """Return the homography picture to robot of four pairs (direct linear transform)."""
    rows = []
    for (x, y), (u, v) in pairs:
        rows.append([u, v, 1, 0, 0, 0, -x * u, -x * v, -x])
        rows.append([0, 0, 0, u, v, 1, -y * u, -y * v, -y])
    matrix = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    return np.asarray(matrix / matrix[2, 2])


@pytest.mark.parametrize(("robot", "picture"), PAIRS)
def test_map_of_the_profile_fits_the_published_pairs(
    robot: tuple[float, float], picture: tuple[float, float]
) -> None:
    # The four pairs determine the map; the one printed digit of its last row leaves 3 mm.
    assert plane_map().to_robot(*picture) == pytest.approx(robot, abs=3.0)


def test_pair_three_with_the_corrected_sign_reproduces_the_printed_matrix() -> None:
    assert fit(PAIRS) == pytest.approx(np.array(PRINTED), abs=0.06)
    misprinted = [*PAIRS[:2], ((300.0, -300.0), PAIRS[2][1]), PAIRS[3]]
    assert np.abs(fit(misprinted) - PRINTED).max() > 10.0


def test_map_of_the_profile_is_that_fit() -> None:
    assert fit(PAIRS) == pytest.approx(np.array(plane_map().rows), abs=0.06)


def test_a_pixel_is_about_0_58_mm_and_u_runs_along_robot_y() -> None:
    x0, y0 = plane_map().to_robot(640, 480)
    x1, y1 = plane_map().to_robot(641, 480)
    assert y1 - y0 == pytest.approx(0.58, abs=0.01)
    assert abs(x1 - x0) < 0.02


def test_there_and_back_is_the_same_pixel() -> None:
    plane = plane_map()
    for pixel in [(0.0, 0.0), (640.0, 480.0), (1279.0, 959.0)]:
        assert plane.to_picture(*plane.to_robot(*pixel)) == pytest.approx(pixel, abs=1e-6)


def test_pixel_on_the_horizon_is_refused() -> None:
    plane = PlaneMap(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.01, 0.0, -1.0)))
    with pytest.raises(ValueError, match="horizon"):
        plane.to_robot(100.0, 5.0)


def test_map_without_an_inverse_is_refused() -> None:
    flat = PlaneMap(((1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    with pytest.raises(ValueError, match="horizon"):
        flat.to_picture(3.0, 4.0)
