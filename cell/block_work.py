"""Laying out and cleaning up: what the cell does with blocks, with everything it has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cell.cleaning.cleaner import PictureCleaner
from cell.cleaning.look import Eyes
from cell.cleaning.pushes import PUSH_SPEED_MM_S
from cell.cleaning.report import CleaningPlan, PictureCleaning
from cell.errors import GripFailed, VisionError
from cell.ledger import Ledger
from cell.manipulation import Deployment, Manipulator, Progress, no_progress
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.recovery.watch import FaultWatch
from cell.store import StorePlan, TablePlace


class BlockWork:
    """Moves blocks under watch: whatever fails holds the arm.

    Args:
        profile: The cell's profile.
        arm: The arm.
        manipulator: Brings single blocks from place to place.
        ledger: Knows where the blocks are.
        plan: The store.
        eyes: Light, picture and cameras.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        arm: GuardedArm,
        manipulator: Manipulator,
        ledger: Ledger,
        plan: StorePlan,
        eyes: Eyes,
    ) -> None:
        self._profile = profile
        self._arm = arm
        self._manipulator = manipulator
        self._ledger = ledger
        self._plan = plan
        self._eyes = eyes
        self._watch = FaultWatch(arm)
        self._speed = (profile.arm.linear_speed_mm_s, profile.arm.joint_speed_percent)
        self._cleaner = PictureCleaner(
            profile,
            manipulator=manipulator,
            ledger=ledger,
            plan=plan,
            eyes=eyes,
            stand_aside=self._stand_aside,
            set_slow=lambda: arm.set_speed(PUSH_SPEED_MM_S, self._speed[1]),
            set_back=lambda: arm.set_speed(*self._speed),
        )

    def set_speed(self, speed_mm_s: float, joint_percent: float) -> None:
        """Set the speed of later moves; pushing is slower.

        Raises:
            MotionRefused: The speed is beyond the profile's limit.
        """
        self._arm.set_speed(speed_mm_s, joint_percent)
        self._speed = (speed_mm_s, joint_percent)

    def lay_out(self, deployments: Sequence[Deployment], progress: Progress = no_progress) -> None:
        """Bring blocks from their slots to their places; whatever is out is cleaned first.

        Raises:
            GripFailed: A block is not in its slot.
        """
        with self._watch.over("ledger"):
            if not self._manipulator.is_table_clean():
                self.clean(progress)
            self._manipulator.lay_out(deployments, progress)

    def clean(self, progress: Progress = no_progress) -> list[int]:
        """Bring every block that is out back to its slot, and stand aside.

        A block that fell from the fingers is looked for: first in its slot, where a person
        may have put it, then with the camera over the table.

        Returns:
            The slot numbers of the blocks brought home.

        Raises:
            GripFailed: A block is not where the ledger has it, or a lost one is not found.
        """
        home: list[int] = []
        with self._watch.over("ledger"):
            if not self._manipulator.is_table_clean():
                home = self._manipulator.clean(progress=progress)
            if self._ledger.strays():
                home += self._find_strays(progress)
        self._stand_aside()
        return home

    def clean_objects(self, slots: Sequence[int], progress: Progress = no_progress) -> list[int]:
        """Bring only the blocks of these slots home; return the slots of those brought."""
        with self._watch.over("ledger"):
            return self._manipulator.clean(slots, progress)

    def clean_from_picture(self, progress: Progress = no_progress) -> PictureCleaning:
        """Bring home every block that the top camera sees, wherever it was left.

        The arm stands aside for every look; the screen shows white, then black. Blocks that
        the fingers cannot grip are pushed apart.

        Raises:
            VisionError: No camera is mapped to the table, or screen or lights are off.
            DeviceError: A device fails.
        """
        with self._watch.over("ledger"):
            cleaning = self._cleaner.clean(progress)
        self._stand_aside()
        return cleaning

    def plan_from_picture(self) -> CleaningPlan:
        """Look as `clean_from_picture` does, and tell what it would do; no block is touched.

        Raises:
            VisionError: No camera is mapped to the table, or screen or lights are off.
            DeviceError: A device fails.
        """
        return self._cleaner.preview()

    def deploy(self, slot: int, place: TablePlace) -> None:
        """Bring one block from its slot to a place."""
        with self._watch.over("ledger"):
            self._manipulator.transfer(slot, None, place)

    def carry(self, slot: int, place: TablePlace) -> None:
        """Bring a block from wherever the ledger has it to a place.

        The fingers centre a block along the axis on which they close, and leave it as it is
        along the other. One that looks the same after a quarter turn is therefore gripped
        across the way it was put down: carried again and again, it does not creep along the
        fingers.
        """
        lies_at = self._ledger.blocks_out().get(slot)
        size = self._profile.blocks[self._plan.slot(slot).kind]
        if lies_at is not None and size.length_mm == size.width_mm:
            quarter = 90.0 if lies_at.yaw_deg <= 0.0 else -90.0
            lies_at = replace(lies_at, yaw_deg=lies_at.yaw_deg + quarter)
        with self._watch.over("ledger"):
            self._manipulator.transfer(slot, lies_at, place)

    def grip_at(self, place: TablePlace) -> int:
        """Grip the block at a place and lift it; return its slot number."""
        with self._watch.over("ledger"):
            return self._manipulator.pick_up(place)

    def release_at(self, place: TablePlace) -> None:
        """Put the gripped block down at a place."""
        with self._watch.over("ledger"):
            self._manipulator.put_down(place)

    def _stand_aside(self) -> None:
        self._arm.raise_to(self._profile.heights.service_mm)
        self._arm.rest()

    def _find_strays(self, progress: Progress) -> list[int]:
        home = self._manipulator.look_for_strays()
        if self._ledger.strays():
            picture = self._eyes.shown()
            try:
                home += self.clean_from_picture(progress).home
            except VisionError as error:
                raise GripFailed(f"{self._lost()} ({error})") from error
            finally:
                self._eyes.show(picture)
        if self._ledger.strays():
            raise GripFailed(self._lost())
        return home

    def _lost(self) -> str:
        blocks = ", ".join(self._plan.slot(number).block for number in self._ledger.strays())
        return (
            f"{blocks}: fell from the fingers and is not found; look around the table, put it "
            "into its slot by hand, then run `cell clean`"
        )
