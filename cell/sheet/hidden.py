"""What the fingers hide from the camera that hangs beside them.

Nobody tells a picture how far the fingers are open, so all that they may reach counts as
hidden; a look with the hand turned sees what lies there.
"""

from __future__ import annotations

import itertools

import cv2
import numpy as np

from cell.geometry import LensModel, Transform
from cell.profile import Profile
from cell.sheet.finding import Pixels

_ROOT_SHARE = 0.45
"""Where along the tool the fingers begin; the gripper's body above is out of sight."""
_MARGIN_MM = 6.0
_PIECES = 6
_NEAR_MM = 20.0


def fingers_mask(profile: Profile, lens: LensModel, flange_from_camera: Transform) -> Pixels:
    """Return where the fingers may hide the table, 255 there, (960, 1280).

    Args:
        profile: The cell's profile: sizes of the fingers, and the tool.
        lens: The camera's lens.
        flange_from_camera: Where it hangs on the flange.
    """
    gripper = profile.gripper
    x, y, length = profile.arm.tool_mm
    wide = gripper.finger_width_mm / 2 + _MARGIN_MM
    across = gripper.stroke_mm / 2 + gripper.finger_thickness_mm + _MARGIN_MM
    end = length + gripper.tip_below_tool_mm
    mask = np.zeros((lens.height_px, lens.width_px), np.uint8)
    corners = lens.to_directions(
        np.array([(0.0, 0.0), (lens.width_px, 0.0), (0.0, lens.height_px)])
    )
    widest = 1.4 * float(np.linalg.norm(corners, axis=1).max())
    for low, high in itertools.pairwise(np.linspace(_ROOT_SHARE * length, end, _PIECES + 1)):
        box = np.array(
            list(itertools.product((x - wide, x + wide), (y - across, y + across), (low, high)))
        )
        seen = flange_from_camera.inverse().apply(box)
        if (seen[:, 2] < _NEAR_MM).any():
            continue
        flat = seen[:, :2] / seen[:, 2:]
        # Far outside the picture Brown's polynomial folds back: hold such points at its rim.
        far = np.linalg.norm(flat, axis=1, keepdims=True)
        flat = flat * np.minimum(1.0, widest / np.maximum(far, 1e-9))
        hull = cv2.convexHull(np.rint(lens.to_picture(flat)).astype(np.int32))
        cv2.fillConvexPoly(mask, hull, 255)
    return mask
