"""What a camera on the flange may be calibrated with: screen, store's sheet or a board."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.mount.model import transform
from calibration.screen.board import find_board as find_screen_board
from calibration.screen.patterns import Panel, charuco_board
from cell.geometry import Transform
from cell.profile import DisplayProfile, StoreProfile
from cell.sheet import SheetLayout
from cell.sheet.finding import find_markers
from cell.vision.boards import Board, find_board

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Target:
    """A flat target.

    Attributes:
        name: Its name, for people.
        points_mm: All its points, (n, 3), x to its right, y down, z = 0.
        size_mm: How far it reaches from its corner (0, 0).
        guess: Roughly robot_from_target.
        least: Fewest points that make a view.
        find: Returns the points that a picture shows: theirs on the target (m, 3), and pixels
            (m, 2).
    """

    name: str
    points_mm: Points
    size_mm: tuple[float, float]
    guess: Transform
    least: int
    find: Callable[[Pixels], tuple[Points, Points]]


def screen_target(display: DisplayProfile, surface_mm: float) -> Target:
    """Return the ChArUco board that the screen under the playground shows."""
    panel = Panel(width_px=display.width_px, height_px=display.height_px)
    board = charuco_board(panel.width_px, panel.height_px)
    corners = np.asarray(board.getChessboardCorners(), np.float64) * display.pixel_mm

    def find(picture: Pixels) -> tuple[Points, Points]:
        seen = find_screen_board(picture, panel)
        return corners[seen.index], seen.pixels

    return Target(
        name="the board on the screen",
        points_mm=corners,
        size_mm=(display.width_px * display.pixel_mm, display.height_px * display.pixel_mm),
        guess=lying(display.corner_x_mm, display.corner_y_mm, display.angle_deg, surface_mm),
        least=12,
        find=find,
    )


def sheet_target(layout: SheetLayout, store: StoreProfile, surface_mm: float) -> Target:
    """Return the store's printed sheet with its markers."""
    places = {
        one.marker_id: np.array([(x, y, 0.0) for x, y in one.corners_mm])
        for one in layout.fiducials
    }

    def find(picture: Pixels) -> tuple[Points, Points]:
        seen = [one for one in find_markers(picture) if one.marker_id in places]
        if not seen:
            return np.empty((0, 3)), np.empty((0, 2))
        return (
            np.concatenate([places[one.marker_id] for one in seen]),
            np.concatenate([one.corners_px for one in seen]),
        )

    return Target(
        name="the store's sheet",
        points_mm=np.concatenate(list(places.values())),
        size_mm=(float(layout.width_mm), float(layout.height_mm)),
        guess=lying(*store.corner_mm, store.angle_deg, surface_mm),
        least=12,
        find=find,
    )


def board_target(board: Board, corner: tuple[float, float, float], surface_mm: float) -> Target:
    """Return a printed board that lies on the table.

    Args:
        board: The board.
        corner: Roughly robot x, y of its upper left corner and the direction of its x (deg).
        surface_mm: Height of the table.
    """

    def find(picture: Pixels) -> tuple[Points, Points]:
        seen = find_board(picture, board)
        if seen is None:
            return np.empty((0, 3)), np.empty((0, 2))
        return board.points_mm[seen.ids], seen.pixels

    return Target(
        name=f"the {board.kind} of {board.columns} x {board.rows} squares",
        points_mm=board.points_mm,
        size_mm=board.size_mm,
        guess=lying(*corner, surface_mm),
        least=12,
        find=find,
    )


def lying(x_mm: float, y_mm: float, angle_deg: float, z_mm: float) -> Transform:
    """Return robot_from_target of one that lies face up, x along an angle, y to its right."""
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    turn = np.array([[cos, sin, 0.0], [sin, -cos, 0.0], [0.0, 0.0, -1.0]])
    return transform(turn, np.array([x_mm, y_mm, z_mm]))
