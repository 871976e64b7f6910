"""A driver in front of the emulated camera."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.clock import SimulatedClock
from cell.drivers.axis_vapix import AxisCamera, AxisSettings, WebPicture
from cell.profile import WebCameraProfile
from cell.twin.emulators.axis_vapix import EmulatedAxisCamera

VARIABLE = "ROBOCELL_TEST_WEB_CAMERA"
SECRET = "s3cr3t-of-the-camera"
QUICK = AxisSettings(part_timeout_s=5.0, least_back_off_s=0.001, most_back_off_s=0.002)


def profile(
    url: str, *, user: str = "", variable: str = "", timeout_s: float = 10.0
) -> WebCameraProfile:
    # Unchecked: what the driver itself makes of an address is looked at, too.
    return WebCameraProfile.model_construct(
        model="axis-211", url=url, user=user, password_variable=variable, timeout_s=timeout_s
    )


def driver(
    emulated: EmulatedAxisCamera,
    clock: SimulatedClock | None = None,
    settings: AxisSettings = QUICK,
    *,
    user: str = "",
    variable: str = "",
    timeout_s: float = 10.0,
) -> AxisCamera:
    table = profile(emulated.url, user=user, variable=variable, timeout_s=timeout_s)
    return AxisCamera(table, SimulatedClock() if clock is None else clock, settings)


def pixels(picture: WebPicture) -> NDArray[np.uint8]:
    decoded = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    return np.asarray(decoded[..., ::-1], np.uint8)
