from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from cell.assembly.cameras import hardware_cameras
from cell.clock import SimulatedClock
from cell.devices.camera import MODES
from cell.drivers.genicam_camera.driver import GenicamCamera
from cell.drivers.opencv_camera.driver import OpencvCamera
from cell.errors import DeviceError, ProfileError
from cell.profile import Profile, load_profile


def profile_with(**fields: str) -> Profile:
    profile = load_profile("mash")
    top = profile.cameras["top"].model_copy(update=fields)
    return profile.model_copy(update={"cameras": {**profile.cameras, "top": top}})


@pytest.mark.parametrize(
    ("backend", "kind"),
    [
        ("dc1394", OpencvCamera),
        ("v4l2", OpencvCamera),
        ("file", OpencvCamera),
        ("stream", OpencvCamera),
        ("genicam", GenicamCamera),
    ],
)
def test_every_backend_has_its_driver_and_nothing_is_opened(backend: str, kind: type) -> None:
    cameras = hardware_cameras(profile_with(backend=backend, source="x"), SimulatedClock())
    assert list(cameras) == ["oblique", "top", "gripper"]
    assert isinstance(cameras["top"], kind)
    assert cameras["top"].name == "top"
    with pytest.raises(DeviceError, match="not open"):
        cameras["top"].grab()


@pytest.mark.parametrize("backend", ["file", "stream", "genicam"])
def test_backend_without_its_source_is_refused_at_once(backend: str) -> None:
    with pytest.raises(ProfileError, match=rf"cameras\.top: backend '{backend}' needs `source`"):
        hardware_cameras(profile_with(backend=backend), SimulatedClock())


def test_absent_camera_is_an_error_that_says_what_to_do() -> None:
    camera = hardware_cameras(profile_with(backend="v4l2", guid="none such"), SimulatedClock())[
        "top"
    ]
    with pytest.raises(DeviceError, match="correct its guid in the profile"):
        camera.open(MODES[0])


def test_folder_of_pictures_stands_in_for_a_camera(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "1.png"), np.full((960, 1280, 3), 77, np.uint8))
    camera = hardware_cameras(profile_with(backend="file", source=str(tmp_path)), SimulatedClock())[
        "top"
    ]
    camera.open(MODES[3])
    assert camera.grab().pixels.mean() == 77
    camera.close()
