from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cell.devices.camera import CameraSettings
from cell.twin.cameras.sensor import Exposure, SensorNoise

DEFAULTS = CameraSettings(
    shutter_ms=16.0, gain_db=-4.0, white_balance_red=600, white_balance_blue=800
)
GREY = np.full((4, 5, 3), 100, np.uint8)


def levels(light: tuple[float, float, float], settings: CameraSettings) -> list[int]:
    exposure = Exposure(settings, DEFAULTS)
    values: list[int] = exposure.levels(exposure.linear(np.array([light])))[0].tolist()
    return values


def test_default_settings_leave_nominal_levels_as_they_are() -> None:
    assert levels((12.0, 100.0, 250.0), DEFAULTS) == [12, 100, 250]


def test_doubled_shutter_doubles_the_light_until_it_clips() -> None:
    assert levels((30.0, 100.0, 200.0), replace(DEFAULTS, shutter_ms=32.0)) == [60, 200, 255]


def test_halved_shutter_brings_clipped_light_back() -> None:
    assert levels((400.0, 300.0, 500.0), DEFAULTS) == [255, 255, 255]
    assert levels((400.0, 300.0, 500.0), replace(DEFAULTS, shutter_ms=8.0)) == [200, 150, 250]


def test_twenty_decibels_are_ten_times_the_light() -> None:
    assert levels((3.0, 10.0, 20.0), replace(DEFAULTS, gain_db=16.0)) == [30, 100, 200]


def test_white_balance_scales_red_and_blue_alone() -> None:
    settings = replace(DEFAULTS, white_balance_red=900, white_balance_blue=400)
    assert levels((100.0, 100.0, 100.0), settings) == [150, 100, 50]


def test_gamma_bends_the_middle_and_keeps_the_ends() -> None:
    bent = levels((0.0, 127.5, 255.0), replace(DEFAULTS, gamma=2.0))
    assert bent == [0, 180, 255]


def test_brightness_shifts_by_its_share_of_full_scale() -> None:
    assert levels((0.0, 100.0, 250.0), replace(DEFAULTS, brightness_percent=10.0)) == [26, 126, 255]


def test_no_saturation_gives_grey_of_the_same_luma() -> None:
    red, green, blue = levels((200.0, 100.0, 50.0), replace(DEFAULTS, saturation_percent=0.0))
    assert red == green == blue == round(0.299 * 200 + 0.587 * 100 + 0.114 * 50)


def test_full_turn_of_hue_changes_nothing_and_a_third_swaps_channels() -> None:
    assert levels((200.0, 100.0, 50.0), replace(DEFAULTS, hue_deg=360.0)) == [200, 100, 50]
    assert sorted(levels((200.0, 100.0, 50.0), replace(DEFAULTS, hue_deg=120.0))) == [50, 100, 200]


def test_noise_has_the_profile_s_deviation_and_no_bias() -> None:
    picture = np.full((960, 1280, 3), 100, np.uint8)
    for deviation in (1.5, 2.5, 6.0):
        offset = SensorNoise(4, deviation).apply(picture, 1).astype(float) - 100.0
        assert offset.std() == pytest.approx(deviation, rel=0.02)
        assert abs(offset.mean()) < 0.02


def test_noise_of_neighbouring_pixels_and_frames_is_unrelated() -> None:
    picture = np.full((960, 1280, 3), 100, np.uint8)
    noise = SensorNoise(4, 2.0)
    first = noise.apply(picture, 1).astype(float) - 100.0
    second = noise.apply(picture, 2).astype(float) - 100.0
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.01
    beside = np.corrcoef(first[:, :-1].ravel(), first[:, 1:].ravel())[0, 1]
    assert abs(beside) < 0.01


def test_noise_depends_on_seed_and_frame_number_alone() -> None:
    again = SensorNoise(4, 2.0).apply(GREY, 7)
    np.testing.assert_array_equal(SensorNoise(4, 2.0).apply(GREY, 7), again)
    assert (SensorNoise(5, 2.0).apply(GREY, 7) != again).any()
    assert (SensorNoise(4, 2.0).apply(GREY, 8) != again).any()
