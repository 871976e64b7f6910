from __future__ import annotations

import numpy as np
import pytest

from calibration.camera_settings.pictures import Pixels, before_and_after
from calibration.errors import CalibrationError
from calibration.record import Measurement, Sample


def test_the_kept_pictures_stand_beside_each_other() -> None:
    files = {
        "a": np.full((960, 1280, 3), 30, np.uint8),
        "b": np.full((960, 1280, 3), 160, np.uint8),
    }
    samples = (
        Sample(label="as it was", picture="a"),
        Sample(label="picture 1"),
        Sample(label="picture 2, the best", picture="b"),
    )
    found = Measurement(kind="camera-settings", subject="top", method="", samples=samples)
    picture = before_and_after(found, files.__getitem__)
    assert picture.shape == (780, 1280, 3)
    assert picture[200, 300].tolist() == [30, 30, 30]
    assert picture[200, 900].tolist() == [160, 160, 160]


def test_a_record_without_pictures_says_so() -> None:
    empty = Measurement(kind="camera-settings", subject="top", method="")
    kept: dict[str, Pixels] = {}
    with pytest.raises(CalibrationError, match="no picture"):
        before_and_after(empty, kept.__getitem__)
