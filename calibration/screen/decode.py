"""From pictures of phase and Gray code to what place of the screen each camera pixel sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.screen.patterns import PERIOD_PX, STEPS

Grey = NDArray[np.float32]
Mask = NDArray[np.bool_]
Points = NDArray[np.float64]

CLIPPED_LEVEL = 250
"""From here on a picture's level may be cut off."""

_LEAST_SWING = 6.0
_LEAST_SWING_SHARE = 0.15
_MOST_DISAGREEMENT = 0.36
_CELL_PX = 16
_FEW_CELLS = 1500
_LEAST_FILLED = 0.75
_OUTLIER_PX = 0.35
_ROUNDS = 2


@dataclass(frozen=True, slots=True, eq=False)
class AxisReading:
    """Places along one axis of the screen.

    Attributes:
        place: Column or row of the screen that each pixel sees, (h, w); pixel centres are
            whole numbers.
        swing: Half of the difference of brightest and darkest, grey levels, (h, w).
        is_sure: Where the place can be relied on, (h, w).
    """

    place: Grey
    swing: Grey
    is_sure: Mask


@dataclass(frozen=True, slots=True, eq=False)
class ScreenMap:
    """What place of the screen each pixel of a camera sees.

    Attributes:
        place: Column and row of the screen, (h, w, 2).
        swing: The smaller of both axes' swings, (h, w).
        is_sure: Where both axes can be relied on, (h, w).
    """

    place: NDArray[np.float32]
    swing: Grey
    is_sure: Mask


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Correspondences:
    """Where in the picture which places of the screen appear.

    Attributes:
        pixels: Camera u, v, (n, 2).
        places: Columns and rows of the screen, (n, 2).
    """

    pixels: Points
    places: Points

    def __len__(self) -> int:
        return len(self.pixels)

    def part(self, chosen: NDArray[np.bool_]) -> Correspondences:
        """Return some of them."""
        return Correspondences(pixels=self.pixels[chosen], places=self.places[chosen])


