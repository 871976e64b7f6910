"""Names what is wrong with views of a board, and what the next one should be like."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.lens.board_markers import SeenMarkers, count_by_dictionary, find_markers
from calibration.lens.fit import BoardView
from calibration.verdict import Finding, Grade
from cell.vision.boards import Board, find_chessboard, grey_of

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

COLUMNS, ROWS = 6, 5
"""Cells of the picture that should have corners."""

_LEAST_VIEWS = 3
_GOOD_VIEWS = 8
_COVERED = 0.7
_TILTED_DEG = 10.0
_SHARP = 0.13
_SAME_PX = 3.0
_ENOUGH_PX = 900
_UNIT_SLACK = 0.35
_LEAST_MARKERS = 4
_IN_ORDER = 0.15
_LIKELY_MM = (100.0, 10_000.0)
"""How far from a camera boards are held: a lens is not sharp nearer, and sees no corner further."""
_UNITS = (
    (0.1, "cm-for-mm", "centimetres"),
    (1 / 25.4, "inches-for-mm", "inches"),
    (0.001, "m-for-mm", "metres"),
)
_SIDES = ("left", "right", "top", "bottom")


def sharpness(picture: Pixels) -> float:
    """Return the steepest edges' slope as a share of the picture's contrast, a pixel.

    0.3 and more for sharp edges, the reciprocal of their width in px for blurred ones.
    """
    grey = cv2.GaussianBlur(grey_of(picture), (3, 3), 0).astype(np.float32)
    across, down = (
        cv2.Sobel(grey, cv2.CV_32F, 1, 0, scale=0.125),
        cv2.Sobel(grey, cv2.CV_32F, 0, 1, scale=0.125),
    )
    slope = cv2.magnitude(across, down)
    contrast = float(np.percentile(grey, 98) - np.percentile(grey, 2))
    return float(np.percentile(slope, 99.5)) / max(contrast, 1.0)


def without_board(label: str, picture: Pixels) -> Finding:
    """Return why no board may be seen in a picture."""
    sharp = sharpness(picture)
    if sharp < _SHARP:
        return Finding(
            code="blurred",
            grade=Grade.DEGRADED,
            text=f"{label} is blurred: edges are about {1.0 / max(sharp, 1e-3):.0f} px wide",
            hint="hold board and camera still, focus, or add light for a shorter shutter",
            samples=(label,),
        )
    return Finding(
        code="board-not-found",
        grade=Grade.DEGRADED,
        text=f"{label} shows no such board",
        hint="show all of it (a chessboard must not be cut off), without glare",
        samples=(label,),
    )


def other_board(picture: Pixels, board: Board) -> Finding | None:
    """Return which other board a picture shows: of another size, or with other markers."""
    if board.kind != "chessboard":
        return other_charuco(picture, board)
    sizes = [
        (board.columns + i, board.rows + j)
        for i in range(-2, 3)
        for j in range(-2, 3)
        if (i, j) != (0, 0) and board.columns + i >= 4 and board.rows + j >= 4
    ]
    small = picture
    while small.shape[1] > _ENOUGH_PX:
        small = np.asarray(cv2.pyrDown(small), np.uint8)
    # Every board holds smaller ones, so the largest that is found is the board.
    for columns, rows in sorted(sizes, key=lambda size: -size[0] * size[1]):
        if find_chessboard(small, columns, rows) is not None:
            return Finding(
                code="wrong-board",
                grade=Grade.BAD,
                text=f"the board has {columns} x {rows} squares, {board.columns} x {board.rows} "
                "were given",
                hint="count squares, not inner corners, which are one fewer each way"
                if (columns, rows) == (board.columns + 1, board.rows + 1)
                else "give the board's size",
            )
    return None


def other_charuco(picture: Pixels, board: Board) -> Finding | None:
    """Return which other ChArUco board a picture shows, if its markers tell."""
    own = find_markers(picture, board.dictionary)
    if len(own.ids) < _LEAST_MARKERS:
        return _other_dictionary(picture, board, len(own.ids))
    columns = _columns_of(own, board)
    count = board.columns * board.rows // 2
    last = int(own.ids.max())
    if columns in (None, board.columns) and last < count:
        return None
    seen = f"{columns} squares across" if columns not in (None, board.columns) else "more squares"
    rows = "" if last < count else f", and a marker number {last}, where {count - 1} is the last"
    return Finding(
        code="wrong-board",
        grade=Grade.BAD,
        text=f"the markers' order is that of a board with {seen}{rows}; {board.columns} x "
        f"{board.rows} were given",
        hint="count the squares across and down, black and white ones, and give those",
    )


def _other_dictionary(picture: Pixels, board: Board, own: int) -> Finding | None:
    counts = count_by_dictionary(picture)
    best = max(counts, key=lambda name: counts[name])
    if counts[best] < max(_LEAST_MARKERS, 2 * own + 1):
        return None
    return Finding(
        code="wrong-board",
        grade=Grade.BAD,
        text=f"the board's markers are of the dictionary {best} or a larger one of its family "
        f"({counts[best]} were read), {board.dictionary} was given",
        hint=f"answer `dictionary` with {best}, or take the board that was meant",
    )


def _columns_of(seen: SeenMarkers, board: Board) -> int | None:
    """Return the number of squares across for which the markers lie as a board's do."""
    best: tuple[float, int] | None = None
    for columns in range(3, 2 * board.columns + 3):
        # Two markers to every two rows of squares, one fewer in an odd row of odd boards.
        cells = np.array([_square_of(int(i), columns) for i in seen.ids], np.float64)
        if np.ptp(cells[:, 1]) < 1.0 or np.ptp(cells[:, 0]) < 1.0:
            continue
        matrix, _ = cv2.findHomography(cells, seen.centres_px)
        if matrix is None:
            continue
        there = cv2.perspectiveTransform(cells[None], matrix)[0]
        off = float(np.median(np.hypot(*(there - seen.centres_px).T))) / seen.side_px
        best = min(best or (off, columns), (off, columns))
    if best is None or best[0] > _IN_ORDER:
        return None
    return best[1]


