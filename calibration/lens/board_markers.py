"""The markers of a ChArUco board as they are seen, of whichever dictionary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from cell.vision.boards import grey_of

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]

DICTIONARIES: Final = (
    "DICT_4X4_50", "DICT_5X5_50", "DICT_6X6_50", "DICT_7X7_50",
    "DICT_ARUCO_ORIGINAL", "DICT_ARUCO_MIP_36h12", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9",
    "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11",
)  # fmt: skip
"""OpenCV's, of each family the smallest: its markers are the first of the larger ones."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenMarkers:
    """Markers in a picture.

    Attributes:
        ids: Their numbers, (n,).
        centres_px: Where their middles are, (n, 2).
        side_px: Their usual side; 0 where there are none.
    """

    ids: NDArray[np.int64]
    centres_px: Points
    side_px: float


def find_markers(picture: Pixels, dictionary: str) -> SeenMarkers:
    """Return the markers of a dictionary in a picture, R G B or grey.

    Raises:
        CalibrationError: There is no such dictionary.
    """
    detector = cv2.aruco.ArucoDetector(_known(dictionary))
    corners, ids, _ = detector.detectMarkers(grey_of(picture))
    if ids is None or not len(corners):
        return SeenMarkers(np.empty(0, np.int64), np.empty((0, 2)), 0.0)
    places = np.array([one.reshape(4, 2) for one in corners], np.float64)
    sides = np.hypot(*(places - np.roll(places, 1, axis=1)).reshape(-1, 2).T)
    return SeenMarkers(
        np.asarray(ids.ravel(), np.int64), places.mean(axis=1), float(np.median(sides))
    )


def count_by_dictionary(picture: Pixels) -> dict[str, int]:
    """Return how many markers of each of `DICTIONARIES` a picture, R G B or grey, shows."""
    detector = cv2.aruco.ArucoDetector([_known(name) for name in DICTIONARIES])
    _, _, _, which = detector.detectMarkersMultiDict(grey_of(picture))
    found = np.zeros(0, np.int64) if which is None else np.asarray(which, np.int64).ravel()
    return {name: int((found == index).sum()) for index, name in enumerate(DICTIONARIES)}


def _known(dictionary: str) -> cv2.aruco.Dictionary:
    number = getattr(cv2.aruco, dictionary, None) if dictionary.startswith("DICT_") else None
    if not isinstance(number, int):
        raise CalibrationError(
            f"there is no dictionary {dictionary}; there is DICT_5X5_100, for instance"
        )
    return cv2.aruco.getPredefinedDictionary(number)
