"""Boards that are not the one that was named, and squares in another unit."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from calibration.errors import CalibrationError
from calibration.lens.board_markers import count_by_dictionary, find_markers
from calibration.lens.fit import LensPrior
from calibration.lens.judging import judge_distance, other_board
from calibration.lens.procedure import calibrate_lens
from calibration.lens.result import judged
from calibration.pictures import picture_of
from calibration.player import play
from calibration.record import Measurement
from calibration.requests import Answer, Capture, Request
from cell.geometry import LensModel
from cell.profile import load_profile
from cell.stop import StopToken
from cell.vision.boards import Board
from tests.calibration.lens.boards import BOARD, board_views
from tests.calibration.playing import Answers, codes, site_of

WIDE = LensModel(
    width_px=1280, height_px=960, focal_u_px=950.0, focal_v_px=950.0, centre_u_px=645.0,
    centre_v_px=470.0, k1=-0.08,
)  # fmt: skip


def photograph(board: Board, seed: int = 1) -> np.ndarray:
    """A board held aslant before a grey wall, 1280 x 960."""
    drawn = board.draw(2.0)
    high, wide = drawn.shape
    page = cv2.copyMakeBorder(drawn, 30, 30, 30, 30, cv2.BORDER_CONSTANT, value=255)
    random = np.random.default_rng(seed)
    corners = np.array([(0, 0), (wide + 60, 0), (wide + 60, high + 60), (0, high + 60)])
    scale = 900.0 / (wide + 60)
    seen = corners * scale + (170.0, 120.0) + random.uniform(-35.0, 35.0, (4, 2))
    matrix = cv2.getPerspectiveTransform(corners.astype(np.float32), seen.astype(np.float32))
    grey = cv2.warpPerspective(page, matrix, (1280, 960), flags=cv2.INTER_AREA,
                               borderMode=cv2.BORDER_CONSTANT, borderValue=120)  # fmt: skip
    return np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2).astype(np.uint8))


@pytest.mark.parametrize("columns", [8, 9, 11, 12])
@pytest.mark.parametrize("rows", [7, 8])
def test_the_board_that_was_named_is_no_other(columns: int, rows: int) -> None:
    board = replace(BOARD, columns=columns, rows=rows)
    assert other_board(photograph(board), board) is None


@pytest.mark.parametrize(
    ("shown", "told"),
    [
        (replace(BOARD, columns=10), "10 squares across"),
        (replace(BOARD, columns=12), "12 squares across"),
        (replace(BOARD, columns=8, rows=11), "8 squares across"),
        (replace(BOARD, rows=10), "a marker number 54, where 43 is the last"),
        (replace(BOARD, dictionary="DICT_6X6_250"), "dictionary DICT_6X6_50 or a larger one"),
    ],
)
def test_a_charuco_board_of_another_size_or_dictionary_is_named(shown: Board, told: str) -> None:
    finding = other_board(photograph(shown), BOARD)
    assert finding is not None
    assert finding.code == "wrong-board"
    assert told in finding.text


def test_a_wall_without_a_board_is_no_other_board() -> None:
    assert other_board(np.full((960, 1280, 3), 120, np.uint8), BOARD) is None
    assert set(count_by_dictionary(np.full((960, 1280, 3), 120, np.uint8)).values()) == {0}


def test_a_dictionary_that_there_is_not_is_refused() -> None:
    with pytest.raises(CalibrationError, match="no dictionary DICT_9X9_50"):
        find_markers(np.full((96, 128, 3), 120, np.uint8), "DICT_9X9_50")


def live(shown: Board) -> Measurement:
    class Camera:
        taken = 0

        def perform(self, request: Request) -> Answer:
            assert isinstance(request, Capture)
            self.taken += 1
            return picture_of("top", photograph(shown, self.taken))

    answers: dict[str, bool | float | str | tuple[float, ...]] = {
        f"view {number}": "take" if number <= 4 else "enough" for number in range(1, 6)
    }
    return play(
        calibrate_lens(site_of(load_profile("mash"))), hands=Camera(), asker=Answers(answers),
        stop=StopToken(),
    )  # fmt: skip


def test_miscounted_squares_are_named_by_the_procedure_and_set_nothing() -> None:
    found = live(replace(BOARD, columns=10))
    assert "wrong-board" in codes(found)
    assert found.grade.value == "BAD"
    assert found.values == {}
    assert "wrong-board" not in codes(live(BOARD))


@pytest.mark.parametrize(
    ("square_mm", "code"), [(30.0, None), (3.0, "cm-for-mm"), (0.03, "m-for-mm")]
)
def test_the_unit_of_the_squares_is_named(square_mm: float, code: str | None) -> None:
    board, views = board_views(WIDE, 9, np.random.default_rng(2), noise_px=0.2)
    there_mm = 1.4 * 950.0 * board.size_mm[0] / 1280
    given = replace(board, square_mm=square_mm, marker_mm=0.7 * square_mm)
    for distance_mm, grade in ((0.0, "DEGRADED"), (there_mm, "BAD")):
        found = judged("top", "GUID", given, views, (1280, 960), LensPrior(), quality_px=1.0,
                       distance_mm=distance_mm)  # fmt: skip
        named = {finding.code: finding.grade.value for finding in found.findings}
        assert {c: g for c, g in named.items() if c.endswith("for-mm")} == (
            {} if code is None else {code: grade}
        )


@pytest.mark.parametrize(("given_mm", "code"), [(80.0, "cm-for-mm"), (0.8, "m-for-mm")])
def test_a_distance_in_another_unit_is_named(given_mm: float, code: str) -> None:
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 800.0])
    (finding,) = judge_distance([pose], given_mm)
    assert finding.code == code
    assert "the distance seems to be given" in finding.text


def test_squares_that_are_wrong_by_no_unit_are_told_only_with_a_distance() -> None:
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 800.0])
    assert judge_distance([pose], 0.0) == ()
    (finding,) = judge_distance([pose], 400.0)
    assert finding.code == "wrong-square-size"
    (finding,) = judge_distance([pose * 1000.0], 0.0)
    assert finding.code == "wrong-square-size"
