"""Picture files are read whole or refused by name, and the libraries below keep quiet."""

from __future__ import annotations

import os
from contextlib import suppress

import numpy as np
import pytest

from calibration.errors import CalibrationError
from calibration.pictures import decode_png, encode_png


def test_a_damaged_file_is_refused_with_its_name_alone(
    capfd: pytest.CaptureFixture[str],
) -> None:
    noise = np.random.default_rng(4).integers(0, 255, (60, 80, 3), np.uint8)
    png = bytearray(encode_png(noise))
    for place in range(60, 400, 7):
        png[place] ^= 0x5A
    for data in (bytes(png[:20]), b"no picture at all", b"\x89PNG\r\n\x1a\n" + b"x" * 64):
        with pytest.raises(CalibrationError, match="view 3 is no picture"):
            decode_png(data, "view 3")
    assert capfd.readouterr().err == ""
    os.write(2, b"heard again")
    assert capfd.readouterr().err == "heard again"
    # Some decoders make do with what is left.
    with suppress(CalibrationError):
        decode_png(bytes(png), "view 3")
    assert capfd.readouterr().err == ""
