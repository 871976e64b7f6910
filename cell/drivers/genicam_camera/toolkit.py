"""The part of `harvesters` that is used, as protocols, and where it is imported."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cell.errors import DeviceError


class NodeMap(Protocol):
    """The camera's features by their SFNC names, each an attribute of that name."""


class RemoteDevice(Protocol):
    """The camera itself."""

    @property
    def node_map(self) -> NodeMap:
        """Its features."""


class Component(Protocol):
    """One picture of a buffer: flat bytes, sizes, and the name of the pixel format."""

    data: NDArray[np.uint8]
    width: int
    height: int
    data_format: str


class Payload(Protocol):
    """What a buffer carries."""

    @property
    def components(self) -> Sequence[Component]:
        """Its pictures."""


class Buffer(Protocol):
    """A filled buffer; it must be queued again."""

    @property
    def payload(self) -> Payload:
        """What it carries."""

    @property
    def timestamp_ns(self) -> int:
        """The camera's own time in nanoseconds."""

    def queue(self) -> None:
        """Give the buffer back to be filled."""


class Acquirer(Protocol):
    """An opened camera."""

    @property
    def remote_device(self) -> RemoteDevice:
        """The camera itself."""

    def start(self) -> None:
        """Start the flow of pictures."""

    def stop(self) -> None:
        """Stop it."""

    def try_fetch(self, *, timeout: float) -> Buffer | None:
        """Return a whole buffer; None if none came in `timeout` seconds."""

    def destroy(self) -> None:
        """Give the camera back."""


class DeviceInfo(Protocol):
    """A camera that a producer has found."""

    serial_number: str
    model: str


class Harvester(Protocol):
    """Finds cameras through GenTL producers."""

    @property
    def device_info_list(self) -> Sequence[DeviceInfo]:
        """The cameras found by the last `update`."""

    def add_file(self, file_path: str, check_existence: bool = False) -> None:
        """Add a producer (`.cti`)."""

    def update(self) -> None:
        """Look for cameras."""

    def create(self, search_key: int) -> Acquirer:
        """Open the camera at a place of the list."""

    def reset(self) -> None:
        """Give everything back."""


@dataclass(frozen=True, slots=True)
class Toolkit:
    """What the driver needs of the library.

    Attributes:
        harvester: Makes a harvester.
        errors: The library's errors, which the driver translates.
    """

    harvester: Callable[[], Harvester]
    errors: tuple[type[Exception], ...]


def load_toolkit(camera: str) -> Toolkit:
    """Import `harvesters`.

    Raises:
        DeviceError: It is not installed; the text names the extra.
    """
    try:
        core = importlib.import_module("harvesters.core")
        genapi = importlib.import_module("genicam.genapi")
        gentl = importlib.import_module("genicam.gentl")
    except ImportError as error:
        raise DeviceError(
            f"camera {camera}",
            "GenICam cameras need the package harvesters",
            hint="pip install robocell[genicam]",
        ) from error
    errors = (genapi.GenericException, gentl.GenericException, ValueError, OSError)
    return Toolkit(harvester=core.Harvester, errors=errors)
