"""What a camera's pictures tell: stuck, dark, too bright, soft, moved. Lights on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import Camera
from cell.doctor.learned import LearnedPicture
from cell.doctor.notes import Notes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """Two pictures of one camera, one right after the other.

    Attributes:
        camera: Name of the camera.
        guid: Who it is.
        first: R G B, uint8.
        second: The same of the second picture.
    """

    camera: str
    guid: str
    first: NDArray[np.uint8]
    second: NDArray[np.uint8]


def look_through(name: str, guid: str, camera: Camera) -> Look:
    """Take two pictures that the camera really takes.

    Raises:
        DeviceError: It gives none.
    """
    first = camera.grab_fresh().pixels
    return Look(camera=name, guid=guid, first=first, second=camera.grab_fresh().pixels)


def judge_pictures(
    looks: Sequence[Look],
    cameras: set[str],
    learned: Mapping[str, LearnedPicture],
    notes: Notes,
    *,
    dark_because: str,
) -> None:
    """Judge."""
