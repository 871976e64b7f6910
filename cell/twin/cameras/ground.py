"""Everything that lies flat: table, screen with its bezel, and the store's sheet.

`Ground` answers for any set of points of the table's plane how much light they
reflect and where on the screen's panel they lie; the backdrops ask it for the points
that their pixels see.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.profile import BlockProfile, DisplayProfile, StoreProfile
from cell.sheet import SheetLayout, draw_sheet, lay_out, raster
from cell.store import StoreSlot
from cell.twin.cameras.light import WHITE_LEVEL, lamp_share, panel_axes

PAINT: dict[str, tuple[float, float, float]] = {
    "blue": (37 / WHITE_LEVEL, 57 / WHITE_LEVEL, 110 / WHITE_LEVEL),
    "natural": (168 / WHITE_LEVEL, 148 / WHITE_LEVEL, 121 / WHITE_LEVEL),
    "yellow": (203 / WHITE_LEVEL, 176 / WHITE_LEVEL, 60 / WHITE_LEVEL),
    "green": (88 / WHITE_LEVEL, 135 / WHITE_LEVEL, 60 / WHITE_LEVEL),
    "red": (188 / WHITE_LEVEL, 60 / WHITE_LEVEL, 47 / WHITE_LEVEL),
}
"""Reflectance R G B of the blocks' paints: the middle of each range of the recognition
table (Dubec 2011, 5.6) under the cell's lamps."""

_BEZEL_MM = 16.0
_SHEET_PX_MM = 0.5
_PAPER_REFLECTANCE = 0.88
_TABLE = np.array([0.64, 0.63, 0.60], np.float32)
_BEZEL = np.array([0.045, 0.045, 0.05], np.float32)
_GLASS = np.array([0.058, 0.062, 0.07], np.float32)
_FLOOR = np.array([0.30, 0.31, 0.33], np.float32)
_TABLE_HALF_MM = 1500.0
_GRAIN_PX = 512
_GRAIN_PX_MM = 1.5
_TILE_MM = 500.0

