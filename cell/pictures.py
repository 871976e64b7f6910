"""The five pictures the television shows under the playground.

All are made here, from seeds, at the panel's 1920 x 1080 pixels: `black`, `white`,
`mash`, `water` and `forest`.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import CellError

WIDTH_PX = 1920
HEIGHT_PX = 1080

Picture = NDArray[np.uint8]
"""Shape (1080, 1920, 3), uint8, R G B, read-only."""

PICTURE_NAMES = ("black", "white", "mash", "water", "forest")

_TOY_COLOURS = ((214, 58, 48), (52, 152, 76), (38, 92, 178), (240, 188, 40), (206, 176, 138))


class UnknownPicture(CellError):
    """There is no picture of that name."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(f"there is no picture {name!r}; there are {', '.join(PICTURE_NAMES)}")


@lru_cache(maxsize=len(PICTURE_NAMES))
def picture(name: str) -> Picture:
    """Return a picture by name.

    Raises:
        UnknownPicture: There is none of that name.
    """
    if name not in PICTURE_NAMES:
        raise UnknownPicture(name)
    if name == "black":
        pixels = np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.uint8)
    elif name == "white":
        pixels = np.full((HEIGHT_PX, WIDTH_PX, 3), 255, np.uint8)
    elif name == "mash":
        pixels = _mash()
    elif name == "water":
        pixels = _water()
    else:
        pixels = _forest()
    pixels.setflags(write=False)
    return pixels


def _gradient(top: tuple[int, int, int], bottom: tuple[int, int, int]) -> NDArray[np.float32]:
    """Return a picture that goes from one colour at the top to another at the bottom."""
    share = np.linspace(0.0, 1.0, HEIGHT_PX, dtype=np.float32)[:, None, None]
    upper, lower = np.array(top, np.float32), np.array(bottom, np.float32)
    return np.repeat(upper * (1 - share) + lower * share, WIDTH_PX, axis=1)


def _bytes(pixels: NDArray[np.floating]) -> Picture:
    return np.asarray(np.clip(np.rint(pixels), 0, 255), np.uint8)


