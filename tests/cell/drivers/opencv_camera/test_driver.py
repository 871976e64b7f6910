from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest

from cell.clock import SimulatedClock
from cell.devices.camera import MODES, Camera
from cell.devices.camera_features import CameraIdentity, FeatureError, FeatureName
from cell.drivers.opencv_camera.driver import OpencvCamera
from cell.drivers.opencv_camera.properties import DC1394
from cell.drivers.opencv_camera.sources import Source, file_source, stream_source
from cell.errors import DeviceError, DeviceTimeout
from cell.profile import load_profile
from tests.cell.drivers.opencv_camera.fake_capture import FakeDc1394

SETTINGS = load_profile("mash").cameras["top"].settings
SMALL, FULL = MODES[0], MODES[3]


@contextmanager
def camera_on(
    capture: FakeDc1394,
    raw: dict[FeatureName, int] | None = None,
    timeout_s: float = 5.0,
    is_live: bool = True,
) -> Iterator[OpencvCamera]:
    source = Source(
        open=lambda: (CameraIdentity(model="Flea2", guid=f"{capture.guid:016X}"), capture),
        properties=DC1394,
        sets_height=False,
        is_live=is_live,
    )
    camera = OpencvCamera(
        "top", source, SimulatedClock(7.0), settings=SETTINGS, raw=raw, timeout_s=timeout_s
    )
    try:
        camera.open(SMALL)
        yield camera
    finally:
        capture.gate.release(1000)
        camera.close()


@contextmanager
def file_camera(place: Path) -> Iterator[OpencvCamera]:
    camera = OpencvCamera(
        "top", file_source("top", str(place)), SimulatedClock(), settings=SETTINGS, timeout_s=20.0
    )
    try:
        yield camera
    finally:
        camera.close()


def test_camera_fits_the_protocol_and_names_itself() -> None:
    with camera_on(FakeDc1394()) as opened:
        camera: Camera = opened
        assert str(camera.identity) == "Flea2 00B09D01009A7C42"


def test_picture_is_red_green_blue_read_only_and_timed_at_capture() -> None:
    with camera_on(FakeDc1394()) as camera:
        frame = camera.grab()
    assert frame.pixels.shape == (480, 640, 3)
    assert frame.pixels.dtype == np.uint8
    assert not frame.pixels.flags.writeable
    assert frame.pixels[0, 0].tolist() == [frame.number % 256, 20, 10]
    assert frame.time_s == 7.0


def test_every_grab_is_a_later_picture() -> None:
    with camera_on(FakeDc1394()) as camera:
        numbers = [camera.grab().number for _ in range(5)]
    assert numbers == sorted(set(numbers))


def test_silent_camera_is_a_timeout_and_closing_ends_the_thread() -> None:
    capture = FakeDc1394()
    capture.is_paced = True
    with camera_on(capture, timeout_s=0.01) as camera, pytest.raises(DeviceTimeout, match="0.01 s"):
        camera.grab()
    assert capture.is_released


def test_camera_that_goes_away_is_an_error_that_says_so() -> None:
    capture = FakeDc1394()
    capture.pictures_left = 0
    with camera_on(capture) as camera, pytest.raises(DeviceError, match="the camera is gone"):
        camera.grab()


def test_torn_picture_is_an_error_and_the_next_one_is_whole() -> None:
    capture = FakeDc1394()
    capture.torn = {1}
    with camera_on(capture, is_live=False) as camera:
        with pytest.raises(DeviceError, match="picture 1 came torn"):
            camera.grab()
        assert camera.grab().number == 2


def test_wrong_picture_size_is_an_error_not_a_picture() -> None:
    capture = FakeDc1394()
    with camera_on(capture, is_live=False) as camera:
        capture.size = (320, 240)
        with pytest.raises(DeviceError, match="320x240 pixels instead of 640x480"):
            camera.grab()


def test_ranges_are_read_from_the_device_and_values_kept() -> None:
    capture = FakeDc1394()
    with camera_on(capture) as camera:
        by_name = {feature.name: feature for feature in camera.features()}
    assert by_name["gain"].raw_range == (16, 683)
    assert by_name["gain"].raw == 68
    assert by_name["exposure"].raw_range == (1, 1023)
    assert by_name["gamma"].raw_range == (512, 4095)
    assert by_name["white_balance_red"].raw_range is None
    assert by_name["white_balance_red"].raw == 500
    assert not {"pan", "tilt", "hue"} & set(by_name)
    assert all(feature.absolute_range is None for feature in by_name.values())


def test_raw_value_is_set_and_read_back() -> None:
    with camera_on(FakeDc1394()) as camera:
        assert camera.set_raw("shutter", 123).raw == 123
        assert camera.set_raw("white_balance_blue", 839).raw == 839
        assert camera.settings().white_balance_blue == 839


@pytest.mark.parametrize("value", [684, 15, -2])
def test_raw_value_beyond_the_range_is_refused_with_what_is_allowed(value: int) -> None:
    with camera_on(FakeDc1394()) as camera:
        with pytest.raises(FeatureError, match=f"asked {value}, allowed 16 to 683") as caught:
            camera.set_raw("gain", value)
        assert caught.value.not_taken[0].read_back == "68"


