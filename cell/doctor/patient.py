"""What the doctor looks at: the parts of a cell, each reachable without bringing the cell up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from cell.clock import Clock
from cell.devices.camera import Camera
from cell.ledger import Ledger
from cell.links.base import Link
from cell.profile import Profile
from cell.robot_cell import RobotCell
from cell.store import StorePlan

OpenLine = Callable[[], Link]
"""Opens a device's line for the doctor, who closes it.

Raises:
    LinkError: The line cannot be opened.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Patient:
    """A cell as the doctor meets it.

    Attributes:
        profile: The cell's profile.
        plan: The store of the script that is served in the cell.
        clock: What deadlines are measured with.
        lines: How to open the line of each serial device: `arm`, `gripper`, `display`.
        cameras: The cameras by name, closed.
        ledger: Where the blocks are; None where the ledger cannot be opened.
        is_in_service: Whether the devices are up: then they are expected to be on.
        lattice: Columns and rows of the widest world that is played.
        views: Names of the cameras that the script's views need.
        riding_cameras: Names of the cameras that hang on the arm.
    """

    profile: Profile
    plan: StorePlan
    clock: Clock
    lines: Mapping[str, OpenLine]
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    ledger: Ledger | None = None
    is_in_service: bool = False
    lattice: tuple[int, int] = (12, 12)
    views: tuple[str, ...] = ()
    riding_cameras: tuple[str, ...] = ()

    @staticmethod
    def of_cell(
        cell: RobotCell,
        lines: Mapping[str, OpenLine],
        *,
        lattice: tuple[int, int] = (12, 12),
        views: tuple[str, ...] = (),
    ) -> Patient:
        """Return an assembled cell as a patient.

        Args:
            cell: The cell, open or not.
            lines: How to open the line of each serial device.
            lattice: Columns and rows of the widest world that is played.
            views: Names of the cameras that the script's views need.
        """
        return Patient(
            profile=cell.profile,
            plan=cell.plan,
            clock=cell.clock,
            lines=lines,
            cameras=cell.cameras,
            ledger=cell.ledger,
            is_in_service=cell.is_open,
            lattice=lattice,
            views=views,
            riding_cameras=tuple(
                name
                for name, camera in cell.profile.twin.cameras.items()
                if camera.mount == "flange"
            ),
        )
