"""A picture of a record's samples for people, by its kind.

Where each sample was found and how far the fit is off; for a lens, where in the picture
corners were seen and how far it misses them; for a camera's settings, how its picture was
and is; for recognition, where each block lay.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.archive import Archive
from calibration.camera_settings.pictures import before_and_after
from calibration.errors import ArchiveError, CalibrationError, FitFailed
from calibration.lens.fit import BoardView, pose_of
from calibration.pictures import Pixels, decode_png
from calibration.record import CalibrationRecord, Sample
from cell.profile import LensProfile
from cell.vision.boards import Board, BoardCorners, find_board
from cell.vision.overlay import draw_coverage, draw_residuals

Points = NDArray[np.float64]

_SIZE_PX: Final = (1280, 960)
_LONGEST_PX: Final = 60.0
_FACTORS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_GREEN, _RED, _WHITE, _DARK = (64, 220, 64), (240, 64, 64), (255, 255, 255), (24, 24, 24)
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX


def overview_of(record: CalibrationRecord, archive: Archive) -> Pixels:
    """Return a picture (height, width, 3), R G B, of a record's samples.

    Args:
        record: The record.
        archive: Where its pictures are.

    Raises:
        CalibrationError: None of its samples has a place in a picture.
        ArchiveError: A picture that it needs is not there.
    """
    if record.kind == "camera-settings":
        return before_and_after(record, lambda digest: decode_png(archive.picture(digest), digest))
    if record.kind == "lens":
        return _coverage(record, archive)
    return _residuals(record, archive)


def _coverage(record: CalibrationRecord, archive: Archive) -> Pixels:
    """Return where corners were seen, looked for once more in the kept pictures."""
    board = _board_of(record)
    corners, seen, misses = [], [], []
    size, lens = _SIZE_PX, record.values.get(f"cameras.{record.subject}.lens")
    for sample in record.samples:
        if not (sample.is_used and sample.picture):
            continue
        pixels = decode_png(archive.picture(sample.picture), sample.label)
        size = (pixels.shape[1], pixels.shape[0])
        found = find_board(pixels, board)
        if found is not None:
            corners.append(found.pixels)
            off = None if lens is None else _lens_misses(board, found, lens, size[0])
            if off is not None:
                seen.append(found.pixels)
                misses.append(off)
    if not corners:
        raise _nothing_to_draw(record)
    places = np.concatenate(corners)
    text = f"{len(places)} corners in {len(corners)} views; dark: not covered"
    canvas = draw_coverage(size, places)
    if misses:
        off = np.concatenate(misses)
        factor = _factor(off)
        canvas = draw_residuals(canvas, np.concatenate(seen), off, enlarge=factor)
        text += f"; residuals x {factor}"
    else:
        text += "; no lens came of it"
    return _titled(canvas, record, text)


def _lens_misses(
    board: Board, found: BoardCorners, lens: JsonValue, width_px: int
) -> Points | None:
    """Return by how much in px (n, 2) a lens misses the corners of a view, None if undetermined."""
    model = LensProfile.model_validate(lens).model().resized(width_px)
    try:
        return pose_of(board, BoardView(label="", ids=found.ids, pixels=found.pixels), model)[1]
    except FitFailed:
        return None


def _board_of(record: CalibrationRecord) -> Board:
    data = record.details.get("board")
    if not isinstance(data, dict):
        raise _nothing_to_draw(record)
    try:
        return Board(
            kind="charuco" if data["kind"] == "charuco" else "chessboard",
            columns=int(str(data["columns"])), rows=int(str(data["rows"])),
            square_mm=float(str(data["square_mm"])),
            marker_mm=float(str(data.get("marker_mm", 0.0))),
            dictionary=str(data.get("dictionary", "DICT_5X5_100")),
        )  # fmt: skip
    except (KeyError, ValueError) as error:
        raise _nothing_to_draw(record) from error


def _residuals(record: CalibrationRecord, archive: Archive) -> Pixels:
    found = [(sample, place) for sample in record.samples
             if (place := _place(record, sample)) is not None]  # fmt: skip
    if not found:
        raise _nothing_to_draw(record)
    samples, places = [one for one, _ in found], np.array([place for _, place in found])
    canvas = _background(samples, archive)
    misses = _misses_px(samples, places)
    text = f"{len(samples)} samples"
    if misses is not None:
        inside = ((places >= 0) & (places < _SIZE_PX)).all(axis=1)
        factor = _factor(misses)
        canvas = draw_residuals(canvas, places[inside], misses[inside], enlarge=factor)
        lengths = [s.residual_mm for s in samples if s.residual_mm is not None]
        in_mm = f", {np.sqrt(np.mean(np.square(lengths))):.3g} mm RMS" if lengths else ""
        text += f", residuals x {factor}{in_mm}; red: not fitted on"
    for sample, place in found:
        _mark(canvas, sample, place)
    return _titled(canvas, record, text)


def _place(record: CalibrationRecord, sample: Sample) -> tuple[float, float] | None:
    """Return where in a picture a sample was found, None if nowhere."""
    # A block whose look is learned was laid somewhere; its colour and shape were measured.
    at = sample.given if record.kind == "recognition" else sample.measured
    return (at[0], at[1]) if len(at) == 2 else None


def _misses_px(samples: Sequence[Sample], places: Points) -> Points | None:
    """Return residuals (n, 2) as they look in the picture; None where they are none.

    Residuals in mm are those of robot points: how mm look there is fitted to the samples'
    own pairs of points and pixels.
    """
    if not all(len(sample.residual) == 2 for sample in samples):
        return None
    misses = np.array([sample.residual for sample in samples], np.float64)
    is_mm = [
        s.residual_mm is not None and abs(math.hypot(*s.residual) - s.residual_mm) < 1e-6
        for s in samples
    ]
    if not all(is_mm):
        return misses
    given = [sample.given for sample in samples]
    if len(given) < 3 or any(len(point) != 2 for point in given):
        return None
    rows = np.column_stack([np.array(given), np.ones(len(given))])
    slopes, _, rank, _ = np.linalg.lstsq(rows, places, rcond=None)
    return None if rank < 3 else np.asarray(misses @ slopes[:2], np.float64)


def _background(samples: Sequence[Sample], archive: Archive) -> Pixels:
    """Return the picture that most samples were found in, darkened; dark without one."""
    counted = Counter(sample.picture for sample in samples if sample.picture)
    for digest, _ in counted.most_common():
        try:
            pixels = decode_png(archive.picture(digest), digest)
        except ArchiveError:
            continue
        return np.asarray(pixels // 2, np.uint8)
    return np.full((_SIZE_PX[1], _SIZE_PX[0], 3), _DARK, np.uint8)


def _factor(misses: Points) -> int:
    longest = float(np.hypot(*misses.T).max(initial=0.0))
    fitting = [one for one in _FACTORS if one * longest <= _LONGEST_PX]
    return fitting[-1] if fitting else 1


def _mark(canvas: Pixels, sample: Sample, place: tuple[float, float]) -> None:
    colour = _GREEN if sample.is_used else _RED
    at = (round(place[0]), round(place[1]))
    cv2.circle(canvas, at, 5, colour, 1, cv2.LINE_AA)
    wide = cv2.getTextSize(sample.label, _FONT, 0.4, 1)[0][0]
    left = min(at[0] + 8, canvas.shape[1] - wide - 4)
    cv2.putText(canvas, sample.label, (left, at[1] - 8), _FONT, 0.4, colour, 1, cv2.LINE_AA)


def _titled(canvas: Pixels, record: CalibrationRecord, text: str) -> Pixels:
    whole = f"{record.kind} of {record.subject}, {record.identity[:8]}: {text}"
    wide = cv2.getTextSize(whole, _FONT, 0.6, 1)[0][0]
    bar = np.full((34, max(canvas.shape[1], wide + 16), 3), _DARK, np.uint8)
    cv2.putText(bar, whole, (8, 23), _FONT, 0.6, _WHITE, 1, cv2.LINE_AA)
    right = bar.shape[1] - canvas.shape[1]
    beside = np.pad(canvas, ((0, 0), (0, right), (0, 0)), constant_values=_DARK[0])
    return np.vstack([bar, beside])


def _nothing_to_draw(record: CalibrationRecord) -> CalibrationError:
    return CalibrationError(
        f"the samples of {record.identity[:8]} have no places in a picture; "
        "`cell calibration show` lists them"
    )
