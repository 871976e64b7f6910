"""Calibration boards, chessboard and ChArUco: drawn to scale, and their corners found again.

Points of a board lie in its own plane, x to its right and y down, from its upper left
corner; corners count along the rows from the upper left one.

A chessboard looks the same turned by half a turn when its numbers of columns and rows are
both odd or both even, and only in part seen it cannot be read at all; a ChArUco board has a
marker in each white square, so any corner of it is known by its number.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import VisionError

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]

BoardKind = Literal["chessboard", "charuco"]

_SEARCH_WIDTH_PX = 1400
"""Pictures wider than this are searched at a smaller size and refined at their own."""

_LEAST_CHARUCO_CORNERS = 4
_REFINE_STEPS = 40
_REFINE_DONE_PX = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """A calibration board.

    Attributes:
        kind: `chessboard` or `charuco`.
        columns: Squares along x; inner corners are one fewer.
        rows: Squares along y.
        square_mm: Side of a square.
        marker_mm: Side of the markers of a ChArUco board, smaller than a square; 0 for none.
        dictionary: OpenCV's name of the markers' dictionary, such as `DICT_5X5_100`.
    """

    kind: BoardKind
    columns: int
    rows: int
    square_mm: float
    marker_mm: float = 0.0
    dictionary: str = "DICT_5X5_100"

    def __post_init__(self) -> None:
        if self.columns < 3 or self.rows < 3:
            raise ValueError(f"a board has 3 x 3 squares or more, not {self.columns}x{self.rows}")
        if self.square_mm <= 0.0:
            raise ValueError(f"a square of {self.square_mm:g} mm is none")
        if self.kind == "charuco" and not 0.0 < self.marker_mm < self.square_mm:
            raise ValueError(
                f"a marker of {self.marker_mm:g} mm does not fit into a square of "
                f"{self.square_mm:g} mm"
            )

    @property
    def points_mm(self) -> Points:
        """The inner corners on the board, (n, 3) with z = 0, by their numbers."""
        count_x, count_y = self.columns - 1, self.rows - 1
        y, x = np.mgrid[1 : count_y + 1, 1 : count_x + 1]
        flat = np.stack([x.ravel(), y.ravel(), np.zeros(count_x * count_y)], axis=1)
        return np.asarray(flat * self.square_mm, np.float64)

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of all squares."""
        return self.columns * self.square_mm, self.rows * self.square_mm

    def draw(self, px_per_mm: float) -> Pixels:
        """Return the board to scale, grey (h, w), without a margin: print or show it with one.

        Args:
            px_per_mm: Scale; a square is drawn in whole pixels.

        Raises:
            ValueError: The scale leaves fewer than 8 pixels to a square.
        """
        side = round(self.square_mm * px_per_mm)
        if side < 8:
            raise ValueError(f"{px_per_mm:g} pixels a millimetre are too few for this board")
        if self.kind == "charuco":
            size = (self.columns * side, self.rows * side)
            return np.asarray(_charuco(self).generateImage(size, marginSize=0), np.uint8)
        y, x = np.mgrid[: self.rows * side, : self.columns * side] // side
        return np.asarray(255 * ((x + y) % 2), np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class BoardCorners:
    """Corners of a board in a picture.

    Attributes:
        ids: Their numbers on the board, (n,), ascending; rows of `Board.points_mm`.
        pixels: Where they are, (n, 2), pixel centres at whole numbers.
    """

    ids: NDArray[np.int64]
    pixels: Points


def find_board(picture: Pixels, board: Board) -> BoardCorners | None:
    """Return the corners of a board of either kind, None when it is not seen."""
    if board.kind == "charuco":
        return find_charuco(picture, board)
    return find_chessboard(picture, board.columns, board.rows)


def find_chessboard(picture: Pixels, columns: int, rows: int) -> BoardCorners | None:
    """Return all inner corners of a chessboard, to a subpixel; None unless all are seen.

    Args:
        picture: R G B (h, w, 3) or grey (h, w), uint8.
        columns: Squares along the board's x.
        rows: Squares along its y.

    Raises:
        ValueError: The board has fewer than 3 x 3 squares.
        VisionError: The picture is no uint8 picture.
    """
    if columns < 3 or rows < 3:
        raise ValueError(f"a chessboard has 3 x 3 squares or more, not {columns} x {rows}")
    grey = grey_of(picture)
    shape = (columns - 1, rows - 1)
    # Sector based (Duda and Frese 2018): finds blurred and bent boards, and is as exact
    # as its own refinement, which a second one would only disturb.
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    found: tuple[bool, cv2.typing.MatLike | None] = cv2.findChessboardCornersSB(
        grey, shape, flags=flags
    )
    if not found[0]:
        # Uneven light over a flat scan or a photograph: the older search by quads.
        found = _by_quads(grey, shape)
    is_found, corners = found
    if not is_found or corners is None:
        return None
    pixels = np.asarray(corners, np.float64).reshape(-1, 2)
    return BoardCorners(np.arange(len(pixels)), _from_upper_left(pixels, shape))


def find_charuco(picture: Pixels, board: Board) -> BoardCorners | None:
    """Return the corners of a ChArUco board that are seen, None for fewer than four.

    Args:
        picture: R G B (h, w, 3) or grey (h, w), uint8.
        board: The board; only `charuco` has numbers.

    Raises:
        ValueError: The board is a chessboard.
        VisionError: The picture is no uint8 picture, or there is no such dictionary.
    """
    if board.kind != "charuco":
        raise ValueError("a chessboard has no markers; look for it with find_chessboard")
    grey = grey_of(picture)
    parameters = cv2.aruco.CharucoParameters()
    parameters.tryRefineMarkers = True
    detector = cv2.aruco.CharucoDetector(_charuco(board), parameters)
    corners, ids, _, _ = detector.detectBoard(grey)
    if ids is None or corners is None or len(ids) < _LEAST_CHARUCO_CORNERS:
        return None
    numbers = np.asarray(ids, np.int64).ravel()
    order = np.argsort(numbers)
    pixels = np.asarray(corners, np.float64).reshape(-1, 2)
    return BoardCorners(numbers[order], _refined(grey, pixels[order]))


def dictionary_named(name: str) -> cv2.aruco.Dictionary:
    """Return OpenCV's dictionary of markers.

    Raises:
        VisionError: There is none of that name.
    """
    number = vars(cv2.aruco).get(name) if name.startswith("DICT_") else None
    if not isinstance(number, int):
        raise VisionError(
            f"there is no dictionary of markers {name!r}; OpenCV's names are such as "
            "DICT_5X5_100, DICT_6X6_250 or DICT_APRILTAG_36h11"
        )
    return cv2.aruco.getPredefinedDictionary(number)


def grey_of(picture: Pixels) -> Pixels:
    """Return a picture in grey.

    Raises:
        VisionError: It is no uint8 picture.
    """
    if picture.dtype != np.uint8 or picture.ndim not in (2, 3) or picture.size == 0:
        raise VisionError(
            f"this is no picture but {picture.dtype} of shape {picture.shape}; "
            "give uint8, grey (h, w) or R G B (h, w, 3)"
        )
    if picture.ndim == 2:
        return np.ascontiguousarray(picture)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)


