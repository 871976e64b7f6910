from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cell.devices.camera_features import FeatureError, FeatureName
from cell.errors import DeviceError, DeviceTimeout
from tests.cell.twin.cameras.stage import FULL, PROFILE, Stage, block

NAMES = ("top", "oblique", "gripper")


@pytest.mark.parametrize("name", NAMES)
def test_settings_of_the_profile_are_in_force_and_read_back_exactly(name: str) -> None:
    camera = Stage().camera(name)
    assert camera.settings() == PROFILE.cameras[name].settings
    assert camera.configure(PROFILE.cameras[name].settings).not_taken == ()
    assert all(f.control != "auto" for f in camera.features() if f.name != "frame_rate")


def test_configure_tries_every_feature_and_names_those_that_did_not_take() -> None:
    camera = Stage().camera("top")
    before = camera.settings()
    report = camera.configure(replace(before, brightness_percent=50.0, gain_db=99.0, hue_deg=5.0))
    assert [item.feature for item in report.not_taken] == ["brightness", "gain"]
    assert camera.settings() == replace(before, hue_deg=5.0)
    with pytest.raises(FeatureError, match="gain: asked 99 dB, allowed -6 to 24 dB"):
        report.require()


def test_settings_change_the_picture_by_single_features_too() -> None:
    camera = Stage().camera("top")
    before = camera.grab()
    camera.set_absolute("shutter", 8.0)
    after = camera.grab()
    assert after.settings.shutter_ms == 8.0
    assert after.pixels.mean() < 0.7 * before.pixels.mean()


def test_fresh_pictures_differ_by_noise_and_count_on() -> None:
    camera = Stage().camera("top")
    first, second = camera.grab_fresh(), camera.grab_fresh()
    assert (first.number, second.number) == (1, 2)
    assert not np.array_equal(first.pixels, second.pixels)
    assert camera.grab() is second


def test_frozen_camera_gives_old_pixels_under_new_numbers_whatever_happens() -> None:
    stage = Stage()
    camera = stage.camera("top")
    before = camera.grab()
    camera.freeze()
    stage.put(block("cube", "red", 600, -150))
    after = camera.grab()
    assert after.number == before.number + 1
    assert np.array_equal(after.pixels, before.pixels)
    camera.freeze(False)
    assert not np.array_equal(camera.grab().pixels, before.pixels)


def test_covered_lens_is_dark_with_noise() -> None:
    camera = Stage().show("white").camera("top")
    camera.cover_lens()
    pixels = camera.grab().pixels
    assert pixels.mean() < 3
    assert pixels.std() > 0.3
    camera.cover_lens(False)
    assert camera.grab().pixels.mean() > 50


def test_knocked_camera_sees_everything_moved() -> None:
    camera = Stage().show("forest").camera("top")
    before = camera.grab().pixels.astype(int)
    camera.knock(20.0, -10.0)
    after = camera.grab().pixels.astype(int)
    assert np.abs(after[200:700, 320:920] - before[210:710, 300:900]).mean() < 4
    camera.knock(0.0, 0.0)
    assert np.abs(camera.grab().pixels.astype(int) - before).mean() < 3


def test_automatic_white_balance_gives_false_colours() -> None:
    camera = Stage().show("forest").camera("top")
    before = camera.grab().pixels.mean(axis=(0, 1))
    camera.leave_auto("white_balance_red")
    for _ in range(12):
        after = camera.grab().pixels.mean(axis=(0, 1))
    assert np.ptp(before) > 10
    assert np.ptp(after) < 5
    assert camera.settings().white_balance_red != PROFILE.cameras["top"].settings.white_balance_red


@pytest.mark.parametrize("name", ["shutter", "gain"])
def test_automatic_exposure_settles_at_the_target(name: FeatureName) -> None:
    camera = Stage().show("forest").camera("top")
    camera.set_absolute("exposure", 0.8)
    camera.leave_auto(name)
    for _ in range(20):
        mean = camera.grab().pixels.mean()
    assert mean == pytest.approx(255 * 2 ** (0.8 - 2.4), rel=0.08)
    settled = camera.grab()
    assert camera.grab() is settled


def test_feature_without_automatic_mode_cannot_be_left_so() -> None:
    with pytest.raises(ValueError, match="no automatic pan"):
        Stage().camera("top").leave_auto("pan")


def test_silent_camera_times_out_on_the_cell_s_clock() -> None:
    stage = Stage()
    camera = stage.camera("top")
    camera.fall_silent()
    with pytest.raises(DeviceTimeout, match="within 2 s"):
        camera.grab()
    assert stage.clock.now_s() == PROFILE.cameras["top"].timeout_s
    camera.fall_silent(False)
    assert camera.grab().number == 1


def test_half_a_frame_is_an_error_and_the_next_one_is_whole() -> None:
    camera = Stage().camera("top")
    camera.half_frame()
    with pytest.raises(DeviceError, match="1843200 of 3686400 bytes"):
        camera.grab()
    assert camera.grab().pixels.shape == (960, 1280, 3)


def test_pulled_cable_stops_everything_and_opening_again_restores_the_settings() -> None:
    camera = Stage().camera("top")
    wanted = replace(camera.settings(), gain_db=3.0)
    camera.configure(wanted).require()
    camera.pull_cable()
    for job in (camera.grab, camera.features, lambda: camera.identity, lambda: camera.open(FULL)):
        with pytest.raises(DeviceError, match="not on the bus"):
            job()
    camera.plug_in()
    with pytest.raises(DeviceError, match="not open"):
        camera.grab()
    assert {f.name for f in camera.features() if f.control == "auto"} >= {"shutter", "gain"}
    camera.open(FULL)
    assert camera.grab().settings == wanted


def test_swapped_cables_are_told_by_the_guid() -> None:
    stage = Stage().show("water")
    top, oblique = stage.camera("top"), stage.camera("oblique")
    top.swap_cables(oblique)
    assert top.identity.guid == PROFILE.cameras["oblique"].guid
    with pytest.raises(DeviceError, match=r"but 00B09D01009A7C41 \(oblique\) answers"):
        top.open(FULL)
    top.swap_cables(oblique)
    assert top.open(FULL).endswith(PROFILE.cameras["top"].guid)


def test_swapped_places_keep_the_guid_and_show_the_other_scene() -> None:
    stage = Stage().show("water")
    top, oblique = stage.camera("top"), stage.camera("oblique")
    expected = oblique.grab().pixels.astype(int)
    top.swap_places(oblique)
    assert top.open(FULL).endswith(PROFILE.cameras["top"].guid)
    assert np.abs(top.grab().pixels.astype(int) - expected).mean() < 6


def test_mending_undoes_every_fault() -> None:
    camera = Stage().camera("top")
    before = camera.grab().pixels.astype(int)
    camera.cover_lens()
    camera.defocus(4.0)
    camera.knock(9.0, 9.0)
    camera.fall_silent()
    camera.half_frame(3)
    camera.mend()
    assert np.abs(camera.grab().pixels.astype(int) - before).mean() < 3
