"""PNG files read back by another program's decoder, and patterns against their definition."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from cell.drivers.kiosk.patterns import (
    BLACK,
    WHITE,
    checkerboard,
    crosshair,
    gray_code,
    gray_code_bits,
    solid,
)
from cell.drivers.kiosk.png import encode_png


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (9, 1), (36, 64)], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_a_png_file_has_the_pixels_it_was_made_of(shape: tuple[int, int], seed: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 256, (*shape, 3), np.uint8)
    decoded = cv2.imdecode(np.frombuffer(encode_png(pixels), np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    assert np.array_equal(decoded[..., ::-1], pixels)


def test_a_view_that_is_not_contiguous_is_encoded_too() -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (8, 16, 3), np.uint8)[::2, ::-1]
    decoded = cv2.imdecode(np.frombuffer(encode_png(pixels), np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    assert np.array_equal(decoded[..., ::-1], pixels)


@pytest.mark.parametrize("axis", ["columns", "rows"])
@pytest.mark.parametrize("size", [(7, 5), (64, 36), (33, 17)], ids=str)
def test_gray_code_pictures_tell_every_place_and_neighbours_differ_in_one(
    axis: str, size: tuple[int, int]
) -> None:
    width, height = size
    count = width if axis == "columns" else height
    codes = np.zeros(count, int)
    for bit in range(gray_code_bits(count)):
        if axis == "columns":
            picture = gray_code(width, height, "columns", bit)
            line = picture[0, :, 0]
            assert (picture == line[None, :, None]).all()
        else:
            picture = gray_code(width, height, "rows", bit)
            line = picture[:, 0, 0]
            assert (picture == line[:, None, None]).all()
        inverse = gray_code(width, height, "columns" if axis == "columns" else "rows", bit,
                            is_inverted=True)  # fmt: skip
        assert (picture.astype(int) + inverse == 255).all()
        codes |= (line == 255).astype(int) << bit
    assert len(set(codes)) == count
    assert all(int(a ^ b).bit_count() == 1 for a, b in zip(codes, codes[1:], strict=False))
    decoded = codes.copy()
    for shift in (1, 2, 4, 8):
        decoded ^= decoded >> shift
    assert decoded.tolist() == list(range(count))


def test_a_bit_that_the_code_does_not_have_is_refused() -> None:
    with pytest.raises(ValueError, match="bits 0 to 10, not 11"):
        gray_code(1920, 1080, "columns", 11)


def test_a_checkerboard_begins_dark_at_its_corner_and_alternates() -> None:
    board = checkerboard(10, 6, 2, corner_px=(3, 1))
    assert (board[1:3, 3:5] == BLACK).all()
    assert (board[1:3, 5:7] == WHITE).all()
    assert (board[3:5, 3:5] == WHITE).all()
    assert (board[0, 3:5] == WHITE).all()
    with pytest.raises(ValueError, match="0 pixels"):
        checkerboard(10, 6, 0)


@pytest.mark.parametrize("at", [(0, 0), (9, 5), (4, 2)], ids=str)
def test_a_crosshair_has_its_middle_at_the_pixel(at: tuple[int, int]) -> None:
    cross = crosshair(10, 6, at)
    lit = (cross == WHITE).all(axis=2)
    assert lit[at[1]].all()
    assert lit[:, at[0]].all()
    assert lit.sum() == 10 + 6 - 1


def test_a_short_thick_crosshair_is_symmetric_about_its_pixel() -> None:
    cross = crosshair(21, 21, (10, 10), arm_px=4, thickness_px=3, colour=(9, 8, 7))
    lit = (cross == (9, 8, 7)).all(axis=2)
    assert np.array_equal(lit, lit[::-1, ::-1])
    assert lit.sum() == 3 * 9 * 2 - 9
    assert not lit[10, 5]
    assert lit[10, 6]


@pytest.mark.parametrize(
    ("at", "thickness", "message"),
    [((10, 0), 1, "outside of 10 x 6"), ((0, -1), 1, "outside"), ((0, 0), 2, "odd number")],
    ids=["right of it", "above it", "even"],
)
def test_a_crosshair_that_cannot_be_drawn_is_refused(
    at: tuple[int, int], thickness: int, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        crosshair(10, 6, at, thickness_px=thickness)


def test_solid_is_one_colour_in_the_order_red_green_blue() -> None:
    assert (solid(4, 3, (1, 2, 3)) == np.array([1, 2, 3])).all()