def test_value_that_does_not_stick_is_an_error() -> None:
    capture = FakeDc1394()
    with camera_on(capture) as camera:
        capture.stuck = {cv2.CAP_PROP_GAIN}
        with pytest.raises(FeatureError, match="asked 100, allowed 16 to 683, reads back 68"):
            camera.set_raw("gain", 100)


def test_automatic_mode_is_set_by_its_special_value_and_taken_back() -> None:
    capture = FakeDc1394()
    with camera_on(capture) as camera:
        feature = camera.set_auto("shutter", is_auto=True)
        assert (feature.control, feature.is_read_only) == ("auto", True)
        assert capture.modes[cv2.CAP_PROP_EXPOSURE] == cv2.CAP_PROP_DC1394_MODE_AUTO
        assert camera.set_auto("shutter", is_auto=False).control == "manual"
        assert capture.modes[cv2.CAP_PROP_EXPOSURE] == cv2.CAP_PROP_DC1394_MODE_MANUAL


def test_absolute_value_is_refused_with_the_way_out() -> None:
    with camera_on(FakeDc1394()) as camera, pytest.raises(FeatureError, match="`raw` table"):
        camera.set_absolute("shutter", 16.02)


def test_raw_values_of_the_profile_are_set_at_opening() -> None:
    capture = FakeDc1394()
    with camera_on(capture, raw={"shutter": 500, "gain": 200}):
        assert capture.values[cv2.CAP_PROP_EXPOSURE] == 500
        assert capture.values[cv2.CAP_PROP_GAIN] == 200


def test_wrong_raw_value_of_the_profile_keeps_the_camera_closed() -> None:
    capture = FakeDc1394()
    with pytest.raises(FeatureError, match="asked 5000"), camera_on(capture, raw={"shutter": 5000}):
        pass
    assert capture.is_released


def test_configure_says_which_features_did_not_take() -> None:
    with camera_on(FakeDc1394(), raw={"shutter": 500}) as camera:
        report = camera.configure(SETTINGS)
        missing = {item.feature: item for item in report.not_taken}
    assert "shutter" not in missing
    assert "white_balance_red" not in missing
    assert missing["pan"].read_back == ""
    assert missing["gain"].allowed == "no absolute value"
    with pytest.raises(FeatureError, match="gain: asked"):
        report.require()


def test_closed_camera_refuses_everything() -> None:
    camera = OpencvCamera(
        "top", stream_source("top", "rtsp://x"), SimulatedClock(), settings=SETTINGS
    )
    camera.close()
    for job in (camera.grab, camera.features, lambda: camera.identity):
        with pytest.raises(DeviceError, match="not open"):
            job()


def test_stream_without_a_url_is_refused() -> None:
    camera = OpencvCamera("top", stream_source("top", ""), SimulatedClock(), settings=SETTINGS)
    with pytest.raises(DeviceError, match="is not a URL"):
        camera.open(SMALL)


def test_folder_gives_its_pictures_in_order_and_then_ends(tmp_path: Path) -> None:
    for number in range(3):
        picture = np.full((960, 1280, 3), (0, 0, 40 * (number + 1)), np.uint8)
        cv2.imwrite(str(tmp_path / f"{number}.png"), picture)
    with file_camera(tmp_path) as camera:
        camera.open(FULL)
        frames = [camera.grab() for _ in range(3)]
        assert [frame.pixels[5, 5].tolist() for frame in frames] == [
            [40, 0, 0], [80, 0, 0], [120, 0, 0],
        ]  # fmt: skip
        with pytest.raises(DeviceError, match="the recording has ended"):
            camera.grab()
        camera.open(SMALL)
        assert camera.grab().pixels.shape == (480, 640, 3)


def test_file_that_is_no_picture_is_a_torn_picture(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"no picture")
    with file_camera(tmp_path) as camera:
        camera.open(SMALL)
        with pytest.raises(DeviceError, match="cannot be decoded"):
            camera.grab()


def test_video_file_gives_every_picture_at_the_video_s_times(tmp_path: Path) -> None:
    path = tmp_path / "video.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 7.5, (640, 480))
    for number in range(4):
        writer.write(np.full((480, 640, 3), 40 * (number + 1), np.uint8))
    writer.release()
    with file_camera(path) as camera:
        camera.open(SMALL)
        frames = [camera.grab() for _ in range(4)]
    levels = [float(frame.pixels.mean()) for frame in frames]
    assert levels == pytest.approx([40, 80, 120, 160], abs=3)
    assert frames[3].time_s - frames[1].time_s == pytest.approx(2 / 7.5, abs=0.002)


def test_missing_file_and_empty_folder_are_named(tmp_path: Path) -> None:
    with (
        file_camera(tmp_path / "none.avi") as camera,
        pytest.raises(DeviceError, match="no file or"),
    ):
        camera.open(SMALL)
    with file_camera(tmp_path) as camera, pytest.raises(DeviceError, match="no pictures"):
        camera.open(SMALL)
