"""How the picture of a view is kept: compressed, as it was, or only its hash."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import Frame
from sessions.recording.errors import RecordingError
from sessions.recording.layout import PICTURE_HEAD

PictureStorage = Literal["jpeg", "lossless", "none"]
PictureEncoding = Literal["jpeg", "png", "none"]

_JPEG_QUALITY = 90
_ENCODINGS: dict[PictureStorage, PictureEncoding] = {
    "jpeg": "jpeg",
    "lossless": "png",
    "none": "none",
}


def encode_view(
    number: int, frame: Frame, mime: str, data: bytes | memoryview, storage: PictureStorage
) -> bytes:
    """Return the message of a view: a JSON head with the hash of `data`, and the picture.

    Args:
        number: Number of the view in its recording.
        frame: The frame that was sent.
        mime: How it was encoded for the client.
        data: The bytes that were sent.
        storage: How the recording keeps pictures.
    """
    height, width = frame.pixels.shape[:2]
    head = {
        "view": number,
        "camera": frame.camera,
        "frame": frame.number,
        "captured_ns": round(frame.time_s * 1e9),
        "width": width,
        "height": height,
        "mime": mime,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "encoding": _ENCODINGS[storage],
        "settings": asdict(frame.settings),
    }
    packed = json.dumps(head).encode("ascii")
    return PICTURE_HEAD.pack(len(packed)) + packed + _encode_pixels(frame.pixels, storage)


def decode_picture(picture: bytes) -> NDArray[np.uint8]:
    """Return the pixels of a kept picture: (height, width, 3), R G B.

    Raises:
        RecordingError: The bytes are no picture.
    """
    decoded = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR) if picture else None
    if decoded is None:
        raise RecordingError("the recording holds no picture of this view")
    return np.asarray(cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), np.uint8)


def as_png(picture: bytes) -> bytes:
    """Return a kept picture as PNG; one that is PNG already is given back as it is.

    Raises:
        RecordingError: The bytes are no picture.
    """
    if picture.startswith(b"\x89PNG"):
        return picture
    blue_first = cv2.cvtColor(decode_picture(picture), cv2.COLOR_RGB2BGR)
    is_done, encoded = cv2.imencode(".png", blue_first)
    if not is_done:
        raise RecordingError("a picture of the recording cannot be written as PNG")
    return encoded.tobytes()


def _encode_pixels(pixels: NDArray[np.uint8], storage: PictureStorage) -> bytes:
    if storage == "none":
        return b""
    blue_first = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    if storage == "jpeg":
        is_done, encoded = cv2.imencode(
            ".jpg", blue_first, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
        )
    else:
        # OpenCV's own choice of PNG filter and level is both faster and smaller on noisy
        # pictures than an explicit level 1.
        is_done, encoded = cv2.imencode(".png", blue_first)
    if not is_done:
        raise RecordingError(f"a picture of shape {pixels.shape} cannot be encoded")
    return encoded.tobytes()
