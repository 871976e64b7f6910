"""Pictures of a calibration: their digests, and PNG files of them."""

from __future__ import annotations

import hashlib
import os
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.errors import CalibrationError
from calibration.requests import Picture
from cell.devices.camera import CameraSettings, Frame

Pixels = NDArray[np.uint8]

_DECODING: Final = Lock()
"""Two at once would leave stderr silent."""


def digest_of(pixels: Pixels) -> str:
    """Return the SHA-256 of a picture's shape (three little-endian uint32) and pixels."""
    height, width, channels = pixels.shape
    head = struct.pack("<III", height, width, channels)
    return hashlib.sha256(head + np.ascontiguousarray(pixels).tobytes()).hexdigest()


def picture_of(camera: str, pixels: Pixels, settings: CameraSettings | None = None) -> Picture:
    """Return a picture with its digest.

    Args:
        camera: Name of the camera, or the file it was read from.
        pixels: Shape (height, width, 3), uint8, R G B.
        settings: The settings it was taken with.
    """
    return Picture(camera=camera, pixels=pixels, digest=digest_of(pixels), settings=settings)


def picture_of_frame(frame: Frame) -> Picture:
    """Return a camera's frame as a picture."""
    return picture_of(frame.camera, frame.pixels, frame.settings)


def read_picture_file(path: Path) -> Picture:
    """Read a picture from a file of any usual format.

    Raises:
        CalibrationError: There is no such file, or it is no picture.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CalibrationError(
            f"the picture {path} cannot be read: {error.strerror or error}"
        ) from error
    return picture_of(str(path), decode_png(data, str(path)))


def encode_png(pixels: Pixels) -> bytes:
    """Return a picture (height, width, 3), R G B, as a PNG file."""
    is_done, data = cv2.imencode(".png", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR))
    if not is_done:
        raise CalibrationError("a picture cannot be encoded as PNG")
    return data.tobytes()


@contextmanager
def _quiet_decoders() -> Iterator[None]:
    """Have the libraries below not write to stderr what is told with the file's name anyway.

    They write to the file descriptor itself.
    """
    with _DECODING:
        try:
            before = os.dup(2)
        except OSError:
            # Nobody hears it: stderr is closed.
            yield
            return
        sys.stderr.flush()
        try:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, 2)
            os.close(nowhere)
            yield
        finally:
            os.dup2(before, 2)
            os.close(before)


def decode_png(data: bytes, name: str) -> Pixels:
    """Return the pixels (height, width, 3), R G B, of a picture file.

    Args:
        data: The file.
        name: What it is called in messages.

    Raises:
        CalibrationError: It is no picture.
    """
    buffer = np.frombuffer(data, np.uint8)
    with _quiet_decoders():
        found = cv2.imdecode(buffer, cv2.IMREAD_COLOR) if len(buffer) else None
    if found is None:
        raise CalibrationError(f"{name} is no picture that can be read")
    return np.asarray(cv2.cvtColor(found, cv2.COLOR_BGR2RGB), np.uint8)
