"""The kinds of sources, and how each is opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2

from cell.devices.camera_features import CameraIdentity
from cell.drivers.opencv_camera.capture import Capture, FolderCapture, VideoCapture
from cell.drivers.opencv_camera.identity import find_dc1394, find_v4l2
from cell.drivers.opencv_camera.properties import DC1394, NO_PROPERTIES, V4L2, PropertyMap
from cell.errors import DeviceError


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where pictures come from.

    Attributes:
        open: Finds and opens it; returns who it is and the open capture.
        properties: How its features are named.
        is_live: Whether it runs by itself, so that only the newest picture counts.
        has_modes: Whether it gives pictures of the size asked for.
        sets_height: Whether height must be set beside width. FireWire takes either:
            setting one forgets the other.
    """

    open: Callable[[], tuple[CameraIdentity, Capture]]
    properties: PropertyMap = NO_PROPERTIES
    is_live: bool = True
    has_modes: bool = True
    sets_height: bool = True


def dc1394_source(camera: str, model: str, guid: str) -> Source:
    """Return a FireWire camera, found by its GUID.

    Args:
        camera: Name of the camera in the profile.
        model: What it is called.
        guid: Its GUID in hexadecimal digits.
    """

    def open_index(index: int) -> Capture:
        return VideoCapture(camera, index, cv2.CAP_DC1394)

    def open_it() -> tuple[CameraIdentity, Capture]:
        _, capture = find_dc1394(camera, guid, open_index)
        return CameraIdentity(model=model, guid=guid), capture

    return Source(open=open_it, properties=DC1394, sets_height=False)


def v4l2_source(camera: str, model: str, serial: str) -> Source:
    """Return a Linux video device, found by its serial number under `/dev/v4l/by-id`."""

    def open_it() -> tuple[CameraIdentity, Capture]:
        capture = VideoCapture(camera, find_v4l2(camera, serial), cv2.CAP_V4L2)
        return CameraIdentity(model=model, guid=serial), capture

    return Source(open=open_it, properties=V4L2)


def file_source(camera: str, place: str) -> Source:
    """Return a video file, or a folder of pictures."""

    def open_it() -> tuple[CameraIdentity, Capture]:
        path = Path(place).expanduser()
        if not place or not path.exists():
            raise DeviceError(
                f"camera {camera}",
                f"there is no file or folder {place!r}",
                hint="give it as the camera's `source` in the profile",
            )
        capture: Capture
        if path.is_dir():
            capture = FolderCapture(camera, path)
        else:
            capture = VideoCapture(camera, str(path), cv2.CAP_ANY)
        return CameraIdentity(model="file", guid=str(path)), capture

    return Source(open=open_it, is_live=False, has_modes=False)


def stream_source(camera: str, url: str) -> Source:
    """Return a stream, by its URL."""

    def open_it() -> tuple[CameraIdentity, Capture]:
        if "://" not in url:
            raise DeviceError(
                f"camera {camera}",
                f"{url!r} is not a URL",
                hint="give one as the camera's `source`, such as rtsp://192.168.0.5/stream",
            )
        return CameraIdentity(model="stream", guid=url), VideoCapture(camera, url, cv2.CAP_FFMPEG)

    return Source(open=open_it, has_modes=False)
