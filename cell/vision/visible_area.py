"""Where one could have seen a block, and where not."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.vision.sight import TableSight

Pixels = NDArray[np.uint8]
Points = NDArray[np.float64]

_BEYOND_MM = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class VisibleArea:
    """The part of the picture in which blocks were looked for.

    Attributes:
        mask: 255 where blocks were looked for, in half the picture's size.
        sight: What is known of the table.
        hidden_share: Share of the screen within the picture that something known hides.
    """

    mask: Pixels
    sight: TableSight
    hidden_share: float

    def sees(self, x_mm: float, y_mm: float, radius_mm: float = 24.0) -> bool:
        """Return whether a block's top face at a place in the robot frame is seen whole.

        Args:
            x_mm: Robot x of its middle.
            y_mm: Robot y of its middle.
            radius_mm: Half of the face's diagonal.
        """
        turn = 2.0 * np.pi * np.arange(12) / 12
        ring = radius_mm * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        points = np.vstack([ring, ring / 2.0, [[0.0, 0.0]]]) + (x_mm, y_mm)
        pixels = self.sight.view.to_picture(points, self.sight.top_mm)
        column, row = np.rint((pixels + 0.5) / 2.0 - 0.5).astype(int).T
        height, width = self.mask.shape
        is_in = (column >= 0) & (row >= 0) & (column < width) & (row < height)
        return bool(is_in.all() and (self.mask[row, column] > 0).all())


def visible_area(sight: TableSight, hidden: Pixels | None, shape: tuple[int, int]) -> VisibleArea:
    """Return the screen in the picture less what hides it.

    Args:
        sight: What is known of the table.
        hidden: Above 0 where something known hides the table, in the picture's full size.
        shape: Rows and columns of the half-size picture.
    """
    panel = sight.panel_mask(_BEYOND_MM, shape)
    if hidden is None or not hidden.any():
        return VisibleArea(panel, sight, 0.0)
    whole = cv2.countNonZero(panel)
    panel = panel.copy()
    cover = np.asarray(cv2.resize(hidden, shape[::-1], interpolation=cv2.INTER_AREA))
    panel[cover > 0] = 0
    share = 1.0 - cv2.countNonZero(panel) / max(1, whole)
    return VisibleArea(panel, sight, share)
