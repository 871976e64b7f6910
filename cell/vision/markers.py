"""ArUco markers: found, their corners to a subpixel, and how they stand to the camera.

A flat square seen from afar has two poses that fit almost equally (Collins and Bartoli,
"Infinitesimal plane-based pose estimation", 2014): both are given, and by how much the first
fits better. Its uncertainty follows from the noise of the corners.

Boards of markers and chessboards are in `cell.vision.boards`; their names are here as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import LensModel, Transform
from cell.vision.boards import (
    Board,
    BoardCorners,
    dictionary_named,
    find_board,
    find_charuco,
    find_chessboard,
    grey_of,
)

__all__ = [
    "Board",
    "BoardCorners",
    "FlatPose",
    "Marker",
    "MarkerPose",
    "find_board",
    "find_charuco",
    "find_chessboard",
    "find_markers",
    "marker_pose",
]

Points = NDArray[np.float64]

CORNER_NOISE_PX = 0.1
"""Standard deviation of a marker's corner, refined, in a sharp picture."""

_LEAST_WINDOW_PX = 2
_MOST_WINDOW_PX = 7
_REFINE = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
_STEP = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A marker in a picture.

    Attributes:
        number: Its number in the dictionary.
        corners_px: Its corners (4, 2): upper left, upper right, lower right, lower left of
            the marker as it is printed; pixel centres at whole numbers.
    """

    number: int
    corners_px: Points

    @property
    def centre_px(self) -> Points:
        """Where its diagonals cross: the picture of its middle, (2,)."""
        a, b, c, d = self.corners_px
        across, down = c - a, d - b
        cross = across[0] * down[1] - across[1] * down[0]
        offset = b - a
        share = (offset[0] * down[1] - offset[1] * down[0]) / cross
        return np.asarray(a + share * across)


@dataclass(frozen=True, slots=True, eq=False)
class FlatPose:
    """One pose that explains a marker's corners.

    Attributes:
        camera_from_marker: Marker x to its right, y to its upper edge, z out of it.
        residual_px: Root mean square of the corners' misses.
    """

    camera_from_marker: Transform
    residual_px: float


@dataclass(frozen=True, slots=True, eq=False)
class MarkerPose:
    """How a marker stands to the camera.

    Attributes:
        best: The pose that fits better.
        other: The mirrored one; None when there is none in front of the camera.
        covariance: Of `best`: turn about the camera's x, y, z in rad and shift in mm, (6, 6).
        ambiguity: Likelihood of `other` relative to `best`, 0 (ruled out) to 1 (no telling).
    """

    best: FlatPose
    other: FlatPose | None
    covariance: NDArray[np.float64]
    ambiguity: float

    @property
    def shift_deviation_mm(self) -> Points:
        """Standard deviation of the place along the camera's x, y, z, (3,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[3:]))

    @property
    def turn_deviation_deg(self) -> Points:
        """Standard deviation of the turn about the camera's x, y, z, (3,)."""
        return np.asarray(np.degrees(np.sqrt(np.diag(self.covariance)[:3])))


def find_markers(
    picture: NDArray[np.uint8], dictionary: str = "DICT_6X6_250"
) -> tuple[Marker, ...]:
    """Return the markers of a dictionary in a picture, by their numbers.

    Args:
        picture: R G B (h, w, 3) or grey (h, w), uint8.
        dictionary: OpenCV's name of the dictionary.

    Raises:
        VisionError: It is no picture, or there is no such dictionary.
    """
    grey = grey_of(picture)
    detector = cv2.aruco.ArucoDetector(dictionary_named(dictionary), cv2.aruco.DetectorParameters())
    corners, ids, _ = detector.detectMarkers(grey)
    if ids is None:
        return ()
    found = [
        Marker(int(number), _refined(grey, np.asarray(four, np.float64).reshape(4, 2)))
        for number, four in zip(np.asarray(ids).ravel(), corners, strict=True)
    ]
    return tuple(sorted(found, key=lambda marker: marker.number))


def marker_pose(
    marker: Marker, side_mm: float, lens: LensModel, *, noise_px: float = CORNER_NOISE_PX
) -> MarkerPose | None:
    """Return how a marker stands to the camera, None when no pose fits in front of it.

    Args:
        marker: The marker.
        side_mm: Side of its black square.
        lens: The camera's lens, for pictures of the size that the corners are in.
        noise_px: Standard deviation of a corner's coordinate; sets covariance and ambiguity.

    Raises:
        ValueError: Side or noise is not positive.
    """
    if side_mm <= 0.0 or noise_px <= 0.0:
        raise ValueError(f"a side of {side_mm:g} mm or a noise of {noise_px:g} px is none")
    square = _square(side_mm)
    # Ideal corners: the lens' bending is taken off first, IPPE knows pinholes only.
    ideal = lens.to_directions(marker.corners_px)
    count, turns, shifts, _ = cv2.solvePnPGeneric(
        square, ideal, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    poses = []
    for turn, shift in list(zip(turns, shifts, strict=True))[:count]:
        pose = _polished(square, marker.corners_px, lens, np.r_[turn.ravel(), shift.ravel()])
        if pose is not None:
            poses.append(pose)
    if not poses:
        return None
    poses.sort(key=lambda one: one[1])
    best, sum_best = poses[0]
    other = None
    ambiguity = 0.0
    if len(poses) > 1:
        sum_other = poses[1][1]
        other = _flat_pose(poses[1][0], sum_other)
        ambiguity = math.exp(-0.5 * (sum_other - sum_best) / noise_px**2)
    slopes = _slopes(square, lens, best)
    covariance = np.asarray(noise_px**2 * np.linalg.pinv(slopes.T @ slopes), np.float64)
    return MarkerPose(
        best=_flat_pose(best, sum_best), other=other, covariance=covariance, ambiguity=ambiguity
    )


def _square(side_mm: float) -> Points:
    half = side_mm / 2.0
    return half * np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])


