"""The picture that the computer sends to the twin's television."""

from __future__ import annotations

from cell.errors import DeviceError
from cell.pictures import PICTURE_NAMES
from cell.twin.world import World


class TwinScreen:
    """A `cell.devices.display.Screen` whose panel is the twin's."""

    def __init__(self, world: World) -> None:
        self._world = world

    def show(self, picture: str) -> None:
        """Show one of the pictures of `cell.pictures`."""
        if picture not in PICTURE_NAMES:
            known = ", ".join(PICTURE_NAMES)
            raise DeviceError("screen", f"knows no picture {picture!r}", hint=f"use {known}")
        self._world.set_picture(picture)

    def shown(self) -> str:
        """Return the name of the picture that was shown last."""
        return self._world.sent_picture