Plane = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Ground:
    """What lies flat on the table.

    Attributes:
        display: Where the panel lies.
        store: Where the store's sheet lies.
        surface_mm: Height of glass and sheet.
        slots: The places printed on the sheet.
        blocks: Sizes of the kinds of blocks, for the printed outlines.
    """

    display: DisplayProfile
    store: StoreProfile
    surface_mm: float
    slots: tuple[StoreSlot, ...]
    blocks: tuple[tuple[str, BlockProfile], ...]

    def lamplight(self, x_mm: Plane, y_mm: Plane, px_mm: Plane | float) -> Plane:
        """Return light (h, w, 3) that points of the plane reflect under the lamps.

        Args:
            x_mm: Robot x of each point, (h, w).
            y_mm: Robot y of each point, (h, w).
            px_mm: How much of the plane one pixel covers; softens edges.
        """
        light = _table_top(x_mm, y_mm)
        along, below = self.panel_mm(x_mm, y_mm)
        wide, tall = self.panel_size_mm()
        frame = _inside(along, below, wide, tall, px_mm, _BEZEL_MM)
        _mix(light, frame, _BEZEL)
        glass = _inside(along, below, wide, tall, px_mm, 0.0)
        _mix(light, glass, _GLASS)
        self._lay_sheet(light, x_mm, y_mm, px_mm)
        light *= (WHITE_LEVEL * lamp_share(x_mm, y_mm))[..., None]
        return light

    def panel_mm(self, x_mm: Plane, y_mm: Plane) -> tuple[Plane, Plane]:
        """Return millimetres to the right and down from the picture's upper left corner."""
        right, down = panel_axes(self.display)
        dx, dy = x_mm - self.display.corner_x_mm, y_mm - self.display.corner_y_mm
        return (
            (dx * right[0] + dy * right[1]).astype(np.float32),
            (dx * down[0] + dy * down[1]).astype(np.float32),
        )

    def panel_size_mm(self) -> tuple[float, float]:
        """Return width and height of the panel."""
        display = self.display
        return display.width_px * display.pixel_mm, display.height_px * display.pixel_mm

    def corners_mm(self) -> NDArray[np.float64]:
        """Return robot x, y (8, 2) of the corners of panel and sheet."""
        right, down = panel_axes(self.display)
        corner = np.array([self.display.corner_x_mm, self.display.corner_y_mm])
        wide, tall = self.panel_size_mm()
        panel = [corner + right * (wide * i) + down * (tall * j) for i in (0, 1) for j in (0, 1)]
        angle = math.radians(self.store.angle_deg)
        along = np.array([math.cos(angle), math.sin(angle)])
        across = np.array([along[1], -along[0]])
        wide, tall = self.sheet_size_mm()
        sheet = [
            np.array(self.store.corner_mm) + along * (wide * i) + across * (tall * j)
            for i in (0, 1)
            for j in (0, 1)
        ]
        return np.array(panel + sheet)

    def sheet_size_mm(self) -> tuple[float, float]:
        """Return width and height of the store's sheet."""
        layout = _layout(self.slots, self.blocks)
        return float(layout.width_mm), float(layout.height_mm)

    def panel_cover(self, x_mm: Plane, y_mm: Plane, px_mm: Plane | float) -> Plane:
        """Return how much of each point's pixel the panel covers, 0..1."""
        along, below = self.panel_mm(x_mm, y_mm)
        return _inside(along, below, *self.panel_size_mm(), px_mm, 0.0)

    def _sheet_mm(self, x_mm: Plane, y_mm: Plane) -> tuple[Plane, Plane]:
        angle = math.radians(self.store.angle_deg)
        cos, sin = np.float32(math.cos(angle)), np.float32(math.sin(angle))
        dx = x_mm - np.float32(self.store.corner_mm[0])
        dy = y_mm - np.float32(self.store.corner_mm[1])
        return cos * dx + sin * dy, sin * dx - cos * dy

    def _lay_sheet(self, light: Plane, x_mm: Plane, y_mm: Plane, px_mm: Plane | float) -> None:
        along, below = self._sheet_mm(x_mm, y_mm)
        cover = _inside(along, below, *self.sheet_size_mm(), px_mm, 0.0)
        if not cover.any():
            return
        sheet = _softened(store_sheet(self.slots, self.blocks), cover, px_mm)
        seen = cv2.remap(
            sheet,
            np.asarray(along / _SHEET_PX_MM - 0.5, np.float32),
            np.asarray(below / _SHEET_PX_MM - 0.5, np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        paper = np.asarray(seen, np.float32) * np.float32(_PAPER_REFLECTANCE / 255.0)
        light += cover[..., None] * (paper - light)


def floor_light(x_mm: Plane, y_mm: Plane) -> Plane:
    """Return light (h, w, 3) of the tiled floor around the table."""
    gap = np.minimum(np.abs(x_mm % _TILE_MM - 8.0), np.abs(y_mm % _TILE_MM - 8.0)) < 8.0
    tile = ((x_mm // _TILE_MM + y_mm // _TILE_MM) % 2) * 0.04 + 0.96
    dim = tile * np.where(gap, 0.8, 1.0) * 0.55
    return np.asarray(dim[..., None] * _FLOOR * WHITE_LEVEL, np.float32)


def is_on_table(x_mm: Plane, y_mm: Plane) -> NDArray[np.bool_]:
    """Return which points of the plane the table's top has."""
    return (np.abs(x_mm) <= _TABLE_HALF_MM) & (np.abs(y_mm) <= _TABLE_HALF_MM)


def _inside(
    along: Plane, below: Plane, wide: float, tall: float, px_mm: Plane | float, grow: float
) -> Plane:
    """Return how much of each pixel lies inside a rectangle, its edge one pixel wide."""
    inner = np.minimum(
        np.minimum(along + grow, wide + grow - along), np.minimum(below + grow, tall + grow - below)
    )
    return np.asarray(np.clip(inner / px_mm + 0.5, 0.0, 1.0), np.float32)


def _softened(sheet: NDArray[np.uint8], cover: Plane, px_mm: Plane | float) -> NDArray[np.uint8]:
    """Return the sheet as pixels see it that cover more of it than one of its own."""
    there = cover > 0
    typical = float(np.median(px_mm[there])) if isinstance(px_mm, np.ndarray) else px_mm
    sigma = 0.35 * typical / _SHEET_PX_MM
    if sigma < 0.4:
        return sheet
    return np.asarray(cv2.GaussianBlur(sheet, (0, 0), sigma), np.uint8)


def _mix(light: Plane, cover: Plane, colour: NDArray[np.float32]) -> None:
    light += cover[..., None] * (colour - light)


def _table_top(x_mm: Plane, y_mm: Plane) -> Plane:
    grain = cv2.remap(
        _grain(),
        np.asarray(x_mm / np.float32(_GRAIN_PX_MM), np.float32),
        np.asarray(y_mm / np.float32(_GRAIN_PX_MM), np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_WRAP,
    )
    return np.asarray(grain, np.float32)[..., None] * _TABLE


@lru_cache(maxsize=1)
def _grain() -> Plane:
    """Return the speckle of the laminate, a tile that wraps around."""
    generator = np.random.default_rng(5)
    speckle = generator.standard_normal((_GRAIN_PX, _GRAIN_PX)).astype(np.float32)
    wrapped = np.pad(speckle, 32, mode="wrap")
    fine = cv2.GaussianBlur(wrapped, (0, 0), 0.9)[32:-32, 32:-32]
    coarse = cv2.GaussianBlur(wrapped, (0, 0), 7.0)[32:-32, 32:-32]
    grain = 1.0 + 0.022 * fine / fine.std() + 0.006 * coarse / coarse.std()
    return np.asarray(grain, np.float32)


@lru_cache(maxsize=4)
def _layout(
    slots: tuple[StoreSlot, ...], blocks: tuple[tuple[str, BlockProfile], ...]
) -> SheetLayout:
    return lay_out(slots, dict(blocks))


@lru_cache(maxsize=4)
def store_sheet(
    slots: tuple[StoreSlot, ...], blocks: tuple[tuple[str, BlockProfile], ...]
) -> NDArray[np.uint8]:
    """Return the printed plan of the store, (h, w, 3), two pixels a millimetre."""
    sheet = raster(draw_sheet(_layout(slots, blocks)), 1.0 / _SHEET_PX_MM)
    sheet.setflags(write=False)
    return sheet
