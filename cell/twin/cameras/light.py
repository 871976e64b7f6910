"""Light of the cell: what lamps, screen and paint send towards a camera.

Light is counted in nominal levels (see `sensor`). A matt face of reflectance 1 that
looks straight up under the lamps gives `WHITE_LEVEL`; the screen's white is twice
that, so it clips in every camera at its default settings, as a television does beside
paper. Faces beside a lit screen catch half of its light; seen at a flat angle, they
also mirror it (Schlick's approximation of Fresnel).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.pictures import picture
from cell.profile import DisplayProfile, TwinLightProfile

WHITE_LEVEL = 250.0
SCREEN_WHITE_LEVEL = 540.0
"""A panel of 350 cd/m² beside white paper under 510 lx (162 cd/m²)."""

SCREEN_LEAK_LEVEL = 5.0
"""What shows of the backlight where the picture is black."""

SCREEN_GAMMA = 2.2
UNLIT_SHARE = 0.012
"""What is left of the light with the lamps off: daylight through the blinds."""

_LAMP = np.array([0.26, -0.34, 0.90])
_SKY, _DIRECT = 0.52, 0.48
_DIM_MM = 2600.0
_BRIGHTEST_MM = (520.0, -60.0)
_MIRROR = 0.04
_GLOW_CELL_MM = 30.0
_GLOW_BLUR_MM = 45.0
_GLOW_STRIDE = 5


Lamps = tuple[float, float, float]
"""What the lamps give in R G B, 1 for the nominal light."""


@dataclass(frozen=True, slots=True)
class PanelPicture:
    """What the panel shows.

    Attributes:
        name: Tells two pictures apart: a name of `cell.pictures`, or one made of the content.
        pixels: The picture (1080, 1920, 3), None for one that `cell.pictures` has by name.
    """

    name: str
    pixels: NDArray[np.uint8] | None = field(default=None, compare=False)

    def read(self) -> NDArray[np.uint8]:
        """Return the picture, (1080, 1920, 3), uint8, R G B."""
        return picture(self.name) if self.pixels is None else self.pixels


@dataclass(frozen=True, slots=True, eq=False)
class ScreenGlow:
    """The screen's light, averaged over a hand's breadth around each place.

    Attributes:
        grid: Mean light R G B on a coarse grid over the panel, nominal levels.
        display: Where the panel lies.
    """

    grid: NDArray[np.float32]
    display: DisplayProfile

    def around(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the light (n, 3) of the screen around robot points (n, 3).

        It falls off beyond the panel's edge within a block's height and with height.
        """
        right, down = panel_axes(self.display)
        offset = points_mm[:, :2] - (self.display.corner_x_mm, self.display.corner_y_mm)
        along, below = offset @ right, offset @ down
        rows, columns = self.grid.shape[:2]
        wide = self.display.width_px * self.display.pixel_mm
        tall = self.display.height_px * self.display.pixel_mm
        outside = np.hypot(
            np.maximum(np.maximum(-along, along - wide), 0.0),
            np.maximum(np.maximum(-below, below - tall), 0.0),
        )
        column = np.clip((along / wide * columns).astype(int), 0, columns - 1)
        row = np.clip((below / tall * rows).astype(int), 0, rows - 1)
        share = np.exp(-outside / 40.0)
        return np.asarray(self.grid[row, column] * share[:, None], np.float64)


def panel_axes(display: DisplayProfile) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the unit vectors of the picture's right and down in robot x, y, seen from above."""
    angle = math.radians(display.angle_deg)
    right = np.array([math.cos(angle), math.sin(angle)])
    return right, np.array([right[1], -right[0]])


def lamps(light: TwinLightProfile, *, are_lights_on: bool) -> Lamps:
    """Return what the lamps, or the daylight that is left without them, give."""
    share = light.level * (1.0 if are_lights_on else UNLIT_SHARE)
    return share * light.red, share, share * light.blue


def flicker_share(
    light: TwinLightProfile, *, shutter_ms: float, number: int, rate_hz: float
) -> float:
    """Return what one frame gets of the lamps' mean light while they swing with the mains.

    The light swings twice a period; what is left of the swing in a frame is its mean over
    the shutter time, which is none for whole swings.

    Args:
        light: The lamps.
        shutter_ms: How long the frame is exposed.
        number: Number of the frame, from which its phase follows.
        rate_hz: Frames a second.
    """
    if light.flicker == 0.0:
        return 1.0
    swing_hz = 2.0 * light.mains_hz
    swings = swing_hz * shutter_ms / 1000.0
    phase = 2.0 * math.pi * (number * swing_hz / rate_hz % 1.0)
    return 1.0 + light.flicker * float(np.sinc(swings)) * math.cos(phase)


