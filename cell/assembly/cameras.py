"""The cell's own cameras, by the backends that its profile names."""

from __future__ import annotations

from cell.clock import Clock
from cell.devices.camera import Camera
from cell.errors import ProfileError
from cell.profile import CameraProfile, CellProfile


def hardware_cameras(profile: CellProfile, clock: Clock) -> dict[str, Camera]:
    """Return a profile's cameras by name, closed; nothing is looked for until one is opened.

    Args:
        profile: The cell's profile.
        clock: The cell's clock, for capture times.

    Raises:
        ProfileError: A backend needs a source and none is given.
    """
    return {name: _camera(name, device, clock) for name, device in profile.cameras.items()}


def _camera(name: str, device: CameraProfile, clock: Clock) -> Camera:
    if device.backend in ("file", "stream", "genicam") and not device.source:
        raise ProfileError(
            f"cameras.{name}: backend {device.backend!r} needs `source`: a video file or folder "
            "(file), a URL (stream), or a GenTL producer, a .cti file (genicam)"
        )
    if device.backend == "genicam":
        return _genicam(name, device, clock)
    # The library is loaded for cells that have such cameras, and for no others.
    from cell.drivers.opencv_camera import driver, sources

    if device.backend == "dc1394":
        source = sources.dc1394_source(name, device.model, device.guid)
    elif device.backend == "v4l2":
        source = sources.v4l2_source(name, device.model, device.guid)
    elif device.backend == "file":
        source = sources.file_source(name, device.source)
    else:
        source = sources.stream_source(name, device.source)
    return driver.OpencvCamera(
        name,
        source,
        clock,
        settings=device.settings,
        raw=device.raw,
        timeout_s=device.timeout_s,
    )


def _genicam(name: str, device: CameraProfile, clock: Clock) -> Camera:
    from cell.drivers.genicam_camera import driver, toolkit

    return driver.GenicamCamera(
        name,
        device.guid,
        device.source,
        clock,
        settings=device.settings,
        toolkit=lambda: toolkit.load_toolkit(name),
        timeout_s=device.timeout_s,
    )
