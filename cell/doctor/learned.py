"""What a healthy cell's pictures look like, kept for later comparison (`cell doctor --learn`)."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import MODES
from cell.errors import CellError
from cell.robot_cell import RobotCell

FOLDER = "learned"
LEARNING_MODE = MODES[0]
"""The smallest mode: every measure is taken at its size."""

_SHOWN = ("black", "white", "black")
"""What the screen shows meanwhile; what changes with it does not belong to what stands still."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LearnedPicture:
    """One camera's healthy pictures, lights on, the arm standing aside.

    Attributes:
        guid: The camera that took them.
        pixels: R G B, shape (pictures, height, width, 3), uint8.
    """

    guid: str
    pixels: NDArray[np.uint8]


def learn(cell: RobotCell) -> dict[str, LearnedPicture]:
    """Take the pictures of a healthy cell that is open.

    The arm stands aside, the lights are on, the screen shows black, white and black.

    Raises:
        MotionRefused: The arm may not stand aside from where it is.
        DeviceError: A device fails.
    """
    cell.arm.raise_to(cell.profile.heights.service_mm)
    cell.arm.rest()
    cell.switch_lights(is_on=True)
    taken: dict[str, list[NDArray[np.uint8]]] = {name: [] for name in cell.cameras}
    for picture in _SHOWN:
        cell.show(picture)
        for name, camera in cell.cameras.items():
            camera.open(LEARNING_MODE)
            try:
                taken[name].append(camera.grab_fresh().pixels)
            finally:
                camera.close()
    return {
        name: LearnedPicture(guid=cell.cameras[name].identity.guid, pixels=np.stack(pictures))
        for name, pictures in taken.items()
    }


def keep_learned(folder: Path, learned: Mapping[str, LearnedPicture]) -> None:
    """Write pictures into a state folder, in place of those kept before.

    Raises:
        CellError: They cannot be written.
    """
    place = folder / FOLDER
    try:
        place.mkdir(parents=True, exist_ok=True)
        for name, picture in learned.items():
            buffer = io.BytesIO()
            np.savez_compressed(buffer, guid=np.array(picture.guid), pixels=picture.pixels)
            fresh = place / f"{name}.new"
            fresh.write_bytes(buffer.getvalue())
            fresh.replace(place / f"{name}.npz")
    except OSError as error:
        raise CellError(f"the healthy pictures cannot be kept in {place}: {error}") from error


def load_learned(folder: Path | None) -> dict[str, LearnedPicture]:
    """Return the kept pictures by camera; none where there are none.

    Raises:
        CellError: A file is no kept picture.
    """
    learned: dict[str, LearnedPicture] = {}
    if folder is None:
        return learned
    for path in sorted((folder / FOLDER).glob("*.npz")):
        try:
            with np.load(path, allow_pickle=False) as kept:
                pixels = kept["pixels"]
                guid = str(kept["guid"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise CellError(
                f"{path} holds no picture that `cell doctor --learn` kept; remove it and learn anew"
            ) from error
        if pixels.ndim != 4 or pixels.shape[3] != 3 or pixels.dtype != np.uint8:
            raise CellError(f"{path} holds no colour pictures; remove it and learn anew")
        learned[path.stem] = LearnedPicture(guid=guid, pixels=pixels)
    return learned
