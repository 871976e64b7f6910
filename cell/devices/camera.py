"""What callers need of a camera: settings in, frames out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera_features import (
    CameraFeature,
    CameraIdentity,
    FeatureName,
    SettingsReport,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraMode:
    """One of the picture sizes a camera offers."""

    number: int
    width_px: int
    height_px: int
    rate_hz: float


MODES = (
    CameraMode(number=1, width_px=640, height_px=480, rate_hz=7.5),
    CameraMode(number=2, width_px=800, height_px=600, rate_hz=7.5),
    CameraMode(number=3, width_px=1024, height_px=768, rate_hz=7.5),
    CameraMode(number=4, width_px=1280, height_px=960, rate_hz=7.5),
)
"""The four modes of the cell's cameras (Flea2, reference 4.2.1.4)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """Absolute values of a camera's features (table C.1)."""

    brightness_percent: float = 0.0
    exposure_ev: float = 0.0
    sharpness: int = 1024
    hue_deg: float = 0.0
    saturation_percent: float = 100.0
    gamma: float = 1.0
    pan: int = 2
    tilt: int = 0
    shutter_ms: float
    gain_db: float
    white_balance_red: int
    white_balance_blue: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """One picture.

    Attributes:
        camera: Name of the camera in the profile.
        number: Counts the frames that really were taken since the camera was opened.
        time_s: Capture time on the cell's clock.
        pixels: Shape (height, width, 3), uint8, R G B, read-only.
        settings: The settings it was taken with.
    """

    camera: str
    number: int
    time_s: float
    pixels: NDArray[np.uint8]
    settings: CameraSettings


class Camera(Protocol):
    """A camera with fixed place and adjustable settings."""

    @property
    def name(self) -> str:
        """Name of the camera in the profile."""

    def open(self, mode: CameraMode) -> str:
        """Start in a mode (again, if it is another one); return the identity."""

    def close(self) -> None:
        """Stop."""

    @property
    def identity(self) -> CameraIdentity:
        """Who the camera really is, by its GUID or serial number.

        Raises:
            DeviceError: It cannot be found.
        """

    def settings(self) -> CameraSettings:
        """Return the settings in force."""

    def configure(self, settings: CameraSettings) -> SettingsReport:
        """Put settings in force for the next frame: set every feature and read it back.

        Returns:
            Which features did not take their value; all others did.

        Raises:
            DeviceError: No camera can have such a value, or the camera does not answer.
        """

    def features(self) -> tuple[CameraFeature, ...]:
        """Return every feature that the camera has, as it is now.

        Raises:
            DeviceError: The camera does not answer.
        """

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a feature's raw value by hand; return the feature as read back.

        Raises:
            FeatureError: It has another value now; the text says asked, allowed, read back.
            DeviceError: The camera does not answer.
        """

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set a feature's absolute value by hand; return the feature as read back.

        Raises:
            FeatureError: It has another value now; the text says asked, allowed, read back.
            DeviceError: The camera does not answer.
        """

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera, or take it back; return the feature as read back.

        Raises:
            FeatureError: The camera does not do so.
            DeviceError: The camera does not answer.
        """

    def grab(self) -> Frame:
        """Return a picture that shows the scene as it is now.

        The same `Frame` object may be returned again as long as nothing that the
        camera sees has changed.

        Raises:
            DeviceTimeout: No picture came in time.
            DeviceError: The camera is not open or gives no whole picture.
        """

    def grab_fresh(self) -> Frame:
        """Return a picture taken after this call, even if nothing has changed.

        For whoever judges the camera itself: two such pictures differ at least by the
        sensor's noise and have different numbers and times.

        Raises:
            DeviceTimeout: No picture came in time.
            DeviceError: The camera is not open or gives no whole picture.
        """
