from __future__ import annotations

import numpy as np
import pytest

from calibration.homography.dlt import apply, homography
from calibration.homography.judging import Pairs, judge_pairs
from cell.profile import load_profile
from tests.calibration.hidden_truth import (
    PLAYGROUND_CORNERS_MM,
    block_top_mm,
    hidden,
    playground_grid,
    true_view,
)

ROBOT = ((700.0, -350.0), (700.0, 300.0), (300.0, 300.0), (300.0, -350.0))
PICTURE = ((46.8, 821.5), (1175.8, 815.1), (1166.8, 123.0), (44.3, 132.9))
PRINTED = ((0.00656, 0.58748, 222.028), (0.58116, -0.00504, -375.536), (0.0, 1e-5, 1.0))
DIGITS = ((5, 5, 3), (5, 5, 3), (5, 5, 5))


def pairs(robot: object = ROBOT, picture: object = PICTURE) -> Pairs:
    points, pixels = np.array(robot, float), np.array(picture, float)
    return Pairs(tuple(f"pair {i + 1}" for i in range(len(points))), pixels, points)


def test_the_references_pairs_give_its_matrix_to_005_percent_of_each_entry() -> None:
    found = homography(np.array(PICTURE), np.array(ROBOT))
    for row in range(3):
        for column in range(3):
            printed = PRINTED[row][column]
            # Some entries are printed with so few digits that half a unit of the last is more.
            allowed = max(5e-4 * abs(printed), 0.5 * 10.0 ** -DIGITS[row][column])
            assert abs(found[row, column] - printed) <= allowed, (row, column)


def test_the_large_entries_agree_to_005_percent_without_any_rounding() -> None:
    found = homography(np.array(PICTURE), np.array(ROBOT))
    for row, column in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 2)):
        assert found[row, column] == pytest.approx(PRINTED[row][column], rel=5e-4)


def test_the_misprinted_pair_is_named_and_what_was_meant_is_guessed() -> None:
    (finding,) = judge_pairs(pairs([*ROBOT[:2], (300.0, -300.0), ROBOT[3]]))
    assert (finding.code, finding.grade.value) == ("misplaced-pair", "BAD")
    assert finding.samples == ("pair 3",)
    assert "(300, 300) was meant" in finding.hint


def test_good_pairs_of_any_hidden_cell_are_plausible() -> None:
    profile = load_profile("mash")
    before = np.array(profile.cameras["top"].plane_map)
    for seed in range(100):
        view = true_view(hidden(profile, seed))
        points = np.array(PLAYGROUND_CORNERS_MM)
        noise = np.random.default_rng(seed).normal(0.0, 0.7, points.shape)
        good = pairs(points, view.to_picture(points, block_top_mm(profile)) + noise)
        assert judge_pairs(good, lambda pixels: apply(before, pixels)) == (), seed


def test_every_exchange_of_two_pairs_is_named() -> None:
    matrix = np.array(PRINTED)
    for i in range(4):
        for j in range(i):
            order = [0, 1, 2, 3]
            order[i], order[j] = j, i
            exchanged = pairs(ROBOT, [PICTURE[k] for k in order])
            names = {f"pair {i + 1}", f"pair {j + 1}"}
            (known,) = judge_pairs(exchanged, lambda pixels: apply(matrix, pixels))
            assert (known.code, set(known.samples)) == ("swapped-pairs", names)
            (alone,) = judge_pairs(exchanged)
            assert alone.code == "swapped-pairs"
            assert names <= set(alone.samples)


def test_corners_named_the_wrong_way_round_are_a_mirrored_order() -> None:
    (finding,) = judge_pairs(pairs(ROBOT, [PICTURE[k] for k in (1, 0, 3, 2)]))
    assert finding.code == "mirrored-order"


def test_corners_that_begin_half_a_round_later_need_the_map_before() -> None:
    turned = pairs(ROBOT, [PICTURE[k] for k in (2, 3, 0, 1)])
    assert judge_pairs(turned) == ()
    matrix = np.array(PRINTED)
    (finding,) = judge_pairs(turned, lambda pixels: apply(matrix, pixels))
    assert finding.code == "turned-order"


@pytest.mark.parametrize(
    ("ratio", "code"), [(10.0, "cm-for-mm"), (25.4, "inches-for-mm"), (1000.0, "m-for-mm")]
)
def test_other_units_are_named(ratio: float, code: str) -> None:
    matrix = np.array(PRINTED)
    points = np.array(ROBOT) / ratio
    (finding,) = judge_pairs(pairs(points), lambda pixels: apply(matrix, pixels))
    assert finding.code == code


def test_three_points_on_a_line_are_named() -> None:
    robot = [(300.0, 0.0), (500.0, 1.0), (700.0, 0.0), (500.0, 300.0)]
    inverse = np.linalg.inv(np.array(PRINTED))
    (finding,) = judge_pairs(pairs(robot, apply(inverse, np.array(robot))))
    assert finding.code == "collinear-points"
    assert finding.samples == ("pair 1", "pair 2", "pair 3")


def test_a_small_misprint_is_found_by_the_map_before() -> None:
    matrix = np.array(PRINTED)
    robot = [ROBOT[0], (680.0, 300.0), *ROBOT[2:]]
    (finding,) = judge_pairs(pairs(robot), lambda pixels: apply(matrix, pixels))
    assert (finding.code, finding.samples) == ("misplaced-pair", ("pair 2",))


def test_a_point_taken_twice_is_named() -> None:
    twice = pairs([*ROBOT, (300.4, -350.0)], [*PICTURE, (44.5, 132.0)])
    (finding,) = judge_pairs(twice)
    assert (finding.code, finding.samples) == ("duplicate-pair", ("pair 4", "pair 5"))


def test_many_pairs_recover_the_homography_they_were_made_with() -> None:
    matrix = np.array([[0.007, 0.59, 220.0], [0.58, -0.005, -370.0], [2e-5, -1e-5, 1.0]])
    points = playground_grid()
    pixels = apply(np.linalg.inv(matrix), points)
    np.testing.assert_allclose(homography(pixels, points), matrix, atol=1e-9)