def _square_of(marker: int, columns: int) -> tuple[int, int]:
    """Return column and row of the white square that a marker is in."""
    even, odd = columns // 2, (columns + 1) // 2
    pair, rest = divmod(marker, even + odd)
    if rest < even:
        return 2 * rest + 1, 2 * pair
    return 2 * (rest - even), 2 * pair + 1


def duplicates(views: Sequence[BoardView]) -> tuple[tuple[str, str], ...]:
    """Return views that show the board where an earlier one does, each with that one."""
    found = []
    for index, view in enumerate(views):
        for other in views[:index]:
            common, own, its = np.intersect1d(view.ids, other.ids, return_indices=True)
            if len(common) < 4:
                continue
            moved = np.hypot(*(view.pixels[own] - other.pixels[its]).T)
            if float(np.median(moved)) < _SAME_PX:
                found.append((view.label, other.label))
                break
    return tuple(found)


def coverage(views: Sequence[BoardView], width_px: int, height_px: int) -> NDArray[np.int64]:
    """Return how many corners lie in each cell of the picture, (ROWS, COLUMNS)."""
    counts = np.zeros((ROWS, COLUMNS), np.int64)
    for view in views:
        column = np.clip(view.pixels[:, 0] * COLUMNS / width_px, 0, COLUMNS - 1).astype(int)
        row = np.clip(view.pixels[:, 1] * ROWS / height_px, 0, ROWS - 1).astype(int)
        np.add.at(counts, (row, column), 1)
    return counts


def tilts(poses: Sequence[Points]) -> dict[str, float]:
    """Return how far the board was tilted to each side at most, in degrees.

    Tilted to the left: its left edge is further from the camera than its right one.
    """
    most = dict.fromkeys(_SIDES, 0.0)
    for pose in poses:
        rotation, _ = cv2.Rodrigues(pose[:3])
        # The axis out of the board, whichever way the board lies turned in the picture.
        normal = np.array(rotation[:, 2]) * np.sign(rotation[2, 2])
        x, y = (
            np.degrees(np.arctan2(normal[0], normal[2])),
            np.degrees(np.arctan2(normal[1], normal[2])),
        )
        most["left"] = max(most["left"], x)
        most["right"] = max(most["right"], -x)
        most["top"] = max(most["top"], y)
        most["bottom"] = max(most["bottom"], -y)
    return {side: float(value) for side, value in most.items()}


def guidance(
    views: Sequence[BoardView], poses: Sequence[Points], width_px: int, height_px: int
) -> str:
    """Return what the next view should be like."""
    flat = [side for side, value in tilts(poses).items() if value < _TILTED_DEG]
    if len(views) >= 2 and flat:
        return f"tilt the board more, its {flat[0]} edge away from the camera"
    empty = coverage(views, width_px, height_px) == 0
    if empty.any():
        return f"hold it into the {_where(empty)} of the picture"
    return "one from another distance"


