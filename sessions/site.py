"""What a profile tells about where a program can run: reach and sight."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from calibration.demands import unmet_for_camera, unmet_for_lattice
from calibration.record import CalibrationRecord
from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import LatticeMap, Pose
from cell.kinematics import SixAxisArm
from cell.motion.guard import Guard
from cell.profile import Profile
from cell.store import StoreSlot, place_of_slot
from dsl.kinds import COLOURS
from dsl.program import Slot
from sessions.binding import camera_of

_PICTURE_PX = (1280, 960)
_GRIPPER_DOWN_DEG = 180.0


class ProfileSite:
    """Implements `dsl.site.Site` for a cell that is not switched on.

    A place is in reach when the arm can stand above it, gripper down, and go straight
    down to the laying height with a block between its fingers, by the same guard that
    passes motions when a task runs. A view sees a place when its camera's place or plane map
    puts the block's centre into the picture; cameras without either (they move with the arm, or
    are not calibrated) are taken to see everything.
    """

    def __init__(self, profile: Profile, calibrations: Sequence[CalibrationRecord] = ()) -> None:
        """Look at a cell.

        Args:
            profile: Its profile, with the calibrations in force.
            calibrations: The calibrations in force.
        """
        self._profile = profile
        self._calibrations = tuple(calibrations)
        self._arm = SixAxisArm.from_profile(profile.arm)
        self._guard = Guard.from_profile(profile)
        self._lattice = LatticeMap(
            step_mm=profile.lattice.step_mm,
            angle_deg=profile.lattice.angle_deg,
            origin_x_mm=profile.lattice.origin_mm[0],
            origin_y_mm=profile.lattice.origin_mm[1],
        )
        heights = profile.heights
        self._block_tops_mm = heights.surface_mm + max(
            block.height_mm for block in profile.blocks.values()
        )
        self._table_views = {
            name: camera.view(self._block_tops_mm) for name, camera in profile.cameras.items()
        }
        self._reached: dict[tuple[float, float, float], str | None] = {}

    @property
    def kinds(self) -> Collection[str]:
        """Kinds of blocks that the cell knows."""
        return tuple(self._profile.blocks)

    @property
    def colours(self) -> Collection[str]:
        """Colours of blocks that the cell knows."""
        return COLOURS

    def reach(self, x: int, y: int, travel_mm: float) -> str | None:
        """Say why the arm cannot get above a lattice point and down to it, or None."""
        return self._reach(*self._lattice.to_robot(x, y), self._block_tops_mm + travel_mm)

    def reach_slot(self, slot: Slot) -> str | None:
        """Say why the arm cannot take a block from a slot, or None."""
        place = place_of_slot(
            StoreSlot(
                number=slot.number,
                kind=slot.kind,
                colour=slot.colour,
                x_mm=slot.x_mm,
                y_mm=slot.y_mm,
            ),
            self._profile.store,
        )
        return self._reach(place.x_mm, place.y_mm, self._block_tops_mm)

    def sees(self, view: str, x: int, y: int) -> bool:
        """Whether a block on a lattice point is in a view; True where that varies."""
        table_view = self._table_views.get(camera_of(view))
        if table_view is None:
            return True
        point = np.array([self._lattice.to_robot(x, y)])
        try:
            ((u_px, v_px),) = table_view.to_picture(point, self._block_tops_mm)
        except ValueError:
            # Behind the camera, or on the horizon of its map.
            return False
        return bool(0 <= u_px <= _PICTURE_PX[0] - 1 and 0 <= v_px <= _PICTURE_PX[1] - 1)

    def has_camera(self, view: str) -> bool:
        """Whether the cell has a camera for a view."""
        return camera_of(view) in self._profile.cameras

    def lattice_accuracy(self, limit_mm: float) -> str | None:
        """Say why it is not known to a limit where the lattice lies, or None."""
        return unmet_for_lattice(limit_mm, self._calibrations)

    def view_accuracy(self, view: str, limit_mm: float) -> str | None:
        """Say why it is not known to a limit where a view shows the table, or None."""
        camera = camera_of(view)
        return unmet_for_camera(camera, limit_mm, self._profile, self._calibrations)

    def _reach(self, x_mm: float, y_mm: float, highest_mm: float) -> str | None:
        key = (x_mm, y_mm, max(highest_mm, self._profile.heights.service_mm))
        if key not in self._reached:
            self._reached[key] = self._tried(*key)
        return self._reached[key]

    def _tried(self, x_mm: float, y_mm: float, top_mm: float) -> str | None:
        arm = self._profile.arm
        above = Pose(x_mm, y_mm, top_mm, 180.0, 0.0, _GRIPPER_DOWN_DEG)
        try:
            start = self._arm.solve(above, arm.posture)
            self._guard.check_linear(
                start,
                above.at_height(self._profile.heights.laying_mm),
                posture=arm.posture,
                speed_mm_s=arm.linear_speed_mm_s,
                holds_block=True,
            )
        except (MotionRefused, UnreachablePose) as error:
            return str(error)
        return None
