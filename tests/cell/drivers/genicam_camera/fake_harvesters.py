"""A fake of `harvesters` 1.4: nodes with limits and access modes, buffers to be queued."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cell.drivers.genicam_camera.toolkit import Acquirer, Buffer, Component, Toolkit

READ_WRITE, READ_ONLY, NOT_AVAILABLE = 4, 3, 1


class GenericException(Exception):
    """The library's error."""


class FakeNode:
    def __init__(
        self,
        value: float | int | str | bool,
        low: float = 0,
        high: float = 0,
        *,
        step: float = 0.0,
        access: int = READ_WRITE,
        entries: tuple[str, ...] = (),
    ) -> None:
        self._value = value
        self.min, self.max = low, high
        self.step = step
        self.access = access
        self.entries = entries

    @property
    def value(self) -> float | int | str | bool:
        return self._value

    @value.setter
    def value(self, value: float | int | str | bool) -> None:
        if self.access != READ_WRITE:
            raise GenericException("node is not writable")
        if self.entries and value not in self.entries:
            raise GenericException(f"{value} is no entry")
        if not self.entries and not isinstance(value, bool | str):
            if not self.min <= value <= self.max:
                raise GenericException(f"{value} out of range")
            if self.step:
                value = round(value / self.step) * self.step
        self._value = value

    def get_access_mode(self) -> int:
        return self.access


class BalanceRatio(FakeNode):
    """One value for each entry of the selector."""

    def __init__(self, selector: FakeNode) -> None:
        self.selector = selector
        self.by_entry: dict[object, float] = {"Red": 1.25, "Blue": 1.5}
        super().__init__(1.0, 0.25, 4.0)

    @property
    def value(self) -> float | int | str | bool:
        return self.by_entry[self.selector.value]

    @value.setter
    def value(self, value: float | int | str | bool) -> None:
        self.by_entry[self.selector.value] = float(value)


OFF_OR_ON = ("Off", "Once", "Continuous")


class FakeNodeMap:
    def __init__(self) -> None:
        self.Width = FakeNode(640, 16, 1280)
        self.Height = FakeNode(480, 16, 960)
        self.PixelFormat = FakeNode("Mono8", entries=("Mono8", "RGB8"))
        self.AcquisitionFrameRateEnable = FakeNode(False)
        self.AcquisitionFrameRate = FakeNode(30.0, 1.0, 60.0)
        self.ExposureTime = FakeNode(5000.0, 20.0, 200_000.0, step=10.0)
        self.ExposureAuto = FakeNode("Continuous", entries=OFF_OR_ON)
        self.Gain = FakeNode(1.5, 0.0, 24.0)
        self.Gamma = FakeNode(1.0, 1.0, 1.0, access=READ_ONLY)
        self.Hue = FakeNode(0.0, access=NOT_AVAILABLE)
        self.Sharpness = FakeNode(8, 0, 16)
        self.BalanceRatioSelector = FakeNode("Green", entries=("Red", "Green", "Blue"))
        self.BalanceRatio = BalanceRatio(self.BalanceRatioSelector)


@dataclass
class FakeComponent:
    data: NDArray[np.uint8]
    width: int
    height: int
    data_format: str


@dataclass
class FakePayload:
    components: list[Component]


@dataclass
class FakeBuffer:
    payload: FakePayload
    timestamp_ns: int
    is_queued: bool = False

    def queue(self) -> None:
        self.is_queued = True


@dataclass
class FakeRemoteDevice:
    node_map: FakeNodeMap = field(default_factory=FakeNodeMap)


@dataclass
class FakeAcquirer:
    remote_device: FakeRemoteDevice = field(default_factory=FakeRemoteDevice)
    is_started: bool = False
    is_destroyed: bool = False
    is_silent: bool = False
    is_torn: bool = False
    format: str = ""
    buffers: list[FakeBuffer] = field(default_factory=list)
    timestamp_ns: int = 10**15
    waits_s: list[float] = field(default_factory=list)

    def start(self) -> None:
        self.is_started = True

    def stop(self) -> None:
        self.is_started = False

    def destroy(self) -> None:
        self.is_destroyed = True

    def try_fetch(self, *, timeout: float) -> Buffer | None:
        self.waits_s.append(timeout)
        if self.is_silent or not self.is_started:
            return None
        nodes = self.remote_device.node_map
        width, height = int(nodes.Width.value), int(nodes.Height.value)
        name = self.format or str(nodes.PixelFormat.value)
        channels = 1 if name == "Mono8" else 3
        data = np.tile(np.arange(1, channels + 1, dtype=np.uint8), width * height)
        if self.is_torn:
            data = data[: data.size // 2]
        self.timestamp_ns += 133_000_000
        component = FakeComponent(data, width, height, name)
        buffer = FakeBuffer(FakePayload([component]), self.timestamp_ns)
        self.buffers.append(buffer)
        return buffer


@dataclass
class FakeInfo:
    serial_number: str
    model: str = "Blackfly S"


class FakeHarvester:
    def __init__(self, *serials: str) -> None:
        self.there = serials
        self.device_info_list: list[FakeInfo] = []
        self.files: list[str] = []
        self.acquirers: list[FakeAcquirer] = []
        self.opened: list[int] = []
        self.is_reset = False

    def add_file(self, file_path: str, check_existence: bool = False) -> None:
        self.files.append(file_path)

    def update(self) -> None:
        self.device_info_list = [FakeInfo(serial) for serial in self.there]

    def create(self, search_key: int) -> Acquirer:
        self.opened.append(search_key)
        self.acquirers.append(FakeAcquirer())
        return self.acquirers[-1]

    def reset(self) -> None:
        self.is_reset = True


def toolkit_of(harvester: FakeHarvester) -> Toolkit:
    return Toolkit(lambda: harvester, (GenericException,))
