"""The language's host over a cell: from lattice points to millimetres."""

from __future__ import annotations

from collections.abc import Sequence

from cell.geometry import LatticeMap
from cell.manipulation import Deployment
from cell.profile import Profile
from dsl.host import Placement
from sessions.desk import ServedCell
from sessions.errors import ScriptUnservable
from sessions.script import Script

CAMERA_PREFIX = "CAMERA_"


class CellHost:
    """Carries out what a task asks for on a cell."""

    def __init__(self, cell: ServedCell, profile: Profile) -> None:
        lattice = profile.lattice
        self._cell = cell
        self._lattice = LatticeMap(
            step_mm=lattice.step_mm,
            angle_deg=lattice.angle_deg,
            origin_x_mm=lattice.origin_mm[0],
            origin_y_mm=lattice.origin_mm[1],
        )
        self._block_tops_mm = profile.heights.surface_mm + max(
            block.height_mm for block in profile.blocks.values()
        )
        self._x = self._y = 0
        self._blocks_out = 0

    @property
    def x(self) -> int:
        """Lattice x of the point that was moved to last."""
        return self._x

    @property
    def y(self) -> int:
        """Lattice y of the point that was moved to last."""
        return self._y

    @property
    def blocks_out(self) -> int:
        """How many blocks were laid out last."""
        return self._blocks_out

    def show(self, picture: str) -> None:
        """Show the background picture on the screen under the playground."""
        self._cell.show(picture)

    def lay_out(self, placements: Sequence[Placement]) -> None:
        """Bring each block from its store slot to its lattice point."""
        self._cell.lay_out([self._deployment(placement) for placement in placements])
        self._blocks_out = len(placements)

    def move_to(self, x: int, y: int, travel_mm: float) -> None:
        """Bring the gripper over a lattice point, `travel_mm` above the block tops."""
        x_mm, y_mm = self._lattice.to_robot(x, y)
        self._cell.move_to(x_mm, y_mm, self._block_tops_mm + travel_mm)
        self._x, self._y = x, y

    def _deployment(self, placement: Placement) -> Deployment:
        x_mm, y_mm = self._lattice.to_robot(placement.x, placement.y)
        # A block unturned on the lattice has its width, which the fingers grip, along lattice
        # x; unturned in the robot frame it has it along robot y, which is 90 deg from robot x.
        turn_deg = placement.yaw_deg + self._lattice.angle_deg - 90.0
        yaw_deg = (turn_deg + 180.0) % 360.0 - 180.0
        return Deployment(slot=placement.slot, x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg)


def camera_of(view: str) -> str:
    """Return the name of the camera behind a view: `CAMERA_TOP` is `top`."""
    return view.removeprefix(CAMERA_PREFIX).lower()


def check_servable(script: Script, profile: Profile) -> None:
    """Return if the cell has every camera that the script's views need.

    Raises:
        ScriptUnservable: It has not; the text names the view and the cameras there are.
    """
    for goal in script.goals:
        for environment in script.environments(goal):
            for view in script.task(goal, environment).views:
                if camera_of(view.name) not in profile.cameras:
                    raise ScriptUnservable(
                        f"{script.name}: environment {environment} has the view {view.name}, but "
                        f"the cell {profile.name} has no camera {camera_of(view.name)!r}; "
                        f"it has {', '.join(profile.cameras)}"
                    )
