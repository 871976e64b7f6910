"""What the driver needs of OpenCV's capture, and the captures that there are.

A small facade, so that everything above it can be tried without a camera.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.errors import DeviceError

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")


class Capture(Protocol):
    """A source of pictures with numbered properties, as OpenCV's `VideoCapture`."""

    def grab(self) -> bool:
        """Take the next picture; False if there is none."""

    def retrieve(self) -> NDArray[np.uint8] | None:
        """Return the picture taken, (height, width, 3) B G R or (height, width) grey."""

    def get(self, prop: int) -> float:
        """Return a property; what is unknown is -1 or 0, as the backend has it."""

    def set(self, prop: int, value: float) -> bool:
        """Set a property; return whether the backend says that it did."""

    def release(self) -> None:
        """Give the source back."""


class VideoCapture:
    """OpenCV's own capture."""

    def __init__(self, camera: str, source: int | str, backend: int) -> None:
        """Open a source.

        Args:
            camera: Name of the camera in the profile, for messages.
            source: A device's index, a file, or a URL.
            backend: One of OpenCV's `CAP_` numbers.

        Raises:
            DeviceError: It does not open.
        """
        try:
            self._capture = cv2.VideoCapture(source, backend)
        except cv2.error as error:
            raise DeviceError(f"camera {camera}", f"OpenCV failed: {error}") from error
        if not self._capture.isOpened():
            self._capture.release()
            raise DeviceError(
                f"camera {camera}",
                f"cannot open {source!r} through {cv2.videoio_registry.getBackendName(backend)}",
                hint="check that it exists, that no other program has it, and that this build "
                "of OpenCV has the backend",
            )

    def grab(self) -> bool:
        """Take the next picture."""
        return bool(self._capture.grab())

    def retrieve(self) -> NDArray[np.uint8] | None:
        """Return the picture taken."""
        is_there, picture = self._capture.retrieve()
        return np.asarray(picture, np.uint8) if is_there else None

    def get(self, prop: int) -> float:
        """Return a property."""
        return float(self._capture.get(prop))

    def set(self, prop: int, value: float) -> bool:
        """Set a property."""
        return bool(self._capture.set(prop, value))

    def release(self) -> None:
        """Give the source back."""
        self._capture.release()


class FolderCapture:
    """The pictures of a folder in the order of their names, once."""

    def __init__(self, camera: str, folder: Path) -> None:
        """List a folder.

        Args:
            camera: Name of the camera in the profile, for messages.
            folder: Where the pictures lie.

        Raises:
            DeviceError: There is no such folder, or no picture in it.
        """
        self._camera = camera
        if not folder.is_dir():
            raise DeviceError(f"camera {camera}", f"there is no folder {folder}")
        self._paths = sorted(p for p in folder.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES)
        if not self._paths:
            kinds = ", ".join(PICTURE_SUFFIXES)
            raise DeviceError(f"camera {camera}", f"no pictures ({kinds}) in the folder {folder}")
        self._next = 0

    def grab(self) -> bool:
        """Go to the next file; False after the last."""
        self._next += 1
        return self._next <= len(self._paths)

    def retrieve(self) -> NDArray[np.uint8] | None:
        """Return the picture of the file, None if it cannot be read as one."""
        picture = cv2.imread(str(self._paths[self._next - 1]), cv2.IMREAD_COLOR)
        return None if picture is None else np.asarray(picture, np.uint8)

    def get(self, prop: int) -> float:
        """Return -1: files have no properties."""
        return -1.0

    def set(self, prop: int, value: float) -> bool:
        """Return False: files have no properties."""
        return False

    def release(self) -> None:
        """Keep nothing open."""
