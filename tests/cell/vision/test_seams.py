"""A bridge and a cube in one line: their seam tells the order, and without one nobody guesses."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.vision.recognition import OnePicture, recognise
from cell.vision.sight import TableSight
from tests.cell.twin.cameras.stage import PROFILE, Stage, block
from tests.cell.vision.layouts import true_view

VIEW = true_view()
SIGHT = TableSight.of_profile(PROFILE, "top", VIEW)
TURN_DEG = 25.0
LONG_MM = PROFILE.blocks["bridge"].length_mm
SHORT_MM = PROFILE.blocks["cube"].length_mm


@pytest.fixture(scope="module")
def seamless() -> NDArray[np.uint8]:
    """Return a picture of a bridge and a cube end to end, the seam between them painted over."""
    stage = Stage().put(
        block("bridge", "red", *_place(LONG_MM / 2.0), yaw_deg=TURN_DEG),
        block("cube", "red", *_place(LONG_MM + 0.01 + SHORT_MM / 2.0), yaw_deg=TURN_DEG),
    )
    stage.show("black")
    picture = stage.camera("top").grab().pixels.copy()
    column, row = VIEW.to_picture(np.array([_place(30.0)]), 71.5)[0].astype(int)
    colour = picture[row - 3 : row + 4, column - 3 : column + 4].mean(axis=(0, 1))
    _paint(picture, LONG_MM, 4.0, colour)
    return picture


def _place(along_mm: float, across_mm: float = 0.0) -> tuple[float, float]:
    cos, sin = math.cos(math.radians(TURN_DEG)), math.sin(math.radians(TURN_DEG))
    return 450.0 + cos * along_mm - sin * across_mm, 20.0 + sin * along_mm + cos * across_mm


def _paint(
    picture: NDArray[np.uint8], at_mm: float, half_mm: float, rgb: NDArray[np.float64]
) -> None:
    corners = [(at_mm + x * half_mm, y * 15.8) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    pixels = VIEW.to_picture(np.array([_place(*corner) for corner in corners]), 71.5)
    line = np.rint(pixels * 16.0).astype(np.int32)
    cv2.fillConvexPoly(picture, line, rgb.tolist(), cv2.LINE_AA, 4)


def test_a_row_without_a_seam_is_not_guessed_at(seamless: NDArray[np.uint8]) -> None:
    seen = recognise(OnePicture(seamless), SIGHT)
    assert seen.blocks == ()
    assert [thing.reason for thing in seen.unknown] == [
        "flush blocks in a row whose order cannot be seen"
    ]


@pytest.mark.parametrize(
    ("seam_mm", "bridge_mm"), [(LONG_MM, LONG_MM / 2.0), (SHORT_MM, SHORT_MM + LONG_MM / 2.0)]
)
def test_a_faint_seam_tells_the_order(
    seamless: NDArray[np.uint8], seam_mm: float, bridge_mm: float
) -> None:
    picture = seamless.copy()
    column, row = VIEW.to_picture(np.array([_place(20.0)]), 71.5)[0].astype(int)
    _paint(picture, seam_mm, 0.5, picture[row, column] - 6.0)
    blocks = recognise(OnePicture(picture), SIGHT).blocks
    assert sorted(b.kind for b in blocks) == ["bridge", "cube"]
    (bridge,) = (b for b in blocks if b.kind == "bridge")
    assert (bridge.x_mm, bridge.y_mm) == pytest.approx(_place(bridge_mm), abs=1.0)
