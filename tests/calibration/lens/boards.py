"""Views of a board before a known lens, their corners projected with noise."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.lens.fit import BoardView
from cell.geometry import LensModel
from cell.vision.boards import Board

BOARD = Board(
    kind="charuco", columns=11, rows=8, square_mm=30.0, marker_mm=22.0, dictionary="DICT_5X5_100"
)


def board_views(
    lens: LensModel,
    count: int,
    random: np.random.Generator,
    *,
    noise_px: float,
    tilt_deg: float = 35.0,
    board: Board = BOARD,
) -> tuple[Board, list[BoardView]]:
    """Return views of a board held at many places and tilts; corners outside are not seen."""
    views: list[BoardView] = []
    points = board.points_mm
    middle = points.mean(axis=0)
    fill_mm = lens.focal_u_px * board.size_mm[0] / lens.width_px
    while len(views) < count:
        turn = _tilted(len(views), tilt_deg, random)
        z_mm = fill_mm * random.uniform(1.05, 1.9)
        half = 0.5 * z_mm / lens.focal_u_px * np.array([lens.width_px, lens.height_px])
        aim = random.uniform(-0.45, 0.45, 2) * half
        shift = np.array([aim[0], aim[1], z_mm]) - turn @ middle
        at = points @ turn.T + shift
        pixels = lens.to_picture(at[:, :2] / at[:, 2:])
        inside = ((pixels > 5) & (pixels < (lens.width_px - 6, lens.height_px - 6))).all(axis=1)
        if inside.sum() < 30:
            continue
        ids = np.flatnonzero(inside)
        seen = pixels[ids] + random.normal(0.0, noise_px, (len(ids), 2))
        views.append(BoardView(label=f"view {len(views) + 1}", ids=ids, pixels=seen))
    return board, views


def _tilted(index: int, tilt_deg: float, random: np.random.Generator) -> NDArray[np.float64]:
    """Return a rotation: tilted to one of eight sides in turn, and turned a little in itself."""
    side = math.radians(45.0 * index + random.uniform(-20.0, 20.0))
    tilt = math.radians(tilt_deg) * random.uniform(0.6, 1.0)
    tilted, _ = cv2.Rodrigues(np.array([math.cos(side), math.sin(side), 0.0]) * tilt)
    turned, _ = cv2.Rodrigues(np.array([0.0, 0.0, random.uniform(-0.3, 0.3)]))
    return np.asarray(tilted @ turned, np.float64)
