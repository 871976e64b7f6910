"""Features through OpenCV's numbered properties.

FireWire (DC1394): values are raw integers; every set switches absolute mode off, takes the
feature over by hand and clamps to the range. OpenCV tells no ranges, so they are found by
clamping: the least and the greatest integer are set and read back. It tells no mode either:
what was set here last is what is known, and a camera is taken over by hand when it is opened.
White balance is not clamped, so its range stays unknown.

Video devices (V4L2): values are the driver's integers; the range is not told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import cv2

from cell.devices.camera_features import (
    FEATURE_NAMES,
    CameraFeature,
    FeatureControl,
    FeatureError,
    FeatureName,
    NotTaken,
    quantity,
)
from cell.drivers.opencv_camera.capture import Capture

UNKNOWN = -1.0
"""What OpenCV answers for a property that a source does not have."""

_FAR_BELOW, _FAR_ABOVE = -100_000.0, 100_000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PropertyMap:
    """How a backend names features.

    Attributes:
        numbers: OpenCV's property of each feature.
        auto: Value that leaves a feature to the camera; None if there is none.
        has_clamping: Whether the backend clamps values to the range.
        unclamped: Features that it does not clamp all the same.
        auto_properties: Properties that switch the automatic mode: number, off and on.
    """

    numbers: Mapping[FeatureName, int]
    auto: int | None = None
    has_clamping: bool = False
    unclamped: frozenset[FeatureName] = frozenset()
    auto_properties: Mapping[FeatureName, tuple[int, float, float]]


DC1394 = PropertyMap(
    numbers=MappingProxyType(
        {
            "brightness": cv2.CAP_PROP_BRIGHTNESS,
            "exposure": cv2.CAP_PROP_AUTO_EXPOSURE,
            "sharpness": cv2.CAP_PROP_SHARPNESS,
            "hue": cv2.CAP_PROP_HUE,
            "saturation": cv2.CAP_PROP_SATURATION,
            "gamma": cv2.CAP_PROP_GAMMA,
            "shutter": cv2.CAP_PROP_EXPOSURE,
            "gain": cv2.CAP_PROP_GAIN,
            "white_balance_red": cv2.CAP_PROP_WHITE_BALANCE_RED_V,
            "white_balance_blue": cv2.CAP_PROP_WHITE_BALANCE_BLUE_U,
        }
    ),
    auto=cv2.CAP_PROP_DC1394_MODE_AUTO,
    has_clamping=True,
    unclamped=frozenset({"white_balance_red", "white_balance_blue"}),
    auto_properties=MappingProxyType({}),
)
"""FireWire. Pan and tilt lie beyond the properties that the backend reaches."""

V4L2 = PropertyMap(
    numbers=MappingProxyType(
        {
            "brightness": cv2.CAP_PROP_BRIGHTNESS,
            "sharpness": cv2.CAP_PROP_SHARPNESS,
            "hue": cv2.CAP_PROP_HUE,
            "saturation": cv2.CAP_PROP_SATURATION,
            "gamma": cv2.CAP_PROP_GAMMA,
            "pan": cv2.CAP_PROP_PAN,
            "tilt": cv2.CAP_PROP_TILT,
            "shutter": cv2.CAP_PROP_EXPOSURE,
            "gain": cv2.CAP_PROP_GAIN,
        }
    ),
    auto_properties=MappingProxyType(
        # V4L2_CID_EXPOSURE_AUTO: 1 manual, 3 aperture priority.
        {"shutter": (cv2.CAP_PROP_AUTO_EXPOSURE, 1.0, 3.0)}
    ),
)
"""Linux video devices; `shutter` in the driver's unit of 0.1 ms."""

NO_PROPERTIES = PropertyMap(numbers=MappingProxyType({}), auto_properties=MappingProxyType({}))
"""Files, folders and streams: their pictures are as they were taken."""


