from __future__ import annotations

import struct

import numpy as np
import pytest

from cell.devices.camera import Frame
from sessions.errors import SessionsError
from sessions.views import ENCODERS, ViewEncoder, decode_mif, decode_picture, encode
from tests.sessions.fakes import SETTINGS, pixels_of


def frame_of(pixels: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> Frame:
    return Frame(camera="top", number=1, time_s=0.0, pixels=pixels, settings=SETTINGS)


TWO_BY_ONE = np.array([[[1, 2, 3], [250, 251, 252]]], np.uint8)


@pytest.mark.parametrize(
    ("mime", "data"),
    [
        ("image/mif", b"MIF\x01\x02\x00\x01\x00\x01\x02\x03\xfa\xfb\xfc"),
        ("image/ppm", b"P6\n2 1\n255\n\x01\x02\x03\xfa\xfb\xfc"),
        ("image/pgm", b"P5\n2 1\n255\n\x02\xfb"),
    ],
)
def test_raw_formats_byte_by_byte(mime: str, data: bytes) -> None:
    assert bytes(encode(TWO_BY_ONE, mime)) == data


@pytest.mark.parametrize(("width_px", "height_px"), [(640, 480), (1280, 960)])
def test_mif_has_the_size_of_the_protocol(width_px: int, height_px: int) -> None:
    data = encode(pixels_of(width_px, height_px), "image/mif")

    assert len(data) == 8 + 3 * width_px * height_px
    assert bytes(data[:8]) == b"MIF\x01" + struct.pack("<HH", width_px, height_px)
    np.testing.assert_array_equal(decode_mif(data), pixels_of(width_px, height_px))


@pytest.mark.parametrize("mime", ["image/ppm", "image/png"])
def test_lossless_formats_read_back(mime: str) -> None:
    pixels = pixels_of(640, 480)

    np.testing.assert_array_equal(decode_picture(encode(pixels, mime)), pixels)


def test_jpeg_keeps_the_colours_apart() -> None:
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:, :, 0] = 220

    back = decode_picture(encode(pixels, "image/jpeg"))

    assert np.abs(back.astype(int) - pixels).max() < 8


def test_a_picture_that_is_not_contiguous_is_encoded_as_it_looks() -> None:
    pixels = pixels_of(640, 480)[::-1, ::2]

    for mime in ("image/mif", "image/ppm", "image/pgm", "image/png"):
        assert bytes(encode(pixels, mime)) == bytes(encode(np.ascontiguousarray(pixels), mime))


def test_an_unknown_format_is_refused_with_the_known_ones() -> None:
    with pytest.raises(SessionsError, match=r"image/gif.*image/mif"):
        encode(TWO_BY_ONE, "image/gif")


@pytest.mark.parametrize("data", [b"", b"MIF\x01", b"PIF\x01\x01\x00\x01\x00abc", b"\x89PNG"])
def test_data_that_is_no_picture_is_told(data: bytes) -> None:
    with pytest.raises(SessionsError):
        decode_mif(data)
    with pytest.raises(SessionsError):
        decode_picture(data)


def test_a_truncated_mif_is_told() -> None:
    with pytest.raises(SessionsError, match="2x1 has 13 bytes"):
        decode_mif(bytes(encode(TWO_BY_ONE, "image/mif"))[:-1])


@pytest.mark.parametrize("mime", ENCODERS)
def test_a_frame_is_encoded_once_a_format_and_its_bytes_are_shared(mime: str) -> None:
    encoder, frame = ViewEncoder(), frame_of(pixels_of(640, 480))

    first = encoder.encode(frame, mime)

    assert encoder.encode(frame, mime) is first
    assert encoder.encode(frame_of(pixels_of(640, 480)), mime) is not first
    assert memoryview(first).readonly


def test_only_some_views_are_kept_and_the_oldest_goes_first() -> None:
    encoder = ViewEncoder(kept=2)
    frames = [frame_of(TWO_BY_ONE) for _ in range(3)]
    first, second, _ = [encoder.encode(frame, "image/mif") for frame in frames]

    assert encoder.encode(frames[1], "image/mif") is second
    assert encoder.encode(frames[0], "image/mif") is not first


def test_forgotten_views_are_encoded_anew() -> None:
    encoder, frame = ViewEncoder(), frame_of(TWO_BY_ONE)
    first = encoder.encode(frame, "image/mif")
    encoder.forget()

    assert encoder.encode(frame, "image/mif") is not first
