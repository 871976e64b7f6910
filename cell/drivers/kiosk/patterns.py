"""Patterns for calibration and adjustment, exact to the pixel.

All return shape (height, width, 3), uint8, R G B.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Pixels: TypeAlias = NDArray[np.uint8]
Colour: TypeAlias = tuple[int, int, int]
Axis: TypeAlias = Literal["columns", "rows"]

BLACK: Colour = (0, 0, 0)
WHITE: Colour = (255, 255, 255)


def solid(width_px: int, height_px: int, colour: Colour) -> Pixels:
    """Return one colour all over, R G B each 0 to 255."""
    pixels = np.empty((height_px, width_px, 3), np.uint8)
    pixels[:] = colour
    return pixels


def checkerboard(
    width_px: int,
    height_px: int,
    square_px: int,
    *,
    corner_px: tuple[int, int] = (0, 0),
    dark: Colour = BLACK,
    light: Colour = WHITE,
) -> Pixels:
    """Return squares that alternate; a dark one has its upper left pixel at `corner_px`.

    Raises:
        ValueError: A square has less than one pixel.
    """
    if square_px < 1:
        raise ValueError(f"a square of {square_px} pixels cannot be shown; take 1 or more")
    columns = (np.arange(width_px) - corner_px[0]) // square_px
    rows = (np.arange(height_px) - corner_px[1]) // square_px
    return _two_colours((rows[:, None] + columns[None, :]) % 2 == 1, dark, light)


def gray_code_bits(size_px: int, stripe_px: int = 1) -> int:
    """Return how many Gray code pictures tell the stripes of `size_px` places apart."""
    return max(1, (-(-size_px // stripe_px) - 1).bit_length())


def gray_code_line(size_px: int, bit: int, stripe_px: int = 1) -> NDArray[np.bool_]:
    """Return whether a bit of the reflected binary (Gray) code of each place is set, (size,).

    Stripe i has the code i xor (i >> 1), so neighbours differ in one bit and a stripe's
    blurred edge is never off by more than one stripe.

    Args:
        size_px: How many places there are.
        bit: Which bit, 0 the finest; there are `gray_code_bits` of them.
        stripe_px: How many places in a row have the same code.

    Raises:
        ValueError: The code has no such bit.
    """
    bits = gray_code_bits(size_px, stripe_px)
    if not 0 <= bit < bits:
        raise ValueError(f"{size_px} places have Gray code bits 0 to {bits - 1}, not {bit}")
    stripes = np.arange(size_px) // stripe_px
    return np.asarray(((stripes ^ (stripes >> 1)) >> bit) & 1 == 1)


def gray_code(
    width_px: int, height_px: int, axis: Axis, bit: int, *, is_inverted: bool = False
) -> Pixels:
    """Return one bit of the Gray code of each column or row; a bit that is set is white.

    Args:
        width_px: Width of the picture.
        height_px: Height of the picture.
        axis: Whether columns or rows are told apart.
        bit: Which bit; see `gray_code_line`.
        is_inverted: Whether set bits are black; a pixel is read best from the two pictures.

    Raises:
        ValueError: The code has no such bit.
    """
    is_set = gray_code_line(width_px if axis == "columns" else height_px, bit) != is_inverted
    along = is_set[None, :] if axis == "columns" else is_set[:, None]
    return _two_colours(np.broadcast_to(along, (height_px, width_px)), BLACK, WHITE)


def crosshair(
    width_px: int,
    height_px: int,
    at_px: tuple[int, int],
    *,
    arm_px: int | None = None,
    thickness_px: int = 1,
    colour: Colour = WHITE,
    background: Colour = BLACK,
) -> Pixels:
    """Return a cross whose middle is the pixel `at_px` (column, row).

    Args:
        width_px: Width of the picture.
        height_px: Height of the picture.
        at_px: Column and row of the middle.
        arm_px: Pixels from the middle to an end; to the border unless given.
        thickness_px: Thickness of the lines; odd, so that they have a middle.
        colour: Colour of the cross.
        background: Colour of the rest.

    Raises:
        ValueError: The middle is outside, or the thickness is even.
    """
    column, row = at_px
    if not (0 <= column < width_px and 0 <= row < height_px):
        raise ValueError(f"pixel ({column}, {row}) is outside of {width_px} x {height_px}")
    if thickness_px < 1 or thickness_px % 2 == 0:
        raise ValueError(f"a line of {thickness_px} pixels has no middle pixel; take an odd number")
    half = thickness_px // 2
    reach = max(width_px, height_px) if arm_px is None else arm_px
    pixels = solid(width_px, height_px, background)
    near_row, near_column = slice(max(0, row - half), row + half + 1), _around(column, reach)
    pixels[near_row, near_column] = colour
    pixels[_around(row, reach), max(0, column - half) : column + half + 1] = colour
    return pixels


def _around(place: int, reach: int) -> slice:
    return slice(max(0, place - reach), place + reach + 1)


def _two_colours(is_light: NDArray[np.bool_], dark: Colour, light: Colour) -> Pixels:
    table = np.array([dark, light], np.uint8)
    return table[is_light.astype(np.uint8)]
