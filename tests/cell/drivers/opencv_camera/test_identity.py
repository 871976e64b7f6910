from __future__ import annotations

from pathlib import Path

import pytest

from cell.drivers.opencv_camera.capture import Capture
from cell.drivers.opencv_camera.identity import find_dc1394, find_v4l2
from cell.errors import DeviceError
from tests.cell.drivers.opencv_camera.fake_capture import FakeDc1394

BASE = 0x00B09D01009A7C40


class Bus:
    def __init__(self, *guids: int) -> None:
        self.cameras = [FakeDc1394(guid) for guid in guids]

    def open_index(self, index: int) -> Capture:
        if index >= len(self.cameras):
            raise DeviceError("camera top", "cannot open")
        return self.cameras[index]


@pytest.mark.parametrize("order", [(1, 2, 3), (3, 1, 2), (2, 3, 1)])
def test_guid_finds_the_camera_in_whatever_order_they_come(order: tuple[int, ...]) -> None:
    bus = Bus(*(BASE + k for k in order))
    index, capture = find_dc1394("top", "00B09D01009A7C42", bus.open_index)
    assert index == order.index(2)
    assert capture is bus.cameras[index]
    assert [camera.is_released for camera in bus.cameras] == [k != 2 for k in order]


def test_missing_camera_is_named_beside_those_there_are() -> None:
    bus = Bus(BASE + 1, BASE + 3)
    with pytest.raises(DeviceError, match=r"0: …009A7C41, 1: …009A7C43"):
        find_dc1394("top", "00B09D01009A7C42", bus.open_index)
    assert all(camera.is_released for camera in bus.cameras)


def test_bus_without_cameras_says_so() -> None:
    with pytest.raises(DeviceError, match="none at all"):
        find_dc1394("top", "00B09D01009A7C42", Bus().open_index)


def test_two_cameras_with_the_same_digits_are_refused() -> None:
    with pytest.raises(DeviceError, match="is there 2 times"):
        find_dc1394("top", "00B09D01009A7C42", Bus(BASE + 2, BASE + 2).open_index)


def test_guid_that_is_no_number_is_refused() -> None:
    with pytest.raises(DeviceError, match="hexadecimal"):
        find_dc1394("top", "left one", Bus(BASE).open_index)


def links(folder: Path, *names: str) -> list[Path]:
    made = []
    for number, name in enumerate(names):
        (folder / f"video{7 - number}").touch()
        link = folder / name
        link.symlink_to(f"video{7 - number}")
        made.append(link)
    return made


C920 = "usb-046d_HD_Pro_Webcam_C920_1A2B3C4F-video-index0"
BRIO = "usb-046d_Logitech_BRIO_90EF77AA-video-index0"


@pytest.mark.parametrize("serial", ["90EF77AA", BRIO, BRIO.removesuffix("-video-index0")])
def test_serial_number_or_link_finds_the_video_device(tmp_path: Path, serial: str) -> None:
    names = links(tmp_path, C920, C920.replace("index0", "index1"), BRIO)
    assert find_v4l2("top", serial, names) == 5


@pytest.mark.parametrize("serial", ["", "90EF", "046d"])
def test_serial_number_that_fits_none_or_several_lists_what_there_is(
    tmp_path: Path, serial: str
) -> None:
    with pytest.raises(DeviceError, match="BRIO_90EF77AA"):
        find_v4l2("top", serial, links(tmp_path, C920, BRIO))
