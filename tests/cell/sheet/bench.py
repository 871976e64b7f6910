"""The plan of the mash cell, and pictures of its sheet by a camera whose place is known."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import CameraView, LensModel, Transform
from cell.profile import Profile, StoreProfile, load_profile
from cell.sheet import SheetLayout, draw_sheet, raster
from cell.store import StorePlan, StoreSlot, with_calibration_object

PROFILE: Profile = load_profile("mash")
SURFACE_MM = PROFILE.heights.surface_mm
LENS = LensModel(
    width_px=1280, height_px=960, focal_u_px=1250.0, focal_v_px=1250.0, centre_u_px=640.0,
    centre_v_px=480.0, k1=-0.1,
)  # fmt: skip
_PX_PER_MM = 4.0
_TABLE = 140.0
_ROWS = (
    "cube natural", "cube natural", "cube natural", "cube natural", "cube blue",
    "cube blue", "cube red", "cube red", "cube green", "cube green",
    "cube yellow", "cube yellow", "bridge red", "", "bridge green",
    "cylinder blue", "cylinder green", "cylinder yellow", "", "cylinder red",
)  # fmt: skip


def _slots() -> tuple[StoreSlot, ...]:
    """Return table D.1 of the reference."""
    found: list[StoreSlot] = []
    for place, what in enumerate(_ROWS):
        if what:
            kind, colour = what.split()
            x, y = 55.0 + 110.0 * (place % 5), 50.0 + 100.0 * (place // 5)
            number = len(found) + 1
            found.append(StoreSlot(number=number, kind=kind, colour=colour, x_mm=x, y_mm=y))
    return tuple(found)


MASH_SLOTS = with_calibration_object(StorePlan(_slots()), PROFILE.store).slots
"""With the slot of the calibration cylinder, as the cell has it."""


@lru_cache(maxsize=32)
def view_from(
    store: StoreProfile, *, height_mm: float, tilt_deg: float = 0.0, turn_deg: float = 0.0
) -> CameraView:
    """Return a camera over the middle of a mash sheet, tilted and turned about its view."""
    angle = math.radians(store.angle_deg)
    x = store.corner_mm[0] + 273 * math.cos(angle) + 184 * math.sin(angle)
    y = store.corner_mm[1] + 273 * math.sin(angle) - 184 * math.cos(angle)
    tilt, turn = math.radians(tilt_deg), math.radians(turn_deg)
    down = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    tilted = np.array(
        [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
    )
    turned = np.array(
        [[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = down @ tilted @ turned
    axis = matrix[:3, 2]
    matrix[:3, 3] = np.array([x, y, SURFACE_MM]) - axis * (height_mm / -axis[2])
    return CameraView(LENS, Transform(matrix))


@lru_cache(maxsize=2)
def _printed(layout: SheetLayout) -> NDArray[np.uint8]:
    """Return the sheet, a little out of focus."""
    sharp = raster(draw_sheet(layout), _PX_PER_MM)
    return np.asarray(cv2.GaussianBlur(sharp, (0, 0), 1.5), np.uint8)


@lru_cache(maxsize=2)
def _seen_points(view: CameraView) -> NDArray[np.float64]:
    """Return robot x, y (960, 1280, 2) of what every pixel sees at the sheet's height."""
    u, v = np.meshgrid(np.arange(1280.0), np.arange(960.0))
    return view.to_robot(np.stack([u, v], axis=-1), SURFACE_MM)


def picture_of_sheet(
    layout: SheetLayout,
    store: StoreProfile,
    view: CameraView,
    *,
    seed: int,
    scale: float = 1.0,
    noise: float = 2.0,
    mirrored: bool = False,
) -> NDArray[np.uint8]:
    """Return the picture of an empty sheet: exact optics, a little blur and noise.

    Args:
        layout: The sheet.
        store: Where it lies.
        view: The camera.
        seed: Of the noise.
        scale: Of the print.
        noise: Standard deviation in grey levels.
        mirrored: Whether it is printed mirrored.
    """
    printed = _printed(layout)
    if mirrored:
        printed = np.ascontiguousarray(printed[:, ::-1])
    points = _seen_points(view)
    angle = math.radians(store.angle_deg)
    dx, dy = points[..., 0] - store.corner_mm[0], points[..., 1] - store.corner_mm[1]
    along = (math.cos(angle) * dx + math.sin(angle) * dy) / scale
    below = (math.sin(angle) * dx - math.cos(angle) * dy) / scale
    light = cv2.remap(
        printed.astype(np.float32) * 0.8,
        np.asarray(along * _PX_PER_MM - 0.5, np.float32),
        np.asarray(below * _PX_PER_MM - 0.5, np.float32),
        cv2.INTER_LINEAR,
        borderValue=(_TABLE, _TABLE, _TABLE),
    )
    shift = np.random.default_rng([seed, 0x5EE7]).integers(0, 900, 2)
    grain = np.roll(_grain(), tuple(int(one) for one in shift), axis=(0, 1))
    return np.asarray(np.clip(np.rint(light + noise * grain), 0, 255), np.uint8)


@lru_cache(maxsize=1)
def _grain() -> NDArray[np.float32]:
    """Return noise (960, 1280, 3) of standard deviation 1, which each picture shifts."""
    return np.random.default_rng(17).standard_normal((960, 1280, 3), np.float32)
