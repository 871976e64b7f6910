"""Boards and markers, drawn and photographed."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.errors import VisionError
from cell.geometry import LensModel
from cell.vision.markers import (
    Board,
    find_board,
    find_charuco,
    find_chessboard,
    find_markers,
    marker_pose,
)

PHOTOGRAPHS = Path(__file__).parents[2] / "data" / "photographs"
LENS = LensModel(
    width_px=1280,
    height_px=960,
    focal_u_px=1000,
    focal_v_px=1000,
    centre_u_px=640,
    centre_v_px=480,
)


def photograph(name: str) -> NDArray[np.uint8]:
    picture = cv2.imread(str(PHOTOGRAPHS / name))
    assert picture is not None
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)


@pytest.mark.parametrize("kind", ["charuco", "chessboard"])
def test_corners_of_a_drawn_board_are_where_it_has_them(kind: str) -> None:
    board = Board(
        kind="charuco" if kind == "charuco" else "chessboard",
        columns=9,
        rows=6,
        square_mm=30.0,
        marker_mm=22.0 if kind == "charuco" else 0.0,
    )
    drawn = board.draw(4.0)
    picture = np.full((960, 1280), 200, np.uint8)
    picture[100 : 100 + drawn.shape[0], 60 : 60 + drawn.shape[1]] = drawn
    found = find_board(picture, board)
    assert found is not None
    assert found.ids.tolist() == list(range(40))
    expected = board.points_mm[:, :2] * 4.0 + (59.5, 99.5)
    assert np.abs(found.pixels - expected).max() < 0.1


def test_half_hidden_charuco_keeps_its_numbers_and_a_chessboard_is_not_seen() -> None:
    board = Board(kind="charuco", columns=9, rows=6, square_mm=30.0, marker_mm=22.0)
    picture = np.full((960, 1280), 200, np.uint8)
    picture[100:820, 60:1140] = board.draw(4.0)
    picture[:, 500:] = 128
    found = find_charuco(picture, board)
    assert found is not None
    expected = board.points_mm[found.ids, :2] * 4.0 + (59.5, 99.5)
    assert 4 <= len(found.ids) < 40
    assert np.abs(found.pixels - expected).max() < 0.15
    assert find_chessboard(picture, 9, 6) is None


def test_boards_and_dictionaries_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="does not fit"):
        Board(kind="charuco", columns=5, rows=5, square_mm=20.0, marker_mm=20.0)
    with pytest.raises(ValueError, match="3 x 3"):
        Board(kind="chessboard", columns=2, rows=5, square_mm=20.0)
    with pytest.raises(VisionError, match="no dictionary"):
        find_markers(np.zeros((100, 100), np.uint8), "DICT_NONE")
    with pytest.raises(VisionError, match="no picture"):
        find_markers(np.zeros((100, 100), np.float64).astype(np.uint16).view(), "DICT_4X4_50")  # type: ignore[arg-type]


def test_empty_picture_has_no_markers() -> None:
    assert find_markers(np.full((480, 640), 90, np.uint8)) == ()


def seen_marker(
    turn: NDArray[np.float64], shift: NDArray[np.float64], generator: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return the picture of a marker of 60 mm, and where its corners are."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    sheet = np.full((1200, 1200), 255, np.uint8)
    sheet[200:1000, 200:1000] = cv2.aruco.generateImageMarker(dictionary, 7, 800)
    # Only the part around the marker is drawn, at twice the scale.
    left, top = (LENS.to_picture(shift[:2] / shift[2]) - 200.0).round().astype(int)
    grid = np.stack(np.meshgrid(np.arange(800), np.arange(800)), -1)
    fine = (grid + 0.5) / 2.0 - 0.5 + (left, top)
    rays = np.concatenate([(fine - (640, 480)) / 1000.0, np.ones((800, 800, 1))], axis=-1)
    plane = np.linalg.inv(np.stack([turn[:, 0], turn[:, 1], shift], axis=1))
    on_marker = rays @ plane.T
    on_marker = on_marker[..., :2] / on_marker[..., 2:]
    u = (on_marker[..., 0] / 60.0 + 0.5) * 800 + 199.5
    v = (0.5 - on_marker[..., 1] / 60.0) * 800 + 199.5
    places = np.stack([u, v], -1).astype(np.float32)
    seen = cv2.remap(sheet, places, None, cv2.INTER_LINEAR, borderValue=255)  # type: ignore[call-overload]
    seen = cv2.resize(cv2.GaussianBlur(seen, (0, 0), 1.4), (400, 400), interpolation=3)
    picture = np.full((1400, 1700), 255.0)
    picture[top + 200 : top + 600, left + 200 : left + 600] = seen
    seen = picture[200:1160, 200:1480]
    noisy = 0.7 * seen + 20.0 + generator.normal(0.0, 2.0, seen.shape)
    square = 30.0 * np.array([(-1, 1, 0), (1, 1, 0), (1, -1, 0), (-1, -1, 0)]) @ turn.T + shift
    corners = LENS.to_picture(square[:, :2] / square[:, 2:])
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8), corners


def test_marker_s_corners_have_no_bias_and_its_pose_is_as_good_as_it_says() -> None:
    generator = np.random.default_rng(3)
    misses, scaled = [], []
    for _ in range(12):
        facing = np.diag([1.0, -1.0, -1.0])
        turn = np.asarray(cv2.Rodrigues(generator.normal(0.0, 0.4, 3))[0], np.float64) @ facing
        shift = np.array(
            [
                generator.uniform(-150, 150),
                generator.uniform(-100, 100),
                generator.uniform(400, 700),
            ]
        )
        picture, corners = seen_marker(turn, shift, generator)
        (marker,) = find_markers(picture)
        assert marker.number == 7
        misses.append(marker.corners_px - corners)
        pose = marker_pose(marker, 60.0, LENS)
        assert pose is not None
        off = pose.best.camera_from_marker.translation_mm - shift
        scaled.append(off / pose.shift_deviation_mm)
        assert 0.0 <= pose.ambiguity <= 1.0
    assert np.sqrt(np.mean(np.square(misses))) < 0.12
    assert np.abs(np.mean(misses, axis=0)).max() < 0.08
    assert np.sqrt(np.mean(np.square(scaled))) < 1.5


def test_photographs_of_a_chessboard_give_the_lens() -> None:
    board = Board(kind="chessboard", columns=10, rows=7, square_mm=25.0)
    points, pixels = [], []
    for path in sorted(PHOTOGRAPHS.glob("left*.jpg")):
        found = find_chessboard(photograph(path.name), 10, 7)
        assert found is not None, path.name
        points.append(board.points_mm.astype(np.float32))
        pixels.append(found.pixels.astype(np.float32).reshape(-1, 1, 2))
    assert len(pixels) == 13
    rms_px, matrix, coefficients, _, _ = cv2.calibrateCamera(
        points,
        pixels,
        (640, 480),
        None,
        None,
    )
    assert rms_px < 0.35
    # The values of OpenCV's own tutorial for these photographs.
    assert matrix[0, 0] == pytest.approx(535.0, abs=8.0)
    assert matrix[1, 1] == pytest.approx(535.0, abs=8.0)
    assert coefficients.ravel()[0] == pytest.approx(-0.28, abs=0.04)


def test_photographed_markers_are_found_and_stand_upon_one_table() -> None:
    lens = LensModel(
        width_px=640,
        height_px=480,
        focal_u_px=580,
        focal_v_px=580,
        centre_u_px=319.5,
        centre_v_px=239.5,
    )
    found = find_markers(photograph("singlemarkersoriginal.jpg"), "DICT_6X6_250")
    assert {marker.number for marker in found} == {23, 40, 62, 98, 124, 203}
    for marker in found:
        pose = marker_pose(marker, 40.0, lens, noise_px=0.3)
        assert pose is not None
        assert pose.best.residual_px < 1.5


def test_photographed_charuco_board_is_read() -> None:
    board = Board(
        kind="charuco",
        columns=5,
        rows=7,
        square_mm=40.0,
        marker_mm=20.0,
        dictionary="DICT_6X6_250",
    )
    found = find_charuco(photograph("choriginal.jpg"), board)
    assert found is not None
    assert len(found.ids) >= 20
    flat = board.points_mm[found.ids, :2]
    matrix, _ = cv2.findHomography(flat, found.pixels)
    back = cv2.perspectiveTransform(flat[:, None], matrix)[:, 0]
    assert np.sqrt(np.mean(np.square(back - found.pixels))) < 1.0
