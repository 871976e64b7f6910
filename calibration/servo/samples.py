"""What is measured for servo maps: where a marker on the gripper was seen after a command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cell.geometry import Pose, Transform
from cell.kinematics.servo_map import Five

Array = NDArray[np.float64]

JOINTS: Final = ("J1", "J2", "J3", "J4", "J5")


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """How a marker sits on the hand.

    Attributes:
        name: Its name, such as `back`.
        tool_from_marker: Its frame in the tool's, mm: x and y along its edges, z out of it.
    """

    name: str
    tool_from_marker: Transform


BACK: Final = Mount(
    name="back", tool_from_marker=Transform.from_pose(Pose(0.0, 0.0, -40.0, 180.0, 0.0, 0.0))
)
"""Behind the fingers, facing back along the hand: seen from above with the hand pointing down."""
TOP: Final = Mount(
    name="top", tool_from_marker=Transform.from_pose(Pose(25.0, 0.0, -30.0, 0.0, 90.0, 0.0))
)
"""On the hand's upper side: seen from above with the hand level."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """One pose of the arm, as the camera saw it.

    Attributes:
        label: Its name, such as `sight 12`.
        commanded_deg: What J1 to J5 were told.
        seen: The marker in the robot frame.
        mount: Name of the marker's mount.
        came_from: Joint that moved last and which way: `+2` for J2 upwards, `-3` for J3
            downwards; 0 if it is not known. Backlash shows in it.
    """

    label: str
    commanded_deg: Five
    seen: Pose
    mount: str = "back"
    came_from: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkerNoise:
    """How exactly a marker is seen from above: standard deviations.

    The fit finds out how large they are together; only their ratios are taken as given.

    Attributes:
        place_mm: In x and y.
        height_mm: In z, along the view; None where heights are not to be used.
        yaw_deg: Turn about the vertical.
        tilt_deg: Lean about either horizontal axis; None where leans are not to be used.
    """

    place_mm: float = 0.4
    height_mm: float | None = 2.0
    yaw_deg: float = 0.4
    tilt_deg: float | None = 1.5

    @property
    def units(self) -> Array:
        """One over the deviations of x, y, z (mm), turns about x, y, z (rad); 0 if unused."""
        tilt = 0.0 if self.tilt_deg is None else 1.0 / np.radians(self.tilt_deg)
        height = 0.0 if self.height_mm is None else 1.0 / self.height_mm
        place = 1.0 / self.place_mm
        return np.array([place, place, height, tilt, tilt, 1.0 / np.radians(self.yaw_deg)])

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which of the six are used."""
        used: NDArray[np.bool_] = self.units > 0.0
        return used
