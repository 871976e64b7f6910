"""The ChArUco board on the screen: whether it is seen the right way, and whether it stays."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.screen.decode import grey_of
from calibration.screen.patterns import Panel, charuco_board
from calibration.verdict import Finding, Grade

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_FEWEST = 8
_STILL_PX = 0.25


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenBoard:
    """Corners of the board in a picture.

    Attributes:
        index: Which corners, (n,).
        pixels: Where they appear, (n, 2).
        places: Their columns and rows on the screen, (n, 2).
    """

    index: NDArray[np.int_]
    pixels: Points
    places: Points


def find_board(picture: Pixels, panel: Panel) -> SeenBoard:
    """Return the corners of the board that a camera sees, none if it sees no board."""
    board = charuco_board(panel.width_px, panel.height_px)
    detector = cv2.aruco.CharucoDetector(board)
    corners, ids, _, _ = detector.detectBoard(grey_of(picture))
    if ids is None or corners is None:
        return SeenBoard(index=np.empty(0, int), pixels=np.empty((0, 2)), places=np.empty((0, 2)))
    index = np.asarray(ids).ravel().astype(int)
    # Corners lie between pixels; pixel centres are whole numbers.
    places = np.asarray(board.getChessboardCorners(), np.float64)[index, :2] - 0.5
    pixels = np.asarray(corners, np.float64).reshape(-1, 2)
    return SeenBoard(index=index, pixels=pixels, places=places)


def judge_board(camera: str, picture: Pixels, seen: SeenBoard, panel: Panel) -> tuple[Finding, ...]:
    """Return what is wrong with how a camera sees the board."""
    if len(seen.index) >= _FEWEST:
        return ()
    flipped = find_board(np.ascontiguousarray(picture[:, ::-1]), panel)
    if len(flipped.index) >= _FEWEST:
        return (
            Finding(
                code="picture-mirrored",
                grade=Grade.BAD,
                text=f"camera {camera} sees the screen's picture mirrored",
                hint="switch off mirroring in the television's menu (picture, rear projection or "
                "flip) or in the camera's driver",
            ),
        )
    return (
        Finding(
            code="screen-not-seen",
            grade=Grade.BAD,
            text=f"camera {camera} finds {len(seen.index)} corners of the board on the screen, "
            f"{_FEWEST} are needed",
            hint="clear the screen, bring the arm aside, focus the lens, and see whether the "
            "television shows the page",
        ),
    )


def judge_rest(camera: str, first: SeenBoard, last: SeenBoard) -> tuple[Finding, ...]:
    """Return whether a camera or the screen moved between the first picture and the last."""
    both, at_first, at_last = np.intersect1d(first.index, last.index, return_indices=True)
    if len(both) < _FEWEST:
        return (
            Finding(
                code="covered-meanwhile",
                grade=Grade.BAD,
                text=f"camera {camera} saw {len(first.index)} corners of the board at first and "
                f"{len(last.index)} at the end, {len(both)} of them the same",
                hint="keep hands and arm off the screen, and calibrate again",
            ),
        )
    shift = last.pixels[at_last] - first.pixels[at_first]
    moved_px = float(np.median(np.hypot(shift[:, 0], shift[:, 1])))
    if moved_px <= _STILL_PX:
        return ()
    return (
        Finding(
            code="camera-moved",
            grade=Grade.BAD,
            text=f"camera {camera} or the screen moved while it was measured: the board lies "
            f"{moved_px:.2f} px elsewhere at the end",
            hint="fasten the camera, do not touch the table, and calibrate again",
        ),
    )
