"""From frames to the bytes of a view, in every format of the protocol."""

from __future__ import annotations

import struct
import threading
from collections import OrderedDict
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import Frame
from sessions.errors import SessionsError

JPEG_QUALITY = 90
KEPT_VIEWS = 12
"""How many encoded views are kept: three cameras, with one before and some formats to spare."""

Encoded = bytes | memoryview
_Pixels = NDArray[np.uint8]


def encode_mif(pixels: _Pixels) -> memoryview:
    """Return a picture in the MASH image format, version 1.

    Eight bytes (`MIF`, 1, width and height as little-endian 16-bit numbers), then
    R G B a pixel, row by row from the top (appendix B.2 of the protocol).

    Args:
        pixels: Shape (height, width, 3), uint8, R G B.
    """
    return _with_header(b"MIF\x01" + struct.pack("<HH", pixels.shape[1], pixels.shape[0]), pixels)


def decode_mif(data: Encoded | bytearray) -> _Pixels:
    """Return the pixels of a picture in the MASH image format; they share its memory.

    Raises:
        SessionsError: The data is not of that format.
    """
    if len(data) < 8 or bytes(data[:4]) != b"MIF\x01":
        raise SessionsError("the data does not begin like a MIF picture")
    width, height = struct.unpack("<HH", data[4:8])
    if len(data) != 8 + 3 * width * height:
        raise SessionsError(f"a MIF picture of {width}x{height} has {len(data)} bytes")
    return np.frombuffer(data, np.uint8, offset=8).reshape(height, width, 3)


def decode_picture(data: Encoded | bytearray) -> _Pixels:
    """Return the pixels of a PPM, PGM, PNG or JPEG picture.

    Returns:
        Shape (height, width, 3), uint8, R G B; grey pictures have three equal channels.

    Raises:
        SessionsError: The data is no such picture.
    """
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
    if pixels is None:
        raise SessionsError("the data is no picture that can be read")
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)


def encode_ppm(pixels: _Pixels) -> memoryview:
    """Return a picture as a binary Portable Pixel Map (P6)."""
    return _with_header(b"P6\n%d %d\n255\n" % (pixels.shape[1], pixels.shape[0]), pixels)


def encode_pgm(pixels: _Pixels) -> memoryview:
    """Return a picture as a binary Portable Grey Map (P5), with the weights of ITU-R BT.601."""
    grey = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8)
    return _with_header(b"P5\n%d %d\n255\n" % (pixels.shape[1], pixels.shape[0]), grey)


def encode_png(pixels: _Pixels) -> bytes:
    """Return a picture as PNG."""
    return _opencv(pixels, ".png", [])


def encode_jpeg(pixels: _Pixels) -> bytes:
    """Return a picture as JPEG."""
    return _opencv(pixels, ".jpg", [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])


ENCODERS: dict[str, Callable[[_Pixels], Encoded]] = {
    "image/mif": encode_mif,
    "image/ppm": encode_ppm,
    "image/pgm": encode_pgm,
    "image/png": encode_png,
    "image/jpeg": encode_jpeg,
}
"""Every format of the protocol by its MIME type."""


def encode(pixels: _Pixels, mime: str) -> Encoded:
    """Return a picture in a format of the protocol.

    Args:
        pixels: Shape (height, width, 3), uint8, R G B.
        mime: One of `ENCODERS`.

    Raises:
        SessionsError: There is no such format.
    """
    if mime not in ENCODERS:
        raise SessionsError(f"there is no view format {mime!r}; there are {', '.join(ENCODERS)}")
    return ENCODERS[mime](pixels)


class ViewEncoder:
    """Encodes each frame once a format: the bytes of an unchanged scene are shared."""

    def __init__(self, kept: int = KEPT_VIEWS) -> None:
        self._kept = kept
        self._views: OrderedDict[tuple[int, str], tuple[Frame, Encoded]] = OrderedDict()
        self._lock = threading.Lock()

    def encode(self, frame: Frame, mime: str) -> Encoded:
        """Return a frame in a format; the bytes are shared and never change.

        Raises:
            SessionsError: There is no such format.
        """
        key = (id(frame), mime)
        with self._lock:
            kept = self._views.get(key)
            if kept is not None:
                self._views.move_to_end(key)
                return kept[1]
        encoded = encode(frame.pixels, mime)
        with self._lock:
            # The frame is kept with its bytes, so that its id cannot come again meanwhile.
            self._views[key] = (frame, encoded)
            if len(self._views) > self._kept:
                self._views.popitem(last=False)
        return encoded

    def forget(self) -> None:
        """Let all kept views go."""
        with self._lock:
            self._views.clear()


def _with_header(header: bytes, values: _Pixels) -> memoryview:
    buffer = np.empty(len(header) + values.size, np.uint8)
    buffer[: len(header)] = np.frombuffer(header, np.uint8)
    np.copyto(buffer[len(header) :].reshape(values.shape), values)
    return buffer.data.toreadonly()


def _opencv(pixels: _Pixels, extension: str, parameters: list[int]) -> bytes:
    is_encoded, data = cv2.imencode(extension, cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), parameters)
    if not is_encoded:
        raise SessionsError(f"a picture of shape {pixels.shape} cannot be encoded as {extension}")
    return bytes(data)
