"""A profile's settings, feature by feature, onto any camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cell.devices.camera import CameraSettings
from cell.devices.camera_features import (
    UNITS,
    CameraFeature,
    FeatureError,
    FeatureName,
    NotTaken,
    SettingsReport,
    quantity,
)
from cell.errors import DeviceError


class FeatureAccess(Protocol):
    """What setting features needs of a camera."""

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a raw value."""

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set an absolute value."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """One feature of a set of settings.

    Attributes:
        name: Which feature.
        value: Its value.
        is_raw: Whether the value is the register's own, without a unit.
    """

    name: FeatureName
    value: float
    is_raw: bool = False


def wanted(settings: CameraSettings) -> tuple[Wanted, ...]:
    """Return the features of a set of settings: absolute values, raw where no unit is known."""
    return (
        Wanted("brightness", settings.brightness_percent),
        Wanted("exposure", settings.exposure_ev),
        Wanted("sharpness", settings.sharpness, is_raw=True),
        Wanted("hue", settings.hue_deg),
        Wanted("saturation", settings.saturation_percent),
        Wanted("gamma", settings.gamma),
        Wanted("pan", settings.pan, is_raw=True),
        Wanted("tilt", settings.tilt, is_raw=True),
        Wanted("shutter", settings.shutter_ms),
        Wanted("gain", settings.gain_db),
        Wanted("white_balance_red", settings.white_balance_red, is_raw=True),
        Wanted("white_balance_blue", settings.white_balance_blue, is_raw=True),
    )


def apply_settings(camera: str, access: FeatureAccess, settings: CameraSettings) -> SettingsReport:
    """Set every feature by hand and read it back; a refused one does not stop the others.

    Args:
        camera: Name of the camera in the profile.
        access: Sets its features.
        settings: What they are to be.

    Raises:
        DeviceError: No camera can have such values, or this one does not answer.
    """
    check_possible(camera, settings)
    not_taken: list[NotTaken] = []
    for item in wanted(settings):
        try:
            if item.is_raw:
                access.set_raw(item.name, int(item.value))
            else:
                access.set_absolute(item.name, item.value)
        except FeatureError as error:
            not_taken.extend(error.not_taken)
    return SettingsReport(camera, tuple(not_taken))


def check_possible(camera: str, settings: CameraSettings) -> None:
    """Return if settings are ones that some camera can have.

    Raises:
        DeviceError: Shutter or gamma is not positive.
    """
    if settings.shutter_ms <= 0 or settings.gamma <= 0:
        raise DeviceError(
            f"camera {camera}",
            f"shutter {settings.shutter_ms:g} ms and gamma {settings.gamma:g} must be positive",
            hint="correct the camera's settings in the profile",
        )


def missing(item: Wanted) -> NotTaken:
    """Return the finding that a camera has no such feature."""
    asked = str(int(item.value)) if item.is_raw else quantity(item.value, UNITS.get(item.name, ""))
    return NotTaken(feature=item.name, asked=asked, allowed="nothing", read_back="")


def settings_of(features: tuple[CameraFeature, ...], default: CameraSettings) -> CameraSettings:
    """Return the settings that features stand for; what a camera lacks is as in `default`."""
    by_name = {feature.name: feature for feature in features}

    def absolute(name: FeatureName, fallback: float) -> float:
        feature = by_name.get(name)
        return fallback if feature is None or feature.absolute is None else feature.absolute

    def raw(name: FeatureName, fallback: int) -> int:
        feature = by_name.get(name)
        return fallback if feature is None or feature.raw is None else feature.raw

    return CameraSettings(
        brightness_percent=absolute("brightness", default.brightness_percent),
        exposure_ev=absolute("exposure", default.exposure_ev),
        sharpness=raw("sharpness", default.sharpness),
        hue_deg=absolute("hue", default.hue_deg),
        saturation_percent=absolute("saturation", default.saturation_percent),
        gamma=absolute("gamma", default.gamma),
        pan=raw("pan", default.pan),
        tilt=raw("tilt", default.tilt),
        shutter_ms=absolute("shutter", default.shutter_ms),
        gain_db=absolute("gain", default.gain_db),
        white_balance_red=raw("white_balance_red", default.white_balance_red),
        white_balance_blue=raw("white_balance_blue", default.white_balance_blue),
    )