@lru_cache(maxsize=8)
def _charuco(board: Board) -> cv2.aruco.CharucoBoard:
    return cv2.aruco.CharucoBoard(
        (board.columns, board.rows),
        board.square_mm,
        board.marker_mm,
        dictionary_named(board.dictionary),
    )


def _by_quads(grey: Pixels, shape: tuple[int, int]) -> tuple[bool, cv2.typing.MatLike | None]:
    scale = min(1.0, _SEARCH_WIDTH_PX / grey.shape[1])
    small = grey if scale == 1.0 else cv2.resize(grey, None, fx=scale, fy=scale)
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    is_found, corners = cv2.findChessboardCorners(small, shape, flags=flags)
    if not is_found:
        return False, None
    pixels = (np.asarray(corners, np.float64).reshape(-1, 2) + 0.5) / scale - 0.5
    return True, _refined(grey, pixels)


def _refined(grey: Pixels, pixels: Points) -> Points:
    """Return saddle points moved to where the gradients around them are square to their rays."""
    gaps = np.linalg.norm(pixels[:, None] - pixels[None], axis=2)
    np.fill_diagonal(gaps, np.inf)
    # The window must not reach the next corner.
    half = int(np.clip(0.3 * np.median(gaps.min(axis=1)), 2, 11))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, _REFINE_STEPS, _REFINE_DONE_PX)
    start = pixels.astype(np.float32).reshape(-1, 1, 2)
    moved = cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria)
    return np.asarray(moved, np.float64).reshape(-1, 2)


def _from_upper_left(pixels: Points, shape: tuple[int, int]) -> Points:
    """Return the corners in the order that starts nearer to the picture's upper left.

    A board turned by half a turn looks the same; one order for all its pictures is enough.
    """
    first, last = pixels[0], pixels[-1]
    is_turned = first.sum() > last.sum()
    grid = pixels.reshape(shape[1], shape[0], 2)
    return np.ascontiguousarray(grid[::-1, ::-1].reshape(-1, 2) if is_turned else pixels)
