"""The body of a twin's camera, which cables and places can be exchanged of, and its faults."""

from __future__ import annotations

from dataclasses import dataclass

from cell.devices.camera import CameraSettings
from cell.devices.camera_features import CameraIdentity
from cell.profile import CameraProfile
from cell.twin.cameras.flea2 import Flea2Registers


class CameraBody:
    """The metal: who it is, its registers, and the settings at which levels are nominal."""

    def __init__(self, name: str, device: CameraProfile) -> None:
        """Power a body up.

        Args:
            name: Name of the camera in the profile.
            device: Says which camera that is.
        """
        self.identity = CameraIdentity(model=device.model, guid=device.guid)
        self.registers = Flea2Registers(name)
        self.defaults: CameraSettings = device.settings


@dataclass(slots=True, kw_only=True)
class CameraFaults:
    """What is wrong with a camera of the twin.

    Attributes:
        is_frozen: It gives its last picture again.
        is_covered: No light reaches the lens.
        is_silent: It gives no picture.
        half_frames: So many of the next pictures are torn.
        defocus_px: Standard deviation of the blur at 1280 pixels across.
        knock_px: What it sees has moved by so much in the picture, at 1280 pixels across.
    """

    is_frozen: bool = False
    is_covered: bool = False
    is_silent: bool = False
    half_frames: int = 0
    defocus_px: float = 0.0
    knock_px: tuple[float, float] = (0.0, 0.0)
