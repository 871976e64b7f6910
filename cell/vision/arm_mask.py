"""What the arm hides of the table, as its kinematics and a camera's view tell.

Each link is a round bar between two points of the chain, with the radius of the arm's body;
the hand hangs from the last one. The picture of a bar is the hull of the pictures of the
circles around its ends. Radii are generous: what may be hidden counts as hidden.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.geometry import CameraView

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_CORNERS = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
_CORNERS = _CORNERS[np.abs(_CORNERS).sum(axis=1) > 0]
_BALL = _CORNERS / np.linalg.norm(_CORNERS, axis=1, keepdims=True)
_BULGE = 1.13
"""A hull of 26 points on a ball lies at most this far inside of it."""

_PIECES = 6
_NEAR_MM = 60.0
_PICTURE_PX = (960, 1280)


class LinkChain(Protocol):
    """What is needed of any arm's kinematics."""

    def link_points_mm(self, values: tuple[float, ...]) -> tuple[tuple[float, float, float], ...]:
        """Return points along the arm, base first, tool point last; links run between them."""


@dataclass(frozen=True, slots=True)
class ArmBulk:
    """How thick the arm is.

    Attributes:
        radius_mm: Of the links; covers and cables included.
        hand_radius_mm: Of the last link, flange to tool point: half the hand's width with
            the fingers open.
        margin_mm: Added to all: what the joints' angles and the view may be off.
    """

    radius_mm: float = 105.0
    hand_radius_mm: float = 80.0
    margin_mm: float = 15.0


def arm_mask(
    arm: LinkChain,
    joints: Sequence[float],
    view: CameraView,
    bulk: ArmBulk | None = None,
) -> Pixels:
    """Return where the arm may hide the table, 255 there, (960, 1280).

    Args:
        arm: Its kinematics.
        joints: Its joints when the picture was taken.
        view: The camera, its lens and place known.
        bulk: How thick the arm is.
    """
    bulk = bulk or ArmBulk()
    mask = np.zeros(_PICTURE_PX, np.uint8)
    points = [np.array(point) for point in arm.link_points_mm(tuple(joints))]
    last = len(points) - 2
    for index, (start, end) in enumerate(itertools.pairwise(points)):
        radius = bulk.hand_radius_mm if index == last else bulk.radius_mm
        reach = (radius + bulk.margin_mm) * _BULGE
        # In pieces, so that a bar that passes the camera loses only what is behind it.
        cuts = np.linspace(0.0, 1.0, _PIECES + 1)
        for low, high in itertools.pairwise(cuts):
            ends = (start + low * (end - start), start + high * (end - start))
            _fill(mask, np.vstack([one + reach * _BALL for one in ends]), view)
    return mask


def _fill(mask: Pixels, points_mm: Points, view: CameraView) -> None:
    """Fill the picture of the hull of points."""
    placed = view.robot_from_camera
    depth = (points_mm - placed.translation_mm) @ placed.rotation[:, 2]
    if (depth < _NEAR_MM).any():
        return
    directions = (points_mm - placed.translation_mm) @ placed.rotation
    flat = directions[:, :2] / directions[:, 2:]
    # Far outside the picture Brown's polynomial folds back: hold such points at its rim.
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = flat * np.minimum(1.0, _widest(view) / np.maximum(size, 1e-9))
    pixels = view.lens.to_picture(flat)
    hull = cv2.convexHull(np.rint(pixels).astype(np.int32))
    cv2.fillConvexPoly(mask, hull, 255)


def _widest(view: CameraView) -> float:
    """Return a direction's tangent that is safely outside of the picture."""
    lens = view.lens
    corners = np.array(
        [(0.0, 0.0), (lens.width_px, 0.0), (0.0, lens.height_px), (lens.width_px, lens.height_px)]
    )
    return 1.6 * float(np.linalg.norm(lens.to_directions(corners), axis=1).max())
