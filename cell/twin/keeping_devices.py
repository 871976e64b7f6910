"""What television and cameras of the twin keep from one command by hand to the next.

It stands beside the kept world and not in it: recorded sessions begin with a world, and with
a television in standby. So it counts only as long as nobody else has written the world since;
a session puts the television into standby and the cameras to the profile's settings.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from cell.devices.camera import CameraSettings
from cell.errors import CellError, StateError
from cell.pictures import PICTURE_NAMES
from cell.twin.behind import Behind
from cell.twin.cameras.flea2 import KeptRegisters
from cell.twin.emulators.sharp_aquos.television import KeptTelevision

_FORMAT: Final = 1


@dataclass(frozen=True, kw_only=True)
class KeptCamera:
    """One camera.

    Attributes:
        settings: Those of the profile that it was set by; with others it begins anew.
        registers: What was set since.
    """

    settings: CameraSettings
    registers: KeptRegisters


@dataclass(frozen=True, kw_only=True)
class KeptDevices:
    """The fields of the file; `world` is the time stamp of the world it goes with, in ns."""

    format: int
    world: int
    picture: str
    television: KeptTelevision
    cameras: dict[str, KeptCamera]


_ADAPTER: TypeAdapter[KeptDevices] = TypeAdapter(KeptDevices)


class DevicesFile:
    """Keeps television and cameras in a file beside a world.

    Args:
        path: The file.
        world: The file of the world.
    """

    def __init__(self, path: Path, world: Path) -> None:
        self._path = path
        self._world = world

    def load_into(self, behind: Behind) -> None:
        """Put the devices into the kept state, if it goes with the world as it is.

        Raises:
            CellError: The file cannot be read or holds something else.
        """
        if not (self._path.is_file() and self._world.is_file()):
            return
        try:
            kept = _ADAPTER.validate_json(self._path.read_bytes())
            if kept.format != _FORMAT or kept.picture not in PICTURE_NAMES:
                raise ValueError(kept.format)
        except (OSError, ValueError, ValidationError) as error:
            raise CellError(
                f"{self._path} does not hold the twin's television and cameras; remove it to "
                "start with a television in standby"
            ) from error
        try:
            stamp = self._stamp()
        except OSError:
            return  # Without its world the file counts for nothing.
        if kept.world != stamp:
            return
        behind.world.set_picture(kept.picture)
        behind.television.restore(kept.television)
        for name, camera in kept.cameras.items():
            twin = behind.cameras.get(name)
            if twin is not None and twin.body.defaults == camera.settings:
                twin.body.registers.restore(camera.registers)

    def save(self, behind: Behind, now_s: float) -> None:
        """Write the devices, after the world was written.

        Raises:
            StateError: They cannot be written; what was kept before is still there.
        """
        try:
            self._save(behind, now_s)
        except OSError as error:
            raise StateError(
                f"the twin's television and cameras cannot be written to {self._path} "
                f"({error.strerror or error}); free space on its disk, give {self._path.parent} "
                "to the user who runs the cell, or move away a folder that has its name"
            ) from error

    def _save(self, behind: Behind, now_s: float) -> None:
        kept = KeptDevices(
            format=_FORMAT,
            world=self._stamp(),
            picture=_lasting(behind.world.sent_picture),
            television=behind.television.kept(now_s),
            cameras={
                name: KeptCamera(
                    settings=camera.body.defaults, registers=camera.body.registers.kept()
                )
                for name, camera in behind.cameras.items()
            },
        )
        fresh = self._path.with_suffix(".new")
        fresh.write_bytes(_ADAPTER.dump_json(kept))
        os.replace(fresh, self._path)

    def _stamp(self) -> int:
        return self._world.stat().st_mtime_ns


def _lasting(picture: str) -> str:
    """Return a picture that can be shown again by its name alone; patterns cannot."""
    return picture if picture in PICTURE_NAMES else "black"
