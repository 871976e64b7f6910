"""Finds blocks on the lit screen in two pictures of the top camera.

The white-minus-black method of Dubec 2011, section 5.6: with the arm out of view and
the lights on, the picture on a black screen is subtracted from the one on a white
screen. Lit screen stays bright, what stands on it dark. Each dark region enclosed by
lit screen is measured; area and circularity tell its kind, its mean colour in the black
picture tells its colour.

A region outside the tables is reported without kind or colour: half a block, two blocks
that touch, or a hand are not guessed at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError
from cell.geometry import PlaneMap
from cell.store import TablePlace
from cell.vision.difference import screen_light
from cell.vision.regions import Region, dark_regions
from cell.vision.settings import RecognitionSettings
from cell.vision.shape import (
    centroid_px,
    circularity,
    major_axis_deg,
    outline_length_px,
    square_turn_deg,
)
from cell.vision.tables import colour_of, fold_deg, kind_of, symmetry_deg

_YAW_ARM_PX = 20.0
"""Half the length of the line that carries a direction through the plane map."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenBlock:
    """A dark region on the lit screen.

    Attributes:
        kind: `cube`, `cylinder` or `bridge`; None when its shape is in no range.
        colour: Its paint; None when its channel means are in no range.
        u_px: Column of its centroid, pixel centres at whole numbers.
        v_px: Row of its centroid in the whole picture.
        yaw_px_deg: Angle from +u towards +v of its length, folded by the kind's symmetry:
            cubes -45 to 45, bridges and unknown kinds (major axis) -90 to 90, cylinders 0.
        area_px: Number of its pixels.
        circularity: 4πA/P², at most 1.
        mean_rgb: Means of the channels in the black picture, its edge left out.
    """

    kind: str | None
    colour: str | None
    u_px: float
    v_px: float
    yaw_px_deg: float
    area_px: int
    circularity: float
    mean_rgb: tuple[float, float, float]


_DEFAULT_SETTINGS = RecognitionSettings()


def find_blocks(
    white: NDArray[np.uint8],
    black: NDArray[np.uint8],
    settings: RecognitionSettings = _DEFAULT_SETTINGS,
) -> tuple[SeenBlock, ...]:
    """Return what stands on the screen, from the picture's top to its bottom.

    Args:
        white: Picture on a white screen, R G B, shape (960, 1280, 3), uint8; lights on,
            arm out of view.
        black: The same on a black screen, nothing moved in between.
        settings: How to look.

    Raises:
        VisionError: A picture has the wrong shape, or the screen or the lights are off.
    """
    light = screen_light(white, black, settings)
    cropped = black[settings.first_row : settings.end_row]
    seen = [_measure(region, cropped, settings) for region in dark_regions(light, settings)]
    shaped = [block for block in seen if block.kind is not None]
    if shaped and all(max(block.mean_rgb) < settings.least_lit_level for block in shaped):
        brightest = max(max(block.mean_rgb) for block in shaped)
        raise VisionError(
            f"the lights are off: {len(shaped)} block(s) stand on the screen, the brightest with "
            f"{brightest:.0f} grey levels of at least {settings.least_lit_level:.0f} that a "
            "lit block has; switch the lights on and take both pictures again"
        )
    return tuple(sorted(seen, key=lambda block: (block.v_px, block.u_px)))


def locate(seen: SeenBlock, plane_map: PlaneMap) -> TablePlace:
    """Return where a seen block lies in the robot frame.

    The yaw is the direction of the block's length, carried through the plane map and
    folded by the kind's symmetry: cubes -45 to 45 deg, bridges -90 to 90, cylinders 0.

    Args:
        seen: The block.
        plane_map: Picture to robot on the plane of the block tops.
    """
    x_mm, y_mm = plane_map.to_robot(seen.u_px, seen.v_px)
    angle = math.radians(seen.yaw_px_deg)
    du, dv = _YAW_ARM_PX * math.cos(angle), _YAW_ARM_PX * math.sin(angle)
    ahead = plane_map.to_robot(seen.u_px + du, seen.v_px + dv)
    behind = plane_map.to_robot(seen.u_px - du, seen.v_px - dv)
    yaw_deg = math.degrees(math.atan2(ahead[1] - behind[1], ahead[0] - behind[0]))
    return TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=fold_deg(yaw_deg, symmetry_deg(seen.kind)))


def _measure(region: Region, black: NDArray[np.uint8], settings: RecognitionSettings) -> SeenBlock:
    """Measure a region; `black` is cropped like the difference it was found in."""
    roundness = circularity(region.area_px, outline_length_px(region.levels, region.threshold))
    known = kind_of(region.area_px, roundness)
    mean_rgb = _mean_colour(region, black, settings.edge_px)
    column, row = centroid_px(region.mask)
    return SeenBlock(
        kind=None if known is None else known.kind,
        colour=colour_of(mean_rgb),
        u_px=region.column + column,
        v_px=settings.first_row + region.row + row,
        yaw_px_deg=_turn_deg(region, None if known is None else known.kind),
        area_px=region.area_px,
        circularity=roundness,
        mean_rgb=mean_rgb,
    )


def _turn_deg(region: Region, kind: str | None) -> float:
    symmetry = symmetry_deg(kind)
    if symmetry == 0.0:
        return 0.0
    turn = square_turn_deg(region.mask) if symmetry == 90.0 else major_axis_deg(region.mask)
    return fold_deg(turn, symmetry)


def _mean_colour(
    region: Region, black: NDArray[np.uint8], edge_px: int
) -> tuple[float, float, float]:
    """Return the channel means of a region less its edge; of all of it if it is only edge."""
    side = 2 * edge_px + 1
    inner = cv2.erode(region.mask, np.ones((side, side), np.uint8))
    rows, columns = region.mask.shape
    window = black[region.row : region.row + rows, region.column : region.column + columns]
    mask = inner if cv2.countNonZero(inner) else region.mask
    red, green, blue, _ = cv2.mean(window, mask)
    return red, green, blue
