"""Finds a sheet's markers in a picture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.sheet.fiducials import index_of, marker_dictionary

Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundMarker:
    """A marker in a picture.

    Attributes:
        marker_id: Its id.
        corners_px: Columns and rows of its corners, (4, 2), from its upper left one
            clockwise; pixel centres are whole numbers.
    """

    marker_id: int
    corners_px: NDArray[np.float64]


def find_markers(pixels: Pixels) -> tuple[FoundMarker, ...]:
    """Return the markers of sheets in a picture (h, w, 3), lowest id first.

    A marker that is seen twice is left out: one of the two is something else.
    """
    corners, ids, _ = _detector().detectMarkers(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY))
    if ids is None:
        return ()
    numbers = [int(one) for one in np.asarray(ids).ravel()]
    found = [
        FoundMarker(marker_id=number, corners_px=np.asarray(corner, np.float64).reshape(4, 2))
        for number, corner in zip(numbers, corners, strict=True)
        if index_of(number) is not None and numbers.count(number) == 1
    ]
    return tuple(sorted(found, key=lambda marker: marker.marker_id))


def find_mirrored(pixels: Pixels) -> tuple[int, ...]:
    """Return ids of the markers that are in the picture's mirror image."""
    flipped = np.ascontiguousarray(pixels[:, ::-1])
    return tuple(marker.marker_id for marker in find_markers(flipped))


@cache
def _detector() -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 5
    parameters.cornerRefinementMinAccuracy = 0.005
    parameters.cornerRefinementMaxIterations = 60
    # A wrong bit more, and one of a thousand ids is taken for another.
    parameters.errorCorrectionRate = 0.3
    return cv2.aruco.ArucoDetector(marker_dictionary(), parameters)
