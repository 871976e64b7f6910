"""Blocks that people move, because the profile disables the gripper or moving blocks.

The cell says which block goes where and keeps its ledger as if it had done it itself.
"""

from __future__ import annotations

from cell.cleaning.grips import Grip
from cell.devices.gripper import Gripper, GripperState
from cell.errors import DeviceError
from cell.events import EventBus
from cell.ledger import Ledger
from cell.manipulation import Manipulator
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.reporting import FaultReporter
from cell.store import StorePlan, TablePlace


class LaidOutByPeople(Manipulator):
    """A `Manipulator` that asks people; nothing is waited for, the task goes on."""

    def __init__(
        self,
        arm: GuardedArm,
        gripper: Gripper,
        ledger: Ledger,
        plan: StorePlan,
        profile: Profile,
        events: EventBus,
    ) -> None:
        super().__init__(arm, gripper, ledger, plan, profile, events)
        self._reporter = FaultReporter(events)

    def transfer(self, slot: int, source: TablePlace | None, target: TablePlace | None) -> None:
        """Say which block to bring where, and note it as done."""
        entry = self._plan.slot(slot)
        where = "back into its slot" if target is None else f"to {_place(target)}"
        self._ledger.released(slot, target)
        self._reporter.skipped(
            "manipulation",
            f"bring the {entry.colour} {entry.kind} of {entry.block} {where} by hand",
        )

    def bring_home(self, slot: int, grip: Grip) -> None:
        """Say which block to put back, and note it as done."""
        self.transfer(slot, grip.place, None)

    def pick_up(self, place: TablePlace) -> int:
        """Refuse: nothing is gripped.

        Raises:
            DeviceError: Always.
        """
        raise _disabled()

    def put_down(self, place: TablePlace) -> None:
        """Refuse: nothing is held.

        Raises:
            DeviceError: Always.
        """
        raise _disabled()

    def feels_block(self, number: int) -> bool:
        """Refuse: there are no fingers to feel with.

        Raises:
            DeviceError: Always.
        """
        raise _disabled()

    def look_for_strays(self) -> list[int]:
        """Ask people to put lost blocks back; return their slots."""
        strays = list(self._ledger.strays())
        for number in strays:
            self.transfer(number, None, None)
        return strays

    def grip_problem(self, state: GripperState) -> str:
        """Find nothing wrong: no finger holds anything."""
        return ""

    def _recover(self) -> list[int]:
        """Leave a transfer that was open when the gripper was still in use to people."""
        transfer = self._ledger.open_transfer()
        if transfer is None:
            return []
        self.transfer(transfer.slot, transfer.source, None)
        return [transfer.slot]


def _place(place: TablePlace) -> str:
    return f"({place.x_mm:.0f}, {place.y_mm:.0f}) mm, turned {place.yaw_deg:.0f} deg,"


def _disabled() -> DeviceError:
    return DeviceError(
        "gripper",
        "moving blocks is disabled in the profile",
        hint="set gripper.enabled and manipulation.enabled to true",
    )