def screen_light(panel: PanelPicture | None) -> NDArray[np.float32] | None:
    """Return the light (1080, 1920, 3) of a picture on the panel, None for a dark panel."""
    if panel is None:
        return None
    return np.asarray(screen_table()[panel.read()])


@lru_cache(maxsize=1)
def screen_table() -> NDArray[np.float32]:
    """Return the light (256,) of each value of the panel's pixels."""
    table = (np.arange(256) / 255.0) ** SCREEN_GAMMA * SCREEN_WHITE_LEVEL + SCREEN_LEAK_LEVEL
    return np.asarray(table, np.float32)


@lru_cache(maxsize=16)
def screen_glow(panel: PanelPicture | None, display: DisplayProfile) -> ScreenGlow:
    """Return the glow of a picture, worked out once."""
    columns = round(display.width_px * display.pixel_mm / _GLOW_CELL_MM)
    rows = round(display.height_px * display.pixel_mm / _GLOW_CELL_MM)
    if panel is None:
        return ScreenGlow(np.zeros((rows, columns, 3), np.float32), display)
    grid = cv2.resize(_glowing(panel), (columns, rows), interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(
        grid, (0, 0), _GLOW_BLUR_MM / _GLOW_CELL_MM, borderType=cv2.BORDER_REPLICATE
    )
    return ScreenGlow(np.asarray(blurred, np.float32), display)


def _glowing(panel: PanelPicture) -> NDArray[np.float32]:
    """Return the light of a picture as the glow needs it: of a pattern, every fifth pixel."""
    if panel.pixels is None:
        return np.asarray(screen_table()[panel.read()])
    part = panel.pixels[_GLOW_STRIDE // 2 :: _GLOW_STRIDE, _GLOW_STRIDE // 2 :: _GLOW_STRIDE]
    return np.asarray(screen_table()[part])


def lamp_share(x_mm: NDArray[np.floating], y_mm: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return how much lamplight reaches a place, 1 where it is brightest."""
    dx, dy = x_mm - _BRIGHTEST_MM[0], y_mm - _BRIGHTEST_MM[1]
    return 1.0 / (1.0 + (dx * dx + dy * dy) / (_DIM_MM * _DIM_MM))


def shade(
    reflectance: NDArray[np.float64],
    gloss: NDArray[np.float64],
    normals: NDArray[np.float64],
    centres_mm: NDArray[np.float64],
    to_camera: NDArray[np.float64],
    glow: ScreenGlow,
    *,
    lamplight: Lamps,
) -> NDArray[np.float64]:
    """Return the light (n, 3) that faces send to the camera, nominal levels.

    Args:
        reflectance: R G B of each face, (n, 3).
        gloss: Share of the mirror's law that a face obeys, (n,).
        normals: Outward unit normals, (n, 3), robot frame.
        centres_mm: Centres of the faces, (n, 3), robot frame.
        to_camera: Unit vectors to the camera, (n, 3).
        glow: The screen's light.
        lamplight: What the lamps give.
    """
    lit = _SKY * (0.56 + 0.44 * normals[:, 2])
    lit += _DIRECT / _LAMP[2] * np.maximum(normals @ _LAMP, 0.0)
    lit *= lamp_share(centres_mm[:, 0], centres_mm[:, 1]) * WHITE_LEVEL
    screen = glow.around(centres_mm)
    seen = 0.5 * (1.0 - normals[:, 2])
    height = np.maximum(centres_mm[:, 2] - 55.0, 0.0)
    reach = np.exp(-height / 260.0)
    matt = reflectance * (lit[:, None] * np.array(lamplight) + screen * (seen * reach)[:, None])
    cosine = np.clip(np.einsum("ij,ij->i", normals, to_camera), 0.0, 1.0)
    mirror = gloss * (_MIRROR + (1.0 - _MIRROR) * (1.0 - cosine) ** 5)
    downward = 2.0 * cosine * normals[:, 2] - to_camera[:, 2] < 0.0
    return np.asarray(matt + screen * (mirror * reach * downward)[:, None])
