from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cell.clock import SimulatedClock
from cell.devices.camera import MODES, Camera
from cell.devices.camera_features import FeatureError
from cell.drivers.genicam_camera.driver import GenicamCamera
from cell.drivers.genicam_camera.toolkit import load_toolkit
from cell.errors import DeviceError, DeviceTimeout
from cell.profile import load_profile
from tests.cell.drivers.genicam_camera.fake_harvesters import (
    FakeAcquirer,
    FakeHarvester,
    toolkit_of,
)

SETTINGS = load_profile("mash").cameras["top"].settings
SMALL, FULL = MODES[0], MODES[3]


class Bench:
    def __init__(self, folder: Path, serials: tuple[str, ...] = ("111", "222")) -> None:
        producer = folder / "producer.cti"
        producer.touch()
        self.clock = SimulatedClock(3.0)
        self.harvester = FakeHarvester(*serials)
        self.camera = GenicamCamera(
            "top",
            "222",
            str(producer),
            self.clock,
            settings=SETTINGS,
            toolkit=lambda: toolkit_of(self.harvester),
            timeout_s=1.5,
        )

    @property
    def acquirer(self) -> FakeAcquirer:
        return self.harvester.acquirers[-1]


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    made = Bench(tmp_path)
    made.camera.open(FULL)
    return made


def test_camera_is_found_by_its_serial_number(bench: Bench) -> None:
    camera: Camera = bench.camera
    assert bench.harvester.opened == [1]
    assert str(camera.identity) == "Blackfly S 222"


def test_missing_serial_number_is_named_beside_those_there_are(tmp_path: Path) -> None:
    bench = Bench(tmp_path, ("111", "333"))
    with pytest.raises(DeviceError, match=r"'222' is there 0 times; .*111, 333"):
        bench.camera.open(FULL)
    assert bench.harvester.is_reset


def test_missing_producer_is_named(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    (tmp_path / "producer.cti").unlink()
    with pytest.raises(DeviceError, match="no GenTL producer"):
        bench.camera.open(FULL)


def test_missing_library_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "harvesters", None)
    monkeypatch.setitem(sys.modules, "harvesters.core", None)
    with pytest.raises(DeviceError, match=r"pip install robocell\[genicam\]"):
        load_toolkit("top")


def test_picture_has_the_mode_s_size_is_read_only_and_its_buffer_goes_back(bench: Bench) -> None:
    frame = bench.camera.grab()
    assert frame.pixels.shape == (960, 1280, 3)
    assert frame.pixels[0, 0].tolist() == [1, 2, 3]
    assert not frame.pixels.flags.writeable
    assert all(buffer.is_queued for buffer in bench.acquirer.buffers)
    assert bench.acquirer.waits_s == [1.5]


@pytest.mark.parametrize(
    ("name", "first"), [("BGR8", [3, 2, 1]), ("Mono8", [1, 1, 1]), ("RGB8", [1, 2, 3])]
)
def test_every_usable_pixel_format_becomes_red_green_blue(
    bench: Bench, name: str, first: list[int]
) -> None:
    bench.acquirer.format = name
    assert bench.camera.grab().pixels[0, 0].tolist() == first


def test_unusable_pixel_format_is_refused_and_its_buffer_goes_back(bench: Bench) -> None:
    bench.acquirer.format = "BayerRG8"
    with pytest.raises(DeviceError, match="BayerRG8; usable are RGB8"):
        bench.camera.grab()
    assert bench.acquirer.buffers[-1].is_queued


def test_times_come_from_the_camera_s_clock_laid_onto_ours(bench: Bench) -> None:
    first = bench.camera.grab()
    bench.clock.sleep(5.0)
    second = bench.camera.grab()
    assert first.time_s == 3.0
    assert second.time_s == pytest.approx(3.133)
    assert second.number == first.number + 1


def test_silent_camera_is_a_timeout(bench: Bench) -> None:
    bench.acquirer.is_silent = True
    with pytest.raises(DeviceTimeout, match="1.5 s"):
        bench.camera.grab()


def test_torn_picture_is_an_error(bench: Bench) -> None:
    bench.acquirer.is_torn = True
    with pytest.raises(DeviceError, match="1843200 of 3686400 bytes"):
        bench.camera.grab()


def test_exposure_time_is_milliseconds_here_and_microseconds_there(bench: Bench) -> None:
    shutter = bench.camera.set_absolute("shutter", 16.02)
    assert bench.acquirer.remote_device.node_map.ExposureTime.value == pytest.approx(16020.0)
    assert shutter.absolute == pytest.approx(16.02)
    assert shutter.absolute_range == pytest.approx((0.02, 200.0))
    assert bench.acquirer.remote_device.node_map.ExposureAuto.value == "Off"
    assert bench.camera.settings().shutter_ms == pytest.approx(16.02)


def test_white_balance_is_one_node_behind_a_selector(bench: Bench) -> None:
    by_name = {feature.name: feature for feature in bench.camera.features()}
    assert by_name["white_balance_red"].absolute == 1.25
    assert by_name["white_balance_blue"].absolute == 1.5
    bench.camera.set_absolute("white_balance_blue", 2.0)
    ratios = bench.acquirer.remote_device.node_map.BalanceRatio.by_entry
    assert ratios == {"Red": 1.25, "Blue": 2.0}


def test_features_tell_control_and_what_is_read_only_or_missing(bench: Bench) -> None:
    by_name = {feature.name: feature for feature in bench.camera.features()}
    assert (by_name["shutter"].control, by_name["shutter"].is_read_only) == ("auto", True)
    assert by_name["gamma"].is_read_only
    assert (by_name["sharpness"].raw, by_name["sharpness"].raw_range) == (8, (0, 16))
    assert not {"hue", "pan", "exposure"} & set(by_name)


@pytest.mark.parametrize(
    ("value", "text"), [(30.0, "asked 30 dB, allowed 0 to 24 dB, reads back 1.5 dB")]
)
def test_refused_value_says_asked_allowed_and_read_back(
    bench: Bench, value: float, text: str
) -> None:
    with pytest.raises(FeatureError, match=text):
        bench.camera.set_absolute("gain", value)


def test_value_that_cannot_be_written_is_told(bench: Bench) -> None:
    bench.acquirer.remote_device.node_map.Gain.access = 3
    with pytest.raises(FeatureError, match="asked 6 dB, allowed 0 to 24 dB, reads back 1.5 dB"):
        bench.camera.set_absolute("gain", 6.0)


def test_automatic_mode_is_left_and_taken_back(bench: Bench) -> None:
    assert bench.camera.set_auto("shutter", is_auto=False).control == "manual"
    assert bench.camera.set_auto("shutter", is_auto=True).control == "auto"
    with pytest.raises(FeatureError, match="asked auto, allowed manual"):
        bench.camera.set_auto("gain", is_auto=True)


def test_configure_reports_what_the_camera_cannot_do(bench: Bench) -> None:
    report = bench.camera.configure(SETTINGS)
    missing = {item.feature for item in report.not_taken}
    assert missing >= {"pan", "tilt", "exposure", "hue", "white_balance_red", "gain"}
    assert "shutter" not in missing


def test_closing_gives_everything_back_and_twice_is_harmless(bench: Bench) -> None:
    acquirer = bench.acquirer
    bench.camera.close()
    bench.camera.close()
    assert acquirer.is_destroyed
    assert bench.harvester.is_reset
    with pytest.raises(DeviceError, match="not open"):
        bench.camera.grab()
