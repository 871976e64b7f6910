"""`OpencvCamera`: the camera protocol over anything that OpenCV opens."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.clock import Clock
from cell.devices.camera import CameraMode, CameraSettings, Frame
from cell.devices.camera_configure import check_possible, missing, settings_of, wanted
from cell.devices.camera_features import (
    CameraFeature,
    CameraIdentity,
    FeatureError,
    FeatureName,
    NotTaken,
    SettingsReport,
)
from cell.drivers.opencv_camera.capture import Capture
from cell.drivers.opencv_camera.properties import PropertyFeatures
from cell.drivers.opencv_camera.reader import Grabbed, Reader
from cell.drivers.opencv_camera.sources import Source
from cell.errors import DeviceError, DeviceTimeout

_MOST_LAG_S = 1.0


class OpencvCamera:
    """A camera behind OpenCV, read by a thread of its own while it is open."""

    def __init__(
        self,
        name: str,
        source: Source,
        clock: Clock,
        *,
        settings: CameraSettings,
        raw: Mapping[FeatureName, int] | None = None,
        timeout_s: float = 2.0,
    ) -> None:
        """Make a camera, closed.

        Args:
            name: Its name in the profile.
            source: Where pictures come from.
            clock: The cell's clock, for capture times.
            settings: Absolute values from the profile.
            raw: Raw values that go before them: OpenCV reaches no absolute ones.
            timeout_s: How long to wait for a picture.
        """
        self._name = name
        self._source = source
        self._clock = clock
        self._wanted = settings
        self._raw = dict(raw or {})
        self._timeout_s = timeout_s
        self._mode: CameraMode | None = None
        self._identity: CameraIdentity | None = None
        self._reader: Reader | None = None
        self._features: PropertyFeatures | None = None
        self._settings = settings
        self._origin: tuple[float, float] | None = None

    @property
    def name(self) -> str:
        """Name of the camera in the profile."""
        return self._name

    @property
    def identity(self) -> CameraIdentity:
        """Who the camera is.

        Raises:
            DeviceError: It is not open.
        """
        if self._identity is None:
            raise self._closed()
        return self._identity

    def open(self, mode: CameraMode) -> str:
        """Find the camera, start it in a mode, set its raw values; return the identity.

        Raises:
            DeviceError: It is not there, or does not open.
            FeatureError: A raw value of the profile did not take.
        """
        self.close()
        self._identity, capture = self._source.open()
        self._features = PropertyFeatures(self._name, capture, self._source.properties)
        self._origin = None
        try:
            self._start(capture, mode)
        except DeviceError:
            capture.release()
            self.close()
            raise
        self._mode = mode
        self._reader = Reader(self._name, capture, self._clock, is_live=self._source.is_live)
        return str(self._identity)

    def close(self) -> None:
        """Stop; closing twice does nothing."""
        reader, self._reader = self._reader, None
        self._mode = None
        self._identity = None
        self._features = None
        if reader is not None:
            reader.stop()

    def settings(self) -> CameraSettings:
        """Return the settings: raw values as read back, absolute ones as in the profile."""
        return self._settings

    def configure(self, settings: CameraSettings) -> SettingsReport:
        """Set every feature that can be reached; return all that did not take.

        A feature with a value in the profile's `raw` table gets that one. Absolute values
        cannot be set through OpenCV and are reported, unless `raw` has the feature.

        Raises:
            DeviceError: It is not open, or no camera can have such values.
        """
        check_possible(self._name, settings)
        features = self._access()
        there = {feature.name for feature in features.all()}
        not_taken: list[NotTaken] = []
        for item in wanted(settings):
            raw = self._raw.get(item.name, int(item.value) if item.is_raw else None)
            if item.name not in there:
                not_taken.append(missing(item))
                continue
            try:
                if raw is None:
                    features.set_absolute(item.name, item.value)
                else:
                    features.set_raw(item.name, raw)
            except FeatureError as error:
                not_taken.extend(error.not_taken)
        self._wanted = settings
        self._settings = settings_of(features.all(), settings)
        return SettingsReport(self._name, tuple(not_taken))

    def features(self) -> tuple[CameraFeature, ...]:
        """Return every feature that the backend reaches."""
        return self._access().all()

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a feature's raw value by hand."""
        feature = self._access().set_raw(name, value)
        self._settings = settings_of(self.features(), self._wanted)
        return feature

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Refuse: OpenCV reaches raw values alone."""
        return self._access().set_absolute(name, value)

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera, or take it back."""
        return self._access().set_auto(name, is_auto=is_auto)

    def grab(self) -> Frame:
        """Return the first picture that comes after this call.

        Raises:
            DeviceTimeout: None came in time.
            DeviceError: It is not open, has no more pictures, or gives a torn one.
        """
        if self._reader is None or self._mode is None:
            raise self._closed()
        grabbed = self._reader.next(self._timeout_s)
        if grabbed is None:
            raise self._nothing(self._reader)
        pixels = self._whole(grabbed, self._mode)
        pixels.setflags(write=False)
        return Frame(
            camera=self._name,
            number=grabbed.number,
            time_s=self._time_s(grabbed),
            pixels=pixels,
            settings=self._settings,
        )

    def grab_fresh(self) -> Frame:
        """Return the first picture that comes after this call, as `grab` does."""
        return self.grab()

    def _start(self, capture: Capture, mode: CameraMode) -> None:
        """Set mode and raw values, which come before the first picture."""
        if self._source.has_modes:
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, mode.width_px)
            if self._source.sets_height:
                capture.set(cv2.CAP_PROP_FRAME_HEIGHT, mode.height_px)
            capture.set(cv2.CAP_PROP_FPS, mode.rate_hz)
        features = self._access()
        features.find_ranges()
        for name, value in self._raw.items():
            features.set_raw(name, value)
        self._settings = settings_of(features.all(), self._wanted)

    def _whole(self, grabbed: Grabbed, mode: CameraMode) -> NDArray[np.uint8]:
        """Return a picture as R G B of the mode's size, or refuse it."""
        picture = grabbed.picture
        if picture is None or picture.size == 0:
            raise DeviceError(
                f"camera {self._name}",
                f"picture {grabbed.number} came torn: it cannot be decoded",
                hint="grab again; if it repeats, check the cable",
            )
        size = (mode.height_px, mode.width_px)
        if picture.shape[:2] != size:
            picture = self._resized(picture, mode)
        code = cv2.COLOR_GRAY2RGB if picture.ndim == 2 else cv2.COLOR_BGR2RGB
        return np.asarray(cv2.cvtColor(picture, code), np.uint8)

    def _resized(self, picture: NDArray[np.uint8], mode: CameraMode) -> NDArray[np.uint8]:
        height, width = picture.shape[:2]
        is_alike = abs(width * mode.height_px - height * mode.width_px) <= mode.width_px
        if self._source.has_modes or not is_alike:
            raise DeviceError(
                f"camera {self._name}",
                f"gave a picture of {width}x{height} pixels instead of "
                f"{mode.width_px}x{mode.height_px}",
                hint="choose a mode that the camera has",
            )
        size = (mode.width_px, mode.height_px)
        return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)

    def _time_s(self, grabbed: Grabbed) -> float:
        """Return the capture time, by the source's own clock where it has one.

        That clock is laid onto ours at the first picture. A live one that has strayed from
        ours by more than a second was set anew and is not believed.
        """
        if grabbed.source_s is None:
            return grabbed.time_s
        if self._origin is None:
            self._origin = (grabbed.time_s, grabbed.source_s)
        time_s = self._origin[0] + grabbed.source_s - self._origin[1]
        if self._source.is_live and not grabbed.time_s - _MOST_LAG_S <= time_s <= grabbed.time_s:
            self._origin = (grabbed.time_s, grabbed.source_s)
            return grabbed.time_s
        return time_s

    def _access(self) -> PropertyFeatures:
        if self._features is None:
            raise self._closed()
        return self._features

    def _closed(self) -> DeviceError:
        return DeviceError(f"camera {self._name}", "is not open", hint="open it in a mode first")

    def _nothing(self, reader: Reader) -> DeviceError:
        if reader.problem:
            return DeviceError(f"camera {self._name}", reader.problem, hint="open it again")
        if reader.has_ended:
            why = "the camera is gone" if self._source.is_live else "the recording has ended"
            return DeviceError(
                f"camera {self._name}", f"gives no more pictures: {why}", hint="open it again"
            )
        return DeviceTimeout(
            f"camera {self._name}",
            f"gave no picture within {self._timeout_s:g} s",
            hint="check its cable and power, then open it again",
        )