def _flat_pose(values: Points, squares: float) -> FlatPose:
    matrix = np.eye(4)
    matrix[:3, :3] = cv2.Rodrigues(values[:3])[0]
    matrix[:3, 3] = values[3:]
    return FlatPose(Transform(matrix), math.sqrt(squares / 4.0))


def _project(square: Points, lens: LensModel, values: Points) -> Points:
    rotation = np.asarray(cv2.Rodrigues(values[:3])[0])
    points = square @ rotation.T + values[3:]
    return lens.to_picture(points[:, :2] / points[:, 2:])


def _slopes(square: Points, lens: LensModel, values: Points) -> Points:
    """Return the derivatives (8, 6) of the corners by a turn in the camera frame and a shift."""
    rotation = np.asarray(cv2.Rodrigues(values[:3])[0])
    columns = []
    for index in range(6):
        two = []
        for sign in (-1.0, 1.0):
            step = np.zeros(6)
            step[index] = sign * _STEP * (1.0 if index < 3 else values[5])
            turned = np.asarray(cv2.Rodrigues(step[:3])[0]) @ rotation
            points = square @ turned.T + values[3:] + step[3:]
            two.append(lens.to_picture(points[:, :2] / points[:, 2:]).ravel())
        width = 2.0 * _STEP * (1.0 if index < 3 else values[5])
        columns.append((two[1] - two[0]) / width)
    return np.stack(columns, axis=1)


def _polished(
    square: Points, corners_px: Points, lens: LensModel, values: Points
) -> tuple[Points, float] | None:
    """Return the pose with the least misses in the picture near a start, and their squares."""
    for _ in range(8):
        if values[5] <= 0.0:
            return None
        miss = (corners_px - _project(square, lens, values)).ravel()
        slopes = _slopes(square, lens, values)
        step = np.linalg.lstsq(slopes, miss, rcond=None)[0]
        turned = np.asarray(cv2.Rodrigues(step[:3])[0]) @ np.asarray(cv2.Rodrigues(values[:3])[0])
        moved = np.r_[np.asarray(cv2.Rodrigues(turned)[0]).ravel(), values[3:] + step[3:]]
        after = (
            float(np.sum((corners_px - _project(square, lens, moved)) ** 2))
            if moved[5] > 0.0
            else math.inf
        )
        if after > float(miss @ miss):
            break
        values = moved
        if np.abs(step).max() < 1e-9:
            break
    return values, float(np.sum((corners_px - _project(square, lens, values)) ** 2))


def _refined(grey: NDArray[np.uint8], corners: Points) -> Points:
    """Return corners at the crossings of lines fitted to the marker's four edges.

    OpenCV's own refinement draws corners inwards (0.2 px and more, by blur), because only
    one quadrant of a marker's corner is black; a straight edge has no such bias.
    """
    side = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).max()
    # The smaller height of the seen square: the window must not reach the marker's bits.
    height = cv2.contourArea(corners.astype(np.float32)) / float(side)
    half = int(np.clip(height / 14.0, _LEAST_WINDOW_PX, _MOST_WINDOW_PX))
    lines = [
        _edge_line(grey, start, end, half)
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    if any(line is None for line in lines):
        start = corners.astype(np.float32).reshape(-1, 1, 2)
        moved = cv2.cornerSubPix(grey, start, (half, half), (-1, -1), _REFINE)
        return np.asarray(moved, np.float64).reshape(4, 2)
    found = [line for line in lines if line is not None]
    crossings = np.array([np.cross(found[k - 1], found[k]) for k in range(4)])
    refined = np.asarray(crossings[:, :2] / crossings[:, 2:])
    is_near = np.linalg.norm(refined - corners, axis=1).max() < 2.0 * half
    return refined if is_near else corners


def _edge_line(
    grey: NDArray[np.uint8], start: Points, end: Points, half: int
) -> NDArray[np.float64] | None:
    """Return the line (a, b, c), au + bv + c = 0, of an edge; None when it is not clear."""
    along = end - start
    length = float(np.linalg.norm(along))
    normal = np.array([-along[1], along[0]]) / length
    # Corners themselves are round from blur: the middle four fifths are straight.
    shares = np.linspace(0.1, 0.9, max(8, int(length)))
    offsets = np.arange(-half - 1.0, half + 1.01, 0.5)
    places = start + shares[:, None, None] * along + offsets[None, :, None] * normal
    values = cv2.remap(grey, places.astype(np.float32), None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
    slope = np.abs(np.gradient(np.asarray(values, np.float64), axis=1))
    slope[slope < 0.3 * slope.max()] = 0.0
    weight = slope.sum(axis=1)
    if np.count_nonzero(weight) < len(shares) // 2:
        return None
    keep = weight > 0
    offset = (slope[keep] @ offsets) / weight[keep]
    points = start + shares[keep, None] * along + offset[:, None] * normal
    u, v, u0, v0 = np.asarray(
        cv2.fitLine(points.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01), np.float64
    ).ravel()
    return np.array([-v, u, v * u0 - u * v0])
