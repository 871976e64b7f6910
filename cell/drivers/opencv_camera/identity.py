"""Which index a camera has now: by GUID or serial number, never by habit.

Indices change with every replug and restart. The resolvers look at every camera there is
and say what they saw when the one asked for is not among them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import cv2

from cell.drivers.opencv_camera.capture import Capture
from cell.errors import CellError, DeviceError

MOST_CAMERAS = 16
"""Indices that are tried on a FireWire bus."""

_LOW_WORD = 0xFFFFFFFF
_BY_ID = Path("/dev/v4l/by-id")


def find_dc1394(
    camera: str, guid: str, open_index: Callable[[int], Capture], count: int = MOST_CAMERAS
) -> tuple[int, Capture]:
    """Return index and open capture of the FireWire camera with a GUID.

    OpenCV tells the low 32 bits of a GUID, so the last eight digits decide.

    Args:
        camera: Name of the camera in the profile, for messages.
        guid: Its GUID in hexadecimal digits.
        open_index: Opens the capture of an index.
        count: How many indices to try.

    Raises:
        DeviceError: It is not on the bus, two have these digits, or the GUID is none.
    """
    wanted = _low_word(camera, guid)
    seen: list[str] = []
    found: list[tuple[int, Capture]] = []
    for index in range(count):
        try:
            capture = open_index(index)
        except CellError:
            break
        low = int(capture.get(cv2.CAP_PROP_GUID)) & _LOW_WORD
        seen.append(f"{index}: …{low:08X}")
        if low == wanted:
            found.append((index, capture))
        else:
            capture.release()
    if len(found) == 1:
        return found[0]
    for _, capture in found:
        capture.release()
    there = ", ".join(seen) or "none at all"
    what = "is not on the bus" if not found else f"is there {len(found)} times"
    raise DeviceError(
        f"camera {camera}",
        f"GUID {guid} {what}; cameras there are: {there}",
        hint="plug it in, or correct its guid in the profile",
    )


def find_v4l2(camera: str, serial: str, names: Iterable[Path] | None = None) -> int:
    """Return the index of the Linux video device with a serial number.

    Args:
        camera: Name of the camera in the profile, for messages.
        serial: Its serial number, or its whole name under `/dev/v4l/by-id`.
        names: The links under `/dev/v4l/by-id`; what is there unless given.

    Raises:
        DeviceError: There is none, or more than one.
    """
    links = sorted(_by_id() if names is None else names)
    # A camera may have several devices; its pictures come from the one numbered 0.
    pictures = [link for link in links if link.name.endswith("-video-index0")]
    found = [link for link in pictures if serial and serial in _words(link.name)]
    if len(found) == 1:
        return _index(camera, found[0])
    there = ", ".join(link.name for link in pictures) or "none at all"
    what = "is not there" if not found else f"fits {len(found)} of them"
    raise DeviceError(
        f"camera {camera}",
        f"serial number {serial!r} {what}; video devices there are: {there}",
        hint="plug it in, or correct its guid in the profile",
    )


def _by_id() -> list[Path]:
    return list(_BY_ID.iterdir()) if _BY_ID.is_dir() else []


def _words(name: str) -> set[str]:
    """Return what may name a device: its whole link, the link without ends, and its parts."""
    bare = name.removesuffix("-video-index0")
    return {name, bare, *bare.split("_"), *bare.replace("-", "_").split("_")}


def _index(camera: str, link: Path) -> int:
    device = link.resolve().name
    digits = device.removeprefix("video")
    if not digits.isdecimal():
        raise DeviceError(f"camera {camera}", f"{link} leads to {device}, not to a video device")
    return int(digits)


def _low_word(camera: str, guid: str) -> int:
    digits = guid.lower().removeprefix("0x").replace(":", "").replace("-", "")
    try:
        return int(digits, 16) & _LOW_WORD
    except ValueError as error:
        raise DeviceError(
            f"camera {camera}",
            f"GUID {guid!r} is not a hexadecimal number",
            hint="correct its guid in the profile",
        ) from error