def _waves(seed: int, octaves: int, cells: int) -> NDArray[np.float32]:
    """Return smooth noise in 0..1: octaves of random grids, each interpolated."""
    generator = np.random.default_rng(seed)
    total = np.zeros((HEIGHT_PX, WIDTH_PX), np.float32)
    weight = 1.0
    for octave in range(octaves):
        columns = cells * 2**octave
        grid = generator.random((columns * 9 // 16 + 2, columns + 2), dtype=np.float32)
        grown = cv2.resize(grid, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_CUBIC)
        total += weight * grown
        weight *= 0.5
    total -= total.min()
    return np.asarray(total / total.max(), np.float32)


# --- mash: the cell's name in toy blocks ---------------------------------------------------

_LETTERS = {
    "M": ("X...X", "XX.XX", "X.X.X", "X...X", "X...X"),
    "A": (".XXX.", "X...X", "XXXXX", "X...X", "X...X"),
    "S": (".XXXX", "X....", ".XXX.", "....X", "XXXX."),
    "H": ("X...X", "X...X", "XXXXX", "X...X", "X...X"),
}


def _mash() -> Picture:
    """Draw the word MASH laid out in coloured toy blocks on a pale lattice."""
    pixels = _bytes(_gradient((176, 184, 194), (142, 158, 174)))
    step = 76
    for x in range(0, WIDTH_PX + 1, step):
        cv2.line(pixels, (x, 0), (x, HEIGHT_PX), (128, 146, 164), 2)
    for y in range(-12, HEIGHT_PX + 1, step):
        cv2.line(pixels, (0, y), (WIDTH_PX, y), (128, 146, 164), 2)
    generator = np.random.default_rng(11)
    left, top = step, step * 5 - 12
    for place, letter in enumerate("MASH"):
        colour = _TOY_COLOURS[place]
        for row, cells in enumerate(_LETTERS[letter]):
            for column, cell in enumerate(cells):
                if cell == "X":
                    x, y = left + (place * 6 + column) * step, top + row * step
                    _toy_block(pixels, x, y, step, colour, generator)
    return pixels


def _toy_block(
    pixels: Picture,
    x: int,
    y: int,
    side: int,
    colour: tuple[int, int, int],
    generator: np.random.Generator,
) -> None:
    """Draw a toy block seen from above, with a lit and a shaded edge."""
    tint = generator.uniform(0.93, 1.07)
    face = [min(255.0, c * tint) for c in colour]
    light = [c + (255 - c) * 0.45 for c in face]
    dark = [c * 0.6 for c in face]
    inner, bevel = 4, 11
    lower = (x + side - inner, y + side - inner)
    cv2.rectangle(pixels, (x + inner, y + inner), lower, dark, -1, cv2.LINE_AA)
    corner = np.array(
        [[x + inner, y + inner], [x + side - inner, y + inner], [x + inner, y + side - inner]]
    )
    cv2.fillConvexPoly(pixels, corner, light, cv2.LINE_AA)
    near = (x + inner + bevel, y + inner + bevel)
    cv2.rectangle(pixels, near, (lower[0] - bevel, lower[1] - bevel), face, -1, cv2.LINE_AA)


# --- water: sunlight on the floor of a pool -------------------------------------------------


def _water() -> Picture:
    """Draw the net of light that waves throw on the floor of a pool.

    The surface is a sum of waves; light is brightest where neighbouring rays meet,
    that is, where the surface's curvature focuses them on the floor.
    """
    generator = np.random.default_rng(7)
    height, width = HEIGHT_PX // 2, WIDTH_PX // 2
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) / np.float32(height)
    shift_x, shift_y = np.zeros_like(x), np.zeros_like(y)
    for _ in range(34):
        length = generator.uniform(0.09, 0.42)
        angle, phase = generator.uniform(0, 2 * np.pi, 2)
        cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
        slope = np.cos((x * cos + y * sin) * np.float32(2 * np.pi / length) + np.float32(phase))
        reach = np.float32(0.0062 * np.sqrt(length / 0.2))
        shift_x += reach * cos * slope
        shift_y += reach * sin * slope
    dx_dx, dx_dy = np.gradient(shift_x * height, axis=1), np.gradient(shift_x * height, axis=0)
    dy_dx, dy_dy = np.gradient(shift_y * height, axis=1), np.gradient(shift_y * height, axis=0)
    spread_of_rays = np.abs((1 + dx_dx) * (1 + dy_dy) - dx_dy * dy_dx)
    light = np.clip(0.36 / (spread_of_rays + 0.16), 0.0, 2.2).astype(np.float32)
    light = cv2.resize(light, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_CUBIC)
    light = np.asarray(cv2.GaussianBlur(light, (0, 0), 1.6))
    depth = _waves(8, 3, 4)[..., None]
    deep = np.array([6, 78, 132], np.float32)
    shallow = np.array([30, 150, 190], np.float32)
    floor = deep * (1 - depth) + shallow * depth
    return _bytes(floor * (0.55 + 0.42 * light[..., None]) + 22 * (light[..., None] ** 2))


# --- forest: conifers in the mist -----------------------------------------------------------


def _forest() -> Picture:
    """Draw rows of conifers, the farther the paler, under a morning sky."""
    pixels = _gradient((186, 168, 146), (134, 158, 152))
    across = np.exp(-(((np.arange(WIDTH_PX, dtype=np.float32) - 1330) / 330) ** 2))
    down = np.exp(-(((np.arange(HEIGHT_PX, dtype=np.float32) - 250) / 330) ** 2))
    pixels += np.outer(down, across)[..., None] * np.array([62, 53, 37], np.float32)
    height = np.linspace(0, 1, HEIGHT_PX)
    haze = np.array([160, 172, 160], np.float32)
    generator = np.random.default_rng(21)
    rows = 6
    for row in range(rows):
        nearness = row / (rows - 1)
        far, near = np.array([140, 162, 158], np.float32), np.array([16, 52, 34], np.float32)
        mist = far + np.float32(nearness) * (near - far)
        cover = _row_of_trees(generator, nearness)[..., None]
        lift = np.clip((height - 0.35 - 0.1 * row) * 0.8, 0, 0.5) * (1 - nearness)
        colour = mist + lift[:, None, None].astype(np.float32) * (haze - mist)
        pixels += cover * (colour - pixels)
    pixels *= (0.96 + 0.08 * _waves(22, 4, 24))[..., None]
    return _bytes(pixels)


def _row_of_trees(generator: np.random.Generator, nearness: float) -> NDArray[np.float32]:
    """Return how much of each pixel a row of trees covers, 0..1."""
    mask = np.zeros((HEIGHT_PX, WIDTH_PX), np.uint8)
    ground = 430 + 520 * nearness
    size = 170 + 560 * nearness**1.3
    x = -size * 0.2
    ridge_phase = generator.uniform(0, 6.28)
    hill = [
        (column, ground + 40 * np.sin(column / 310 + ridge_phase) + 18 * np.sin(column / 97))
        for column in range(-40, WIDTH_PX + 80, 40)
    ]
    outline = [(-50, HEIGHT_PX + 50), *hill, (WIDTH_PX + 90, HEIGHT_PX + 50)]
    cv2.fillPoly(mask, [np.array(outline, np.int32)], 255, cv2.LINE_AA)
    while x < WIDTH_PX + size * 0.3:
        foot = ground + 40 * np.sin(x / 310 + ridge_phase) + 18 * np.sin(x / 97) + 12
        tall = size * generator.uniform(0.6, 1.1)
        _conifer(mask, generator, x, foot, tall)
        x += size * generator.uniform(0.13, 0.36)
    return np.asarray(mask, np.float32) / np.float32(255)


def _conifer(
    mask: NDArray[np.uint8], generator: np.random.Generator, x: float, foot: float, tall: float
) -> None:
    """Draw the silhouette of one conifer: a trunk and tiers of drooping branches."""
    tiers = int(9 + tall / 40)
    half = tall * 0.19
    left: list[tuple[float, float]] = [(x, foot - tall)]
    right: list[tuple[float, float]] = [(x, foot - tall)]
    for tier in range(1, tiers + 1):
        share = tier / tiers
        y = foot - tall + share * tall * 0.94
        for side, points in ((-1, left), (1, right)):
            reach = half * share**0.85 * generator.uniform(0.78, 1.12)
            points.append((x + side * reach, y + tall * 0.02))
            points.append((x + side * reach * 0.45, y - tall * 0.004))
    outline = np.array(left + right[::-1])
    cv2.fillPoly(mask, [(outline * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
    trunk = max(1.0, tall * 0.012)
    box = np.array([[x - trunk, foot - tall / 2], [x + trunk, foot - tall / 2],
                    [x + trunk, foot + 40], [x - trunk, foot + 40]])  # fmt: skip
    cv2.fillPoly(mask, [(box * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
