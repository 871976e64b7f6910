"""A twin's cameras and screen for tests of the screen as target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calibration.screen.decode import ScreenMap, both_axes, read_axis
from calibration.screen.patterns import AXES, STEPS, Panel
from cell.profile import Profile
from cell.twin.cameras import TwinCamera
from cell.twin.cameras.light import panel_axes
from tests.cell.twin.cameras.stage import PROFILE
from tests.cell.twin.cameras.test_patterns import PatternStage

PANEL = Panel(width_px=PROFILE.display.width_px, height_px=PROFILE.display.height_px)


class Watched:
    """A camera of the twin over a screen that shows whatever it is told."""

    def __init__(self, stage: PatternStage, camera: TwinCamera) -> None:
        self.stage = stage
        self.camera = camera
        self._count = 0

    def shot(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Show a picture and look at it."""
        self._count += 1
        self.stage.show_pixels(f"pattern {self._count}", pixels)
        return self.camera.grab().pixels

    def map(self, panel: Panel = PANEL) -> ScreenMap:
        """Show all patterns and decode them."""
        readings = [
            read_axis(
                [self.shot(panel.sine(axis, step)) for step in range(STEPS)],
                [self.shot(panel.code(axis, bit)) for bit in range(panel.bits(axis))],
            )
            for axis in AXES
        ]
        return both_axes(readings[0], readings[1], panel.width_px, panel.height_px)


def true_places_mm(truth: Profile, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return robot x, y (n, 2) where columns and rows (n, 2) of the screen really lie."""
    display = truth.display
    right, down = panel_axes(display)
    corner = np.array([display.corner_x_mm, display.corner_y_mm])
    along = (places[:, :1] + 0.5) * right + (places[:, 1:] + 0.5) * down
    return np.asarray(corner + along * display.pixel_mm)
