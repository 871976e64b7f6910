"""Cameras kept in service: opened again when they give no picture, or the same over and over."""

from __future__ import annotations

import numpy as np

from cell.devices.camera import Camera, CameraMode, Frame
from cell.errors import CellError, DeviceError
from cell.reporting import FaultReporter

_SPARSE = 61
"""Every so many rows and columns are compared first: that tells nearly all pictures apart."""


class CameraKeeper:
    """Grabs pictures, and brings a camera back once before it counts as failed.

    Args:
        reporter: Told when a camera was brought back.
    """

    def __init__(self, reporter: FaultReporter) -> None:
        self._reporter = reporter
        self._modes: dict[str, CameraMode] = {}
        self._last: dict[str, Frame] = {}

    def forget(self) -> None:
        """Take it that all cameras were closed."""
        self._modes.clear()
        self._last.clear()

    def grab(self, camera: Camera, mode: CameraMode, *, is_fresh: bool = False) -> Frame:
        """Return a picture of the scene as it is now, opening the camera in a mode if need be.

        Args:
            camera: The camera.
            mode: Its picture size.
            is_fresh: Whether it must be a new one, even if nothing that it shows has changed.

        Raises:
            DeviceError: The camera gives none, and did not after it was opened again.
        """
        name = camera.name
        last = self._last.get(name)
        try:
            if self._modes.get(name) != mode:
                self._open(camera, mode)
                last = None
            frame = camera.grab_fresh() if is_fresh else camera.grab()
        except DeviceError as error:
            return self._grab_again(camera, mode, error.problem)
        if frame is not last:
            if last is not None and _is_same(frame, last):
                return self._grab_again(camera, mode, "gave the picture before once more")
            self._last[name] = frame
        return frame

    def _open(self, camera: Camera, mode: CameraMode) -> None:
        self._modes.pop(camera.name, None)
        camera.open(mode)
        self._modes[camera.name] = mode

    def _grab_again(self, camera: Camera, mode: CameraMode, problem: str) -> Frame:
        name = camera.name
        last = self._last.pop(name, None)
        try:
            camera.close()
            self._open(camera, mode)
            frame = camera.grab()
        except CellError:
            self._modes.pop(name, None)
            raise
        if last is not None and _is_same(frame, last):
            self._modes.pop(name, None)
            raise DeviceError(
                f"camera {name}",
                "gives the same picture over and over",
                hint="take its power away and give it back",
            )
        self._last[name] = frame
        self._reporter.recovered(f"camera {name}", f"opened again after: {problem}")
        return frame


def _is_same(frame: Frame, last: Frame) -> bool:
    """Return whether two frames have the same pixels; a sensor's noise never repeats."""
    one, other = frame.pixels, last.pixels
    if one.shape != other.shape:
        return False
    sparse = np.array_equal(one[::_SPARSE, ::_SPARSE], other[::_SPARSE, ::_SPARSE])
    return sparse and np.array_equal(one, other)