def grey_of(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the grey (h, w) of a picture (h, w, 3)."""
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)


def read_axis(
    sines: Sequence[NDArray[np.uint8]], codes: Sequence[NDArray[np.uint8]]
) -> AxisReading:
    """Return the places along one axis.

    Args:
        sines: `STEPS` pictures (h, w, 3) of the shifted sine.
        codes: Pictures of the Gray code's bits, from bit 0, the finest, on.
    """
    shape = sines[0].shape[:2]
    across, along, total = (np.zeros(shape, np.float32) for _ in range(3))
    is_cut = np.zeros(shape, np.bool_)
    for step, picture in enumerate(sines):
        angle = 2.0 * np.pi * step / STEPS
        level = grey_of(picture).astype(np.float32)
        along += level * np.float32(np.cos(angle))
        across += level * np.float32(np.sin(angle))
        total += level
        red, green, blue = cv2.split(picture)
        is_cut |= cv2.max(cv2.max(red, green), blue) >= CLIPPED_LEVEL
    middle = np.asarray(total / np.float32(STEPS), np.float32)
    swing = np.asarray(np.hypot(along, across) * np.float32(2.0 / STEPS), np.float32)
    phase = np.asarray(np.arctan2(across, along) / np.float32(2.0 * np.pi), np.float32)
    halves = _half_periods(codes, middle)
    periods = (halves + np.float32(0.5)) / 2 - phase
    whole = np.rint(periods)
    lit = swing[swing > _LEAST_SWING]
    floor = max(_LEAST_SWING, _LEAST_SWING_SHARE * float(np.median(lit)) if lit.size else 0.0)
    is_sure = (swing > floor) & (np.abs(periods - whole) < _MOST_DISAGREEMENT) & ~is_cut
    place = (whole + phase) * np.float32(PERIOD_PX)
    return AxisReading(np.asarray(place, np.float32), swing, np.asarray(is_sure, np.bool_))


def _half_periods(codes: Sequence[NDArray[np.uint8]], middle: Grey) -> Grey:
    """Return the half period that each pixel's code names.

    Where a stripe's edge blurs a bit, the other code belongs to the neighbour; which of the
    two it is, the phase tells.
    """
    gray = np.zeros(middle.shape, np.int32)
    for bit, picture in enumerate(codes):
        gray |= (grey_of(picture) > middle).astype(np.int32) << bit
    shift = 1
    while shift < 32:
        gray ^= gray >> shift
        shift *= 2
    return gray.astype(np.float32)


def both_axes(columns: AxisReading, rows: AxisReading, width_px: int, height_px: int) -> ScreenMap:
    """Return the map of both axes; places off the panel are not relied on."""
    on_panel = (
        (columns.place > -0.5) & (columns.place < width_px - 0.5)
        & (rows.place > -0.5) & (rows.place < height_px - 0.5)
    )  # fmt: skip
    return ScreenMap(
        place=np.stack([columns.place, rows.place], axis=-1),
        swing=np.minimum(columns.swing, rows.swing),
        is_sure=columns.is_sure & rows.is_sure & on_panel,
    )


def correspondences(seen: ScreenMap) -> Correspondences:
    """Return one correspondence for each cell of the picture that sees the screen whole.

    Cells have 16 pixels a side, or 8 where the screen fills little of the picture.
    """
    coarse = _in_cells(seen, _CELL_PX)
    return coarse if len(coarse) >= _FEW_CELLS else _in_cells(seen, _CELL_PX // 2)


def _in_cells(seen: ScreenMap, cell_px: int) -> Correspondences:
    """Return a correspondence for each cell.

    In each cell a surface of second order is fitted to the places, without the pixels that
    stand out (edges of blocks, reflections); its value at the cell's middle counts.
    """
    height, width = seen.is_sure.shape
    down, across = height // cell_px, width // cell_px
    offset = np.arange(cell_px) - 0.5 * (cell_px - 1)
    v, u = (k.ravel() / cell_px for k in np.meshgrid(offset, offset, indexing="ij"))
    basis = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1)
    sure = _cells(seen.is_sure, down, across, cell_px)
    full = sure.mean(axis=1) >= _LEAST_FILLED
    places = np.stack(
        [_cells(seen.place[..., k], down, across, cell_px)[full] for k in (0, 1)], axis=-1
    ).astype(np.float64)
    weight = sure[full].astype(np.float64)
    centre, spread = _surfaces(basis, places, weight)
    for _ in range(_ROUNDS):
        far = (spread > _OUTLIER_PX) & (weight > 0.0)
        again = far.any(axis=1)
        if not again.any():
            break
        weight = np.where(far, 0.0, weight)
        centre[again], spread[again] = _surfaces(basis, places[again], weight[again])
    kept = weight.mean(axis=1) >= _LEAST_FILLED
    rows, columns = np.divmod(np.flatnonzero(full)[kept], across)
    pixels = np.stack([columns, rows], axis=1) * cell_px + 0.5 * (cell_px - 1)
    return Correspondences(pixels=pixels.astype(np.float64), places=centre[kept])


def _cells(values: NDArray[np.generic], down: int, across: int, side: int) -> NDArray[np.generic]:
    """Return (cells, pixels) of a picture cut into squares."""
    cut = values[: down * side, : across * side].reshape(down, side, across, side)
    return cut.transpose(0, 2, 1, 3).reshape(down * across, side * side)


def _surfaces(basis: Points, places: Points, weight: Points) -> tuple[Points, Points]:
    """Return the surfaces' values at the middle (m, 2) and each pixel's distance (m, p)."""
    count = basis.shape[1]
    products = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
    normal = (weight @ products).reshape(-1, count, count) + 1e-9 * np.eye(count)
    swapped = (places * weight[..., None]).transpose(0, 2, 1)
    right = (swapped @ basis).transpose(0, 2, 1)
    solved = np.linalg.solve(normal, right)
    surface = solved.transpose(0, 2, 1) @ basis.T
    apart = np.abs(places - surface.transpose(0, 2, 1))
    return np.asarray(solved[:, 0, :]), np.asarray(np.maximum(apart[..., 0], apart[..., 1]))