def judge_views(
    views: Sequence[BoardView], poses: Sequence[Points], width_px: int, height_px: int
) -> tuple[Finding, ...]:
    """Return whether the views are many and different enough."""
    found: list[Finding] = []
    if len(views) < _GOOD_VIEWS:
        found.append(few_views(len(views)))
    empty = coverage(views, width_px, height_px) == 0
    covered = 1.0 - float(empty.mean())
    if covered < _COVERED:
        found.append(
            Finding(
                code="poor-coverage",
                grade=Grade.DEGRADED,
                text=f"corners were seen in {100 * covered:.0f} % of the picture, not in its "
                f"{_where(empty)}",
                hint="hold the board there, too: what the lens bends is measured nowhere else",
            )
        )
    flat = [side for side, value in tilts(poses).items() if value < _TILTED_DEG]
    if len(flat) > 1:
        found.append(
            Finding(
                code="no-tilt" if len(flat) == len(_SIDES) else "little-tilt",
                grade=Grade.BAD if len(flat) == len(_SIDES) else Grade.DEGRADED,
                text=f"the board was tilted less than {_TILTED_DEG:g} deg with its "
                f"{', '.join(flat)} edge away: focal length and distance are hardly told apart",
                hint=f"tilt it by 20 to 40 deg, its {' and its '.join(flat)} edge away",
            )
        )
    return tuple(found)


def few_views(count: int) -> Finding:
    """Return the finding that there are too few views."""
    return Finding(
        code="too-few-views",
        grade=Grade.BAD if count < _LEAST_VIEWS else Grade.DEGRADED,
        text=f"the board was found in {count} different views, {_GOOD_VIEWS} or more are needed",
        hint="take more, each tilted and placed differently",
    )


def judge_distance(poses: Sequence[Points], measured_mm: float) -> tuple[Finding, ...]:
    """Return whether the squares' given size fits a distance that somebody measured.

    Lens and pictures alone do not tell the size of the squares. Where nobody measured, only
    a distance at which no lens is sharp shows that it is wrong; the lens is the same with any.
    """
    if not poses:
        return ()
    told_mm = float(np.median([pose[5] for pose in poses]))
    if measured_mm <= 0:
        return _unlikely_distance(told_mm)
    ratio = told_mm / measured_mm
    for factor, code, unit in _UNITS:
        if abs(ratio / factor - 1.0) < _UNIT_SLACK:
            return (
                Finding(
                    code=code,
                    grade=Grade.BAD,
                    text=f"by the squares' size the board was {ratio:.2g} times as far away as "
                    f"measured: the size seems to be given in {unit}",
                    hint="give the side of a square in millimetres",
                ),
            )
        if abs(ratio * factor - 1.0) < _UNIT_SLACK:
            return (
                Finding(
                    code=code,
                    grade=Grade.BAD,
                    text=f"by the squares' size the board was {ratio:.4g} times as far away as "
                    f"measured: the distance seems to be given in {unit}",
                    hint="give the distance in millimetres, and look whether the side of a square "
                    "is right",
                ),
            )
    if abs(ratio - 1.0) > _UNIT_SLACK:
        return (
            Finding(
                code="wrong-square-size",
                grade=Grade.BAD,
                text=f"by the squares' size the board was {ratio:.2f} times as far away as "
                "measured",
                hint="measure a square of the printed board",
            ),
        )
    return ()


def _unlikely_distance(told_mm: float) -> tuple[Finding, ...]:
    low, high = _LIKELY_MM
    if low <= told_mm <= high:
        return ()
    for factor, code, unit in _UNITS:
        if code != "inches-for-mm" and low <= told_mm / factor <= high:
            return (
                Finding(
                    code=code,
                    grade=Grade.DEGRADED,
                    text=f"by the squares' size the board was {told_mm:.3g} mm away: the size "
                    f"seems to be given in {unit} (the lens comes out the same with any)",
                    hint="give the side of a square in millimetres, and the distance as measured",
                ),
            )
    return (
        Finding(
            code="wrong-square-size",
            grade=Grade.DEGRADED,
            text=f"by the squares' size the board was {told_mm:.3g} mm away (the lens comes out "
            "the same with any size)",
            hint="measure a square of the printed board, and give it in millimetres",
        ),
    )


def _where(empty: NDArray[np.bool_]) -> str:
    """Return the part of the picture where most cells are empty, in words."""
    thirds = {
        "upper left": empty[: ROWS // 2 + 1, : COLUMNS // 2],
        "upper right": empty[: ROWS // 2 + 1, COLUMNS // 2 :],
        "lower left": empty[ROWS // 2 :, : COLUMNS // 2],
        "lower right": empty[ROWS // 2 :, COLUMNS // 2 :],
    }
    return max(thirds, key=lambda name: float(thirds[name].mean()))