class PropertyFeatures:
    """Reads and sets the features of an open capture."""

    def __init__(self, camera: str, capture: Capture, properties: PropertyMap) -> None:
        """Make the features of a camera, its ranges not known yet.

        Args:
            camera: Its name in the profile, for messages.
            capture: Its open source.
            properties: How the backend names features.
        """
        self._camera = camera
        self._capture = capture
        self._map = properties
        self._ranges: dict[FeatureName, tuple[int, int]] = {}
        self._modes: dict[FeatureName, FeatureControl] = {}

    def find_ranges(self) -> None:
        """Learn the ranges by clamping; each feature keeps its value, now set by hand."""
        if not self._map.has_clamping:
            return
        for name, number in self._map.numbers.items():
            value = self._capture.get(number)
            if name in self._map.unclamped or value == UNKNOWN:
                continue
            ends = []
            for far in (_FAR_BELOW, _FAR_ABOVE):
                if self._capture.set(number, far):
                    ends.append(round(self._capture.get(number)))
            self._capture.set(number, value)
            self._modes[name] = "manual"
            if len(ends) == 2 and ends[0] <= ends[1]:
                self._ranges[name] = (ends[0], ends[1])

    def all(self) -> tuple[CameraFeature, ...]:
        """Return every feature that the source has."""
        return tuple(
            self._feature(name)
            for name in FEATURE_NAMES
            if name in self._map.numbers and self._capture.get(self._map.numbers[name]) != UNKNOWN
        )

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a raw value by hand.

        Raises:
            FeatureError: Another value is read back, or the source has no such feature.
        """
        number = self._number(name, str(value))
        if name in self._map.auto_properties:
            prop, off, _ = self._map.auto_properties[name]
            self._capture.set(prop, off)
        # Negative numbers near zero stand for modes, so a value below the range goes nowhere.
        span = self._ranges.get(name)
        is_allowed = value >= 0 if span is None else span[0] <= value <= span[1]
        is_set = is_allowed and self._capture.set(number, float(value))
        if is_set:
            self._modes[name] = "manual"
        after = self._feature(name)
        if not is_set or after.raw != value:
            raise self._refusal(after, str(value), is_absolute=False)
        return after

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Refuse: OpenCV reaches raw values alone.

        Raises:
            FeatureError: Always.
        """
        self._number(name, f"{value:g}")
        raise self._refusal(self._feature(name), quantity(value, "absolute"), is_absolute=True)

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera, or take it back at the value it has.

        Raises:
            FeatureError: The source does not do so.
        """
        asked = "auto" if is_auto else "manual"
        number = self._number(name, asked)
        if name in self._map.auto_properties:
            prop, off, on = self._map.auto_properties[name]
            is_set = self._capture.set(prop, on if is_auto else off)
        elif self._map.auto is None:
            is_set = not is_auto
        else:
            value = float(self._map.auto) if is_auto else self._capture.get(number)
            is_set = self._capture.set(number, value)
        if not is_set:
            raise self._refusal(self._feature(name), asked, is_absolute=False)
        self._modes[name] = "auto" if is_auto else "manual"
        return self._feature(name)

    def _feature(self, name: FeatureName) -> CameraFeature:
        value = self._capture.get(self._map.numbers[name])
        control = self._control(name)
        can_auto = self._map.auto is not None or name in self._map.auto_properties
        controls: set[FeatureControl] = {"manual", "auto"} if can_auto else {"manual"}
        return CameraFeature(
            name=name,
            unit="",
            raw_range=self._ranges.get(name),
            absolute_range=None,
            controls=frozenset(controls),
            control=control,
            raw=None if value == UNKNOWN else round(value),
            is_read_only=control != "manual",
        )

    def _control(self, name: FeatureName) -> FeatureControl:
        if name in self._map.auto_properties:
            prop, off, _ = self._map.auto_properties[name]
            return "manual" if self._capture.get(prop) == off else "auto"
        return self._modes.get(name, "manual")

    def _number(self, name: FeatureName, asked: str) -> int:
        number = self._map.numbers.get(name)
        if number is None or self._capture.get(number) == UNKNOWN:
            none = NotTaken(feature=name, asked=asked, allowed="nothing", read_back="")
            raise FeatureError(self._camera, [none])
        return number

    def _refusal(self, feature: CameraFeature, asked: str, *, is_absolute: bool) -> FeatureError:
        allowed = feature.allowed(is_absolute=is_absolute)
        if not is_absolute and feature.raw_range is None:
            allowed = "what the device takes (its range is not told)"
        hint = "give its raw value in the camera's `raw` table" if is_absolute else ""
        item = NotTaken(
            feature=feature.name, asked=asked, allowed=allowed, read_back=str(feature.raw)
        )
        return FeatureError(self._camera, [item], hint=hint)
