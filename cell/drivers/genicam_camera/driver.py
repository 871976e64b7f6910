"""`GenicamCamera`: the camera protocol over GenICam, by way of `harvesters`.

Written after the library's and the standard's documents; not yet tried on a camera.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cell.clock import Clock
from cell.devices.camera import CameraMode, CameraSettings, Frame
from cell.devices.camera_configure import apply_settings, settings_of
from cell.devices.camera_features import (
    CameraFeature,
    CameraIdentity,
    FeatureName,
    SettingsReport,
)
from cell.drivers.genicam_camera.nodes import NodeFeatures
from cell.drivers.genicam_camera.toolkit import Acquirer, Component, Harvester, Toolkit
from cell.errors import DeviceError, DeviceTimeout

_FORMATS = ("RGB8", "RGB8Packed", "BGR8", "BGR8Packed", "Mono8")


class GenicamCamera:
    """A GigE Vision or USB3 Vision camera, found by its serial number."""

    def __init__(
        self,
        name: str,
        serial: str,
        producer: str,
        clock: Clock,
        *,
        settings: CameraSettings,
        toolkit: Callable[[], Toolkit],
        timeout_s: float = 2.0,
    ) -> None:
        """Make a camera, closed.

        Args:
            name: Its name in the profile.
            serial: Its serial number.
            producer: The GenTL producer that reaches it, a `.cti` file.
            clock: The cell's clock, for capture times.
            settings: Absolute values from the profile.
            toolkit: Loads the library when the camera is opened.
            timeout_s: How long to wait for a picture.
        """
        self._name = name
        self._serial = serial
        self._producer = producer
        self._clock = clock
        self._settings = settings
        self._toolkit = toolkit
        self._timeout_s = timeout_s
        self._identity: CameraIdentity | None = None
        self._mode: CameraMode | None = None
        self._harvester: Harvester | None = None
        self._acquirer: Acquirer | None = None
        self._nodes: NodeFeatures | None = None
        self._errors: tuple[type[Exception], ...] = ()
        self._number = 0
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
        """Find the camera by its serial number and start it in a mode.

        Raises:
            DeviceError: The library or the producer is missing, or the camera is not there.
        """
        self.close()
        toolkit = self._toolkit()
        self._errors = toolkit.errors
        try:
            self._start(toolkit, mode)
        except self._errors as error:
            self.close()
            raise DeviceError(
                f"camera {self._name}",
                f"GenICam failed: {error}",
                hint="check the producer (`source`) and that no other program has the camera",
            ) from error
        except DeviceError:
            self.close()
            raise
        return str(self.identity)

    def close(self) -> None:
        """Stop; closing twice does nothing."""
        acquirer, self._acquirer = self._acquirer, None
        harvester, self._harvester = self._harvester, None
        self._nodes = None
        self._identity = None
        self._mode = None
        try:
            if acquirer is not None:
                acquirer.stop()
                acquirer.destroy()
            if harvester is not None:
                harvester.reset()
        except self._errors as error:
            raise DeviceError(f"camera {self._name}", f"does not close: {error}") from error

    def settings(self) -> CameraSettings:
        """Return the settings as last read back; what the camera lacks is as asked for."""
        return self._settings

    def configure(self, settings: CameraSettings) -> SettingsReport:
        """Set every feature and read it back; return which did not take."""
        nodes = self._access()
        report = apply_settings(self._name, nodes, settings)
        self._settings = settings_of(nodes.all(), settings)
        return report

    def features(self) -> tuple[CameraFeature, ...]:
        """Return every feature that the camera offers."""
        return self._access().all()

    def set_raw(self, name: FeatureName, value: int) -> CameraFeature:
        """Set a feature's raw value by hand."""
        return self._read(self._access().set_raw(name, value))

    def set_absolute(self, name: FeatureName, value: float) -> CameraFeature:
        """Set a feature's absolute value by hand."""
        return self._read(self._access().set_absolute(name, value))

    def set_auto(self, name: FeatureName, *, is_auto: bool) -> CameraFeature:
        """Leave a feature to the camera, or take it back."""
        return self._read(self._access().set_auto(name, is_auto=is_auto))

    def grab(self) -> Frame:
        """Return the next picture.

        Raises:
            DeviceTimeout: None came in time; an incomplete one counts as none.
            DeviceError: It is not open, or the picture cannot be used.
        """
        if self._acquirer is None or self._mode is None:
            raise self._closed()
        try:
            buffer = self._acquirer.try_fetch(timeout=self._timeout_s)
            if buffer is None:
                raise DeviceTimeout(
                    f"camera {self._name}",
                    f"gave no whole picture within {self._timeout_s:g} s",
                    hint="check its cable and power, and the network's packet size",
                )
            now_s = self._clock.now_s()
            try:
                pixels = self._pixels(buffer.payload.components[0], self._mode)
                time_s = self._time_s(now_s, buffer.timestamp_ns / 1e9)
            finally:
                buffer.queue()
        except self._errors as error:
            raise DeviceError(
                f"camera {self._name}", f"GenICam failed: {error}", hint="open it again"
            ) from error
        self._number += 1
        return Frame(
            camera=self._name,
            number=self._number,
            time_s=time_s,
            pixels=pixels,
            settings=self._settings,
        )

    def grab_fresh(self) -> Frame:
        """Return a picture taken after this call: one that waits in a buffer is dropped."""
        self.grab()
        return self.grab()

    def _start(self, toolkit: Toolkit, mode: CameraMode) -> None:
        if not Path(self._producer).is_file():
            raise DeviceError(
                f"camera {self._name}",
                f"there is no GenTL producer {self._producer!r}",
                hint="install the maker's producer and give its .cti file as `source`",
            )
        harvester = self._harvester = toolkit.harvester()
        harvester.add_file(self._producer, check_existence=True)
        harvester.update()
        there = [str(info.serial_number) for info in harvester.device_info_list]
        if there.count(self._serial) != 1:
            raise DeviceError(
                f"camera {self._name}",
                f"serial number {self._serial!r} is there {there.count(self._serial)} times; "
                f"cameras there are: {', '.join(there) or 'none at all'}",
                hint="plug it in, or correct its guid in the profile",
            )
        place = there.index(self._serial)
        model = str(harvester.device_info_list[place].model)
        acquirer = self._acquirer = harvester.create(place)
        nodes = NodeFeatures(self._name, acquirer.remote_device.node_map, self._errors)
        if not nodes.put("PixelFormat", "RGB8"):
            nodes.put("PixelFormat", "Mono8")
        for node, value in (("Width", mode.width_px), ("Height", mode.height_px)):
            nodes.put(node, value)
        nodes.put("AcquisitionFrameRateEnable", True)
        nodes.put("AcquisitionFrameRate", mode.rate_hz)
        self._nodes = nodes
        self._identity = CameraIdentity(model=model, guid=self._serial)
        self._mode = mode
        self._number = 0
        self._origin = None
        self._settings = settings_of(nodes.all(), self._settings)
        acquirer.start()

    def _pixels(self, component: Component, mode: CameraMode) -> NDArray[np.uint8]:
        """Return a picture of its own memory, R G B, read-only."""
        name = str(component.data_format)
        size = (int(component.height), int(component.width))
        channels = 1 if name == "Mono8" else 3
        if name not in _FORMATS:
            raise DeviceError(
                f"camera {self._name}",
                f"gives pixels as {name}; usable are {', '.join(_FORMATS)}",
                hint="set its pixel format",
            )
        if size != (mode.height_px, mode.width_px):
            raise DeviceError(
                f"camera {self._name}",
                f"gave a picture of {size[1]}x{size[0]} pixels instead of "
                f"{mode.width_px}x{mode.height_px}",
                hint="choose a mode that the camera has",
            )
        if component.data.size != size[0] * size[1] * channels:
            raise DeviceError(
                f"camera {self._name}",
                f"gave a torn picture: {component.data.size} of "
                f"{size[0] * size[1] * channels} bytes arrived",
                hint="grab again; if it repeats, check the cable",
            )
        plane = component.data.reshape(*size, channels)
        if channels == 1:
            pixels = np.repeat(plane, 3, axis=2)
        else:
            pixels = plane[..., ::-1].copy() if name.startswith("BGR") else plane.copy()
        pixels.setflags(write=False)
        return pixels

    def _time_s(self, now_s: float, camera_s: float) -> float:
        """Return the capture time by the camera's clock, laid onto ours at the first picture."""
        if self._origin is None or camera_s < self._origin[1]:
            self._origin = (now_s, camera_s)
        return min(now_s, self._origin[0] + camera_s - self._origin[1])

    def _read(self, feature: CameraFeature) -> CameraFeature:
        self._settings = settings_of(self.features(), self._settings)
        return feature

    def _access(self) -> NodeFeatures:
        if self._nodes is None:
            raise self._closed()
        return self._nodes

    def _closed(self) -> DeviceError:
        return DeviceError(f"camera {self._name}", "is not open", hint="open it in a mode first")
