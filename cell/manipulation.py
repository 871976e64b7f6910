"""Moving blocks: grip, release, lay out, clean up, each noted in the ledger.

A block is gripped from above: over it at the service height, straight down to
the laying height, close, straight up. Putting down is the same backwards. Whether the
fingers still hold it is looked at when it is up, and before they let it go.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cell.cleaning.grips import Grip, beside
from cell.cleaning.pushes import PUSH_OPENING_MM
from cell.devices.gripper import Gripper, GripperState
from cell.errors import DeviceError, GripFailed, MotionRefused, StoreError, UnreachablePose
from cell.events import BlockGripped, BlockReleased, EventBus, MotionRejected
from cell.geometry import JointPositions, Pose
from cell.ledger import Ledger, Transfer
from cell.motion.guarded import GuardedArm
from cell.profile import Profile
from cell.store import StorePlan, StoreSlot, TablePlace, place_of_slot

WIDTH_TOLERANCE_MM = 2.5
"""How far a gripped width may differ from the block's (fingers and faces give a little)."""

NEAR_MM = 10.0
"""How far a place may be from where the ledger has a block to mean that block."""

_BACK_MM = 3.0

Progress = Callable[[str, int, int], None]
"""Told what is done now, how many of it are done, and how many there are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Deployment:
    """One block of the store, and where it shall lie in the robot frame."""

    slot: int
    x_mm: float
    y_mm: float
    yaw_deg: float = 0.0

    @property
    def place(self) -> TablePlace:
        """The place alone."""
        return TablePlace(x_mm=self.x_mm, y_mm=self.y_mm, yaw_deg=self.yaw_deg)


def no_progress(what: str, done: int, total: int) -> None:
    """Tell nobody."""


class Manipulator:
    """Brings blocks from place to place and keeps the ledger true."""

    def __init__(
        self,
        arm: GuardedArm,
        gripper: Gripper,
        ledger: Ledger,
        plan: StorePlan,
        profile: Profile,
        events: EventBus,
    ) -> None:
        self._arm = arm
        self._gripper = gripper
        self._ledger = ledger
        self._plan = plan
        self._profile = profile
        self._events = events
        # Nobody knows what an earlier program did with the fingers.
        self._may_have_closed = True

    def slot_place(self, number: int) -> TablePlace:
        """Return where a slot lies in the robot frame.

        Raises:
            StoreError: There is no such slot.
        """
        return place_of_slot(self._plan.slot(number), self._profile.store)

    def pick_up(self, place: TablePlace) -> int:
        """Grip the block that the ledger has at a place, and lift it.

        Until `put_down` the transfer stays open: after a crash `clean` brings it home.

        Returns:
            The number of the block's slot.

        Raises:
            StoreError: The ledger knows no block there.
            GripFailed: There is none, or another one.
        """
        number = self._block_at(place)
        source = self._ledger.blocks_out().get(number)
        entry = self._plan.slot(number)
        self._ledger.plan(number, source, source)
        try:
            self._grip(source or self.slot_place(number), entry)
        except GripFailed:
            self._abandon_untouched()
            raise
        return number

    def put_down(self, place: TablePlace) -> None:
        """Put the block that `pick_up` gripped down at a place.

        Raises:
            GripFailed: No block was picked up.
        """
        transfer = self._ledger.open_transfer()
        if transfer is None or transfer.phase == "planned":
            raise GripFailed("the fingers hold no block that could be put down")
        entry = self._plan.slot(transfer.slot)
        own = self.slot_place(entry.number)
        is_home = math.hypot(own.x_mm - place.x_mm, own.y_mm - place.y_mm) < NEAR_MM
        self._put_down(entry, None if is_home else place)

    def _block_at(self, place: TablePlace) -> int:
        out = self._ledger.blocks_out()
        for slot in self._plan.slots:
            there = out.get(slot.number) or self.slot_place(slot.number)
            if math.hypot(there.x_mm - place.x_mm, there.y_mm - place.y_mm) < NEAR_MM:
                return slot.number
        raise StoreError(
            f"the ledger has no block within {NEAR_MM:.0f} mm of "
            f"({place.x_mm:.1f}, {place.y_mm:.1f}) mm"
        )

    def feels_block(self, number: int) -> bool:
        """Return whether the fingers meet a block in a slot; it is left there."""
        place = self.slot_place(number)
        self._gripper.move_to(self._profile.gripper.open_mm)
        self._approach(place, holds_block=False)
        result = self._gripper.grip(self._profile.gripper.grip_current_a)
        self._gripper.move_to(self._profile.gripper.open_mm)
        self._lift(place, holds_block=False)
        return result.is_holding

    def transfer(self, slot: int, source: TablePlace | None, target: TablePlace | None) -> None:
        """Bring a block from a place to a place; None stands for its own slot.

        Raises:
            GripFailed: It was not where it should be; the table is as before.
            MotionRefused: The arm may not go to the target; nothing was touched.
        """
        entry = self._plan.slot(slot)
        if target is not None:
            self._require_way(source or self.slot_place(slot), target)
        self._ledger.plan(slot, source, target)
        try:
            self._grip(source or self.slot_place(slot), entry)
        except GripFailed:
            self._abandon_untouched()
            raise
        self._put_down(entry, target)

    def bring_home(self, slot: int, grip: Grip) -> None:
        """Bring the block that a grip was chosen for to a slot.

        A grip beside the block's middle is put down as far beside the slot's.

        Raises:
            GripFailed: It was not where it should be, or was lost on the way.
            MotionRefused: The arm may not go there; the block is where it was.
        """
        entry = self._plan.slot(slot)
        self._ledger.plan(slot, grip.place, None)
        try:
            self._grip(grip.tool_place, entry, grip.opening_mm)
        except (GripFailed, MotionRefused, UnreachablePose):
            self._abandon_untouched()
            raise
        self._put_down(entry, None, grip.along_mm)

    def recover(self) -> list[int]:
        """Close a transfer that a crash left open; return the slots whose blocks went home.

        Raises:
            ResumeRefused: Nothing may move yet.
        """
        return self._recover()

    def push(
        self,
        start: TablePlace,
        end: TablePlace,
        set_slow: Callable[[], None],
        set_back: Callable[[], None],
    ) -> None:
        """Push along whatever lies between two places with closed fingers, low.

        Args:
            start: Where the fingers come down.
            end: Where they stop; they go a little back before they go up.
            set_slow: Sets the speed of pushing; called when the fingers are down.
            set_back: Sets the speed of other moves again.

        Raises:
            MotionRefused: The arm may not go there.
        """
        self._gripper.move_to(PUSH_OPENING_MM)
        self._approach(start, holds_block=False)
        back = _back(start, end)
        set_slow()
        try:
            low = self._profile.heights.laying_mm
            self._arm.move_linear(self._over(end, low))
            self._arm.move_linear(self._over(back, low))
        finally:
            set_back()
        self._lift(back, holds_block=False)
        self._gripper.move_to(self._profile.gripper.open_mm)

    def can_reach(self, place: TablePlace) -> bool:
        """Return whether the guard lets the empty hand down to a place of the tool."""
        try:
            self._way_down(JointPositions(self._profile.arm.rest_deg), place, holds_block=False)
        except (MotionRefused, UnreachablePose):
            return False
        return True

    def can_push(self, start: TablePlace, end: TablePlace) -> bool:
        """Return whether the guard lets the fingers go low from one place to another."""
        arm = self._profile.arm
        try:
            rest = JointPositions(arm.rest_deg)
            down = self._way_down(rest, start, holds_block=False)
            self._arm.guard.check_linear(
                down,
                self._over(end, self._profile.heights.laying_mm),
                posture=arm.posture,
                speed_mm_s=arm.linear_speed_mm_s,
            )
        except (MotionRefused, UnreachablePose):
            return False
        return True

    def _require_way(self, source: TablePlace, target: TablePlace) -> None:
        """Have the guard pass the way to a target before anything is touched.

        Raises:
            MotionRefused: The arm may not go there.
            UnreachablePose: It cannot.
        """
        arm = self._profile.arm
        try:
            over_source = self._arm.guard.check_pose_joint(
                JointPositions(arm.rest_deg),
                self._over(source, self._profile.heights.service_mm),
                posture=arm.posture,
                percent=arm.joint_speed_percent,
                holds_block=True,
            )
            self._way_down(over_source.end, target, holds_block=True)
        except (MotionRefused, UnreachablePose) as refusal:
            self._events.emit(MotionRejected(str(refusal)))
            raise

    def _way_down(
        self, start: JointPositions, place: TablePlace, *, holds_block: bool
    ) -> JointPositions:
        """Have the guard check the way over a place and down; return the joints there."""
        arm, heights = self._profile.arm, self._profile.heights
        over = self._arm.guard.check_pose_joint(
            start,
            self._over(place, heights.service_mm),
            posture=arm.posture,
            percent=arm.joint_speed_percent,
            holds_block=holds_block,
        )
        down = self._arm.guard.check_linear(
            over.end,
            self._over(place, heights.laying_mm),
            posture=arm.posture,
            speed_mm_s=arm.linear_speed_mm_s,
            holds_block=holds_block,
        )
        return down.end

    def _abandon_untouched(self) -> None:
        """Close a transfer whose block was never gripped; a lost one has no transfer any more."""
        if self._ledger.open_transfer() is not None:
            self._ledger.abandon()

    def lay_out(self, deployments: Sequence[Deployment], progress: Progress = no_progress) -> None:
        """Bring each block from its slot to its place."""
        for done, deployment in enumerate(deployments):
            progress("laying out", done, len(deployments))
            self.transfer(deployment.slot, None, deployment.place)
        progress("laying out", len(deployments), len(deployments))

    def clean(
        self, slots: Sequence[int] | None = None, progress: Progress = no_progress
    ) -> list[int]:
        """Bring blocks that are out back to their slots, also after a crash.

        Args:
            slots: Only these; all that are out unless given.
            progress: Told before each block.

        Returns:
            The slot numbers of the blocks brought home.

        Raises:
            GripFailed: One or more were not where the ledger has them; all others
                are home.
        """
        home = self._recover()
        out = {n: p for n, p in self._ledger.blocks_out().items() if slots is None or n in slots}
        missing: list[str] = []
        for done, (slot, place) in enumerate(out.items()):
            progress("putting back", done, len(out))
            try:
                self.transfer(slot, place, None)
                home.append(slot)
            except GripFailed as failure:
                missing.append(str(failure))
        progress("putting back", len(out), len(out))
        if missing:
            raise GripFailed("; ".join(missing))
        return home

    def is_table_clean(self) -> bool:
        """Return whether the ledger has every block in its slot and none in the fingers."""
        ledger = self._ledger
        return not (ledger.blocks_out() or ledger.open_transfer() or ledger.strays())

    def may_hold_block(self) -> bool:
        """Return whether, by the ledger, a block may be between the fingers."""
        transfer = self._ledger.open_transfer()
        return transfer is not None and (transfer.phase != "planned" or self._may_have_closed)

    def grip_problem(self, state: GripperState) -> str:
        """Hold a gripper's state against the ledger; return what does not fit, or nothing.

        A block that the fingers should hold and do not is noted as lost: that is a fact then,
        and nothing that keeps the arm from moving.
        """
        transfer = self._ledger.open_transfer()
        if transfer is None:
            if state.current_a and not state.is_moving:
                return "the fingers hold something the ledger knows nothing of: take it out by hand"
            return ""
        entry = self._plan.slot(transfer.slot)
        if transfer.phase == "gripped" and state.is_referenced and not self._fits(state, entry):
            self._ledger.lost(entry.number)
        return ""

    def look_for_strays(self) -> list[int]:
        """Feel the slots of lost blocks: a person may have put one back; return those found."""
        found = [number for number in self._ledger.strays() if self.feels_block(number)]
        for number in found:
            self._ledger.released(number, None)
        return found

    def _grip(self, place: TablePlace, entry: StoreSlot, opening_mm: float | None = None) -> None:
        """Grip the block that lies at a place and lift it to the service height.

        Args:
            place: Where the middle between the fingers goes.
            entry: The block's slot.
            opening_mm: How far open the fingers come down, None for the profile's opening.

        Raises:
            GripFailed: The fingers closed on nothing, or on something of another width, or
                lost the block while it was lifted.
        """
        kind, name = entry.kind, entry.block
        opening_mm = self._profile.gripper.open_mm if opening_mm is None else opening_mm
        self._may_have_closed = False
        self._gripper.move_to(opening_mm)
        self._approach(place, holds_block=False)
        self._may_have_closed = True
        result = self._gripper.grip(self._profile.gripper.grip_current_a)
        width_mm = self._profile.blocks[kind].width_mm
        if not result.is_holding or abs(result.width_mm - width_mm) > WIDTH_TOLERANCE_MM:
            self._gripper.move_to(opening_mm)
            self._lift(place, holds_block=False)
            found = f"something {result.width_mm:.1f} mm wide" if result.is_holding else "nothing"
            raise GripFailed(
                f"{name}: expected a {kind} ({width_mm:.0f} mm) at "
                f"({place.x_mm:.1f}, {place.y_mm:.1f}) mm, the fingers found {found}; "
                "put the block into its slot by hand"
            )
        self._ledger.gripped()
        self._events.emit(BlockGripped(name, result.width_mm))
        self._lift(place, holds_block=True)
        self._require_held(entry)

    def _release(self, place: TablePlace, entry: StoreSlot) -> None:
        """Put the held block down at a place; the fingers stay there, open.

        Raises:
            GripFailed: The block was lost on the way.
        """
        self._approach(place, holds_block=True)
        self._require_held(entry)
        self._ledger.placing()
        self._gripper.move_to(self._profile.gripper.open_mm)
        self._events.emit(BlockReleased(entry.block, place.x_mm, place.y_mm, place.yaw_deg))

    def _require_held(self, entry: StoreSlot) -> None:
        """Return if the fingers hold a block; one that is gone is noted as lost.

        Raises:
            GripFailed: It is gone; the arm is held.
            DeviceError: The gripper cannot tell, because it was without power; likewise.
        """
        state = self._gripper.read_state()
        if not state.is_referenced:
            raise self._arm.fail(
                "gripper",
                DeviceError(
                    "gripper",
                    f"was without power while it held {entry.block}'s {entry.kind}",
                    hint="the next command that moves puts it down at home",
                ),
            )
        if not self._fits(state, entry):
            self._ledger.lost(entry.number)
            raise self._arm.fail("gripper", GripFailed(_lost(entry)))

    def _fits(self, state: GripperState, entry: StoreSlot) -> bool:
        width_mm = self._profile.blocks[entry.kind].width_mm
        return abs(state.position_mm - width_mm) <= WIDTH_TOLERANCE_MM

    def _recover(self) -> list[int]:
        """Close a transfer that a crash left open; return the slots whose blocks went home.

        Fingers that stand open hold nothing. Otherwise they are closed where they
        are: they hold the block exactly when they meet something of its width. Fingers
        that do not know their zero, after a loss of power, can only be opened wide: over
        the block's own slot when they may hold it, else where they are.
        """
        self._arm.ensure_clear()
        transfer = self._ledger.open_transfer()
        if transfer is None:
            return []
        entry = self._plan.slot(transfer.slot)
        if not self._gripper.read_state().is_referenced:
            return self._recover_unreferenced(transfer, entry)
        if self._holds(entry):
            self._ledger.gripped()
            self._put_down(entry, None)
            return [entry.number]
        self._settle(transfer)
        return []

    def _recover_unreferenced(self, transfer: Transfer, entry: StoreSlot) -> list[int]:
        if transfer.phase != "gripped":
            self._gripper.reference()
            self._settle(transfer)
            return []
        home = self.slot_place(entry.number)
        self._approach(home, holds_block=True)
        self._gripper.reference()
        self._ledger.released(entry.number, None)
        self._lift(home, holds_block=False)
        if self.feels_block(entry.number):
            return [entry.number]
        self._ledger.lost(entry.number)
        return []

    def _holds(self, entry: StoreSlot) -> bool:
        gripper = self._profile.gripper
        if self._gripper.read_state().position_mm > gripper.open_mm - WIDTH_TOLERANCE_MM:
            return False
        result = self._gripper.grip(gripper.grip_current_a)
        width_mm = self._profile.blocks[entry.kind].width_mm
        if result.is_holding and abs(result.width_mm - width_mm) <= WIDTH_TOLERANCE_MM:
            return True
        self._gripper.move_to(gripper.open_mm)
        return False

    def _settle(self, transfer: Transfer) -> None:
        """Write where the block of an open transfer lies, now that no finger holds it."""
        match transfer.phase:
            case "planned":
                self._ledger.abandon()
            case "gripped":
                self._ledger.lost(transfer.slot)
            case "placing":
                self._ledger.released(transfer.slot, transfer.target)

    def _put_down(self, entry: StoreSlot, target: TablePlace | None, along_mm: float = 0.0) -> None:
        """Put the held block down; `along_mm` is how far beside its middle it is held."""
        place = beside(target or self.slot_place(entry.number), along_mm)
        self._release(place, entry)
        self._ledger.released(entry.number, target)
        self._lift(place, holds_block=False)

    def _approach(self, place: TablePlace, *, holds_block: bool) -> None:
        heights = self._profile.heights
        self._arm.raise_to(heights.service_mm, holds_block=holds_block)
        self._arm.move_joint(self._over(place, heights.service_mm), holds_block=holds_block)
        self._arm.move_linear(self._over(place, heights.laying_mm), holds_block=holds_block)

    def _lift(self, place: TablePlace, *, holds_block: bool) -> None:
        over = self._over(place, self._profile.heights.service_mm)
        self._arm.move_linear(over, holds_block=holds_block)

    @staticmethod
    def _over(place: TablePlace, z_mm: float) -> Pose:
        """Return the pose that grips a block at a place: fingers across its width."""
        turn = (place.yaw_deg + 90.0) % 180.0 - 90.0
        c_deg = 180.0 + turn if turn <= 0 else turn - 180.0
        return Pose(place.x_mm, place.y_mm, z_mm, 180.0, 0.0, c_deg)


def _back(start: TablePlace, end: TablePlace) -> TablePlace:
    """Return a place a little back from the end of a way, where the fingers go up free."""
    dx, dy = start.x_mm - end.x_mm, start.y_mm - end.y_mm
    share = min(1.0, _BACK_MM / (math.hypot(dx, dy) or 1.0))
    return TablePlace(x_mm=end.x_mm + share * dx, y_mm=end.y_mm + share * dy, yaw_deg=end.yaw_deg)


def _lost(entry: StoreSlot) -> str:
    return (
        f"{entry.block}: lost on the way: the fingers hold its {entry.kind} no longer; "
        "it is looked for when the table is cleaned"
    )
