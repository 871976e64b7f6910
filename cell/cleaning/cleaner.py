"""Cleans the table by what the camera sees: look, grip what is free, push apart, look again.

Everything is decided from the last look. As long as each grip does what was planned, the
blocks are taken one after the other without looking again; after a push, a failed grip or a
lost block nothing is believed any more and the arm stands aside for new pictures. The last
look proves that the table is clean. The number of looks is bounded, and a round that changes
nothing ends the work with a sentence for every block that is left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from cell.cleaning.grips import GripPlanner, Step, plan_removal
from cell.cleaning.look import Eyes, Look, look
from cell.cleaning.lumps import lumps
from cell.cleaning.pushes import Field, Push, PushPlanner
from cell.cleaning.report import CleaningPlan, PictureCleaning, SeenOne
from cell.cleaning.sight import LyingBlock, Playground
from cell.cleaning.slots import FreeSlots
from cell.contact import Body, Point
from cell.errors import GripFailed, MotionRefused, StoreError, UnreachablePose
from cell.ledger import Ledger
from cell.manipulation import Manipulator, Progress
from cell.profile import DisplayProfile, Profile
from cell.store import StorePlan

_TRIES = 3
_SPARE_LOOKS = 4
_LOOKS_PER_BLOCK = 2
_MOVED_MM = 4.0
_FIELD_INSET_MM = 25.0


@dataclass(slots=True)
class _State:
    """What was done so far and what did not work."""

    home: list[int] = field(default_factory=list)
    pushes: list[tuple[Point, Point]] = field(default_factory=list)
    idle_pushes: list[tuple[Point, Point]] = field(default_factory=list)
    failures: list[tuple[LyingBlock, str]] = field(default_factory=list)
    looks: int = 0


class PictureCleaner:
    """Brings home what the top camera sees.

    Args:
        profile: The cell's profile.
        manipulator: Brings single blocks from place to place.
        ledger: Knows where the blocks are.
        plan: The store.
        eyes: Light, picture and camera.
        stand_aside: Brings the arm out of the camera's way.
        set_slow: Sets the speed of pushing.
        set_back: Sets the speed of other moves again.
    """

    def __init__(
        self,
        profile: Profile,
        *,
        manipulator: Manipulator,
        ledger: Ledger,
        plan: StorePlan,
        eyes: Eyes,
        stand_aside: Callable[[], None],
        set_slow: Callable[[], None],
        set_back: Callable[[], None],
    ) -> None:
        self._profile = profile
        self._manipulator = manipulator
        self._slots = FreeSlots(manipulator, ledger, plan)
        self._ledger = ledger
        self._plan = plan
        self._eyes = eyes
        self._stand_aside = stand_aside
        self._set_slow = set_slow
        self._set_back = set_back
        self._grips = GripPlanner(profile.gripper, manipulator.can_reach)
        self._pushes = PushPlanner(
            profile.gripper,
            self._grips,
            screen_field(profile.display),
            may_go=manipulator.can_push,
            may_lie=manipulator.can_reach,
        )

    def preview(self) -> CleaningPlan:
        """Look, and return what would be done; no block is touched."""
        self._stand_aside()
        return self._planned(look(self._profile, self._eyes), ())

    def clean(self, progress: Progress) -> PictureCleaning:
        """Bring everything home that can be.

        Raises:
            VisionError: No camera is mapped to the table, or screen or lights are off.
            DeviceError: A device fails.
        """
        state = _State(home=list(self._manipulator.recover()))
        view = self._look(state)
        first = self._planned(view, ())
        total = len(self._lying(view.playground)) + len(view.playground.strange)
        most_looks = _SPARE_LOOKS + _LOOKS_PER_BLOCK * total
        progress("putting back", 0, total)
        while state.looks < most_looks and self._round(view.playground, state, progress, total):
            before, view = view, self._look(state)
            self._judge_push(before.playground, view.playground, state)
        progress("putting back", len(state.home), max(total, len(state.home)))
        left = self._left(view, state)
        return PictureCleaning(
            home=tuple(state.home),
            left=left,
            pushes=len(state.pushes),
            looks=state.looks,
            plan=first,
            last=view,
        )

    def _look(self, state: _State) -> Look:
        self._stand_aside()
        state.looks += 1
        view = look(self._profile, self._eyes)
        self._slots.note(self._lying(view.playground))
        return view

    def _lying(self, ground: Playground) -> list[LyingBlock]:
        return [block for block in ground.blocks if not self._slots.is_home(block)]

    def _round(self, ground: Playground, state: _State, progress: Progress, total: int) -> bool:
        """Do what the last look allows; return whether anything was tried."""
        todo, obstacles = self._split(ground, state)
        if not todo:
            return self._push_lump(ground, state)
        steps = plan_removal(todo, obstacles, self._grips).steps
        if not steps:
            return self._push(todo, obstacles, state) or self._push_lump(ground, state)
        for step in steps:
            progress("putting back", len(state.home), max(total, len(state.home) + 1))
            if not self._take(step, state):
                break
        return True

    def _split(self, ground: Playground, state: _State) -> tuple[list[LyingBlock], list[Body]]:
        """Return the blocks to bring home, and everything that must not be touched."""
        todo: list[LyingBlock] = []
        obstacles: list[Body] = [*ground.obstacles]
        for block in ground.blocks:
            if self._slots.is_home(block) or len(self._failures(block, state)) >= _TRIES:
                obstacles.append(block.body)
            else:
                todo.append(block)
        return todo, obstacles

    @staticmethod
    def _failures(block: LyingBlock, state: _State) -> list[str]:
        return [
            why
            for failed, why in state.failures
            if (failed.kind, failed.colour) == (block.kind, block.colour)
            and _way_mm(failed, block) < _MOVED_MM
        ]

    def _take(self, step: Step, state: _State) -> bool:
        """Bring one block home; return whether all is as planned."""
        try:
            slot = self._slots.slot_for(step.block)
        except StoreError as error:
            state.failures += [(step.block, str(error))] * _TRIES
            return False
        try:
            self._manipulator.bring_home(slot, step.grip)
        except (GripFailed, MotionRefused, UnreachablePose) as error:
            state.failures.append((step.block, str(error)))
            return False
        self._slots.filled(slot)
        state.home.append(slot)
        return True

    def _push(self, todo: Sequence[LyingBlock], obstacles: Sequence[Body], state: _State) -> bool:
        push = self._pushes.best(todo, obstacles, state.idle_pushes)
        if push is None:
            return False
        state.pushes.append(_ends(push))
        try:
            self._manipulator.push(push.start, push.end, self._set_slow, self._set_back)
        except (MotionRefused, UnreachablePose):
            state.idle_pushes.append(_ends(push))
        return True

    def _push_lump(self, ground: Playground, state: _State) -> bool:
        """Push apart what may be blocks too close to be told; return whether that was tried."""
        for lump, others in lumps(ground):
            way = self._pushes.apart(lump, others, state.pushes)
            if way is None:
                continue
            start, end = way
            state.pushes.append(((start.x_mm, start.y_mm), (end.x_mm, end.y_mm)))
            with suppress(MotionRefused, UnreachablePose):
                self._manipulator.push(start, end, self._set_slow, self._set_back)
            return True
        return False

    @staticmethod
    def _judge_push(before: Playground, after: Playground, state: _State) -> None:
        """Take note of a push after which everything lies where it lay."""
        if not state.pushes or len(before.blocks) != len(after.blocks):
            return
        if all(
            any(_way_mm(old, new) < _MOVED_MM for new in after.blocks if new.kind == old.kind)
            for old in before.blocks
        ):
            state.idle_pushes.append(state.pushes[-1])

    def _planned(self, view: Look, tried: Sequence[tuple[LyingBlock, str]]) -> CleaningPlan:
        ground = view.playground
        todo, obstacles = self._split(ground, _State(failures=list(tried)))
        removal = plan_removal(todo, obstacles, self._grips)
        seen = [
            SeenOne(block=step.block, turn=turn, grip=step.grip)
            for turn, step in enumerate(removal.steps, start=1)
        ]
        stuck = removal.stuck
        others = [block.body for block in stuck]
        for index, block in enumerate(stuck):
            around = [*others[:index], *others[index + 1 :], *obstacles]
            seen.append(SeenOne(block=block, why_not=self._why_not(block, around)))
        seen += [SeenOne(strange=thing, why_not=thing.reason) for thing in ground.strange]
        push = None if removal.steps or not stuck else self._pushes.best(stuck, obstacles)
        return CleaningPlan(seen=tuple(seen), push=push, view=view)

    def _why_not(self, block: LyingBlock, around: Sequence[Body]) -> str:
        if self._grips.fits(block, around):
            return "the arm cannot bring its fingers there"
        return (
            "no room for the fingers: "
            f"{max(0.0, self._grips.room_mm(block, around)):.1f} mm beside them, "
            f"{self._grips.margin_mm(block):.1f} mm are needed"
        )

    def _left(self, view: Look, state: _State) -> tuple[str, ...]:
        """Return a sentence for everything that is not home, with what to do."""
        left = []
        for one in self._planned(view, ()).seen:
            if one.strange is not None:
                left.append(
                    f"something at {one.strange.where}: {one.strange.reason}; look at it, and put "
                    "a block apart from others or into its slot by hand"
                )
            elif one.block is not None:
                tried = self._failures(one.block, state)
                why = tried[-1] if tried else one.why_not or "not tried any more"
                left.append(
                    f"{one.block.name} at {one.block.where}: {why}; put it into a free slot, "
                    "or apart from everything, by hand"
                )
        return (*left, *self._unseen(view.playground, state))

    def _unseen(self, ground: Playground, state: _State) -> list[str]:
        """Feel the slots of blocks that the ledger has out and the camera does not see."""
        told = []
        missing = self._ledger.blocks_out()
        unseen = [n for n in self._slots.note(self._lying(ground)) if n in missing]
        for number in [*unseen, *self._ledger.strays()]:
            if self._slots.feel(number):
                state.home.append(number)
                continue
            slot, place = self._plan.slot(number), missing.get(number)
            last = "" if place is None else f", last at ({place.x_mm:.0f}, {place.y_mm:.0f}) mm"
            told.append(
                f"{slot.colour} {slot.kind} of slot {number}: not seen anywhere{last}; look around "
                "the table and put it into its slot by hand"
            )
        if unseen or told:
            self._stand_aside()
        return told


def screen_field(display: DisplayProfile) -> Field:
    """Return the screen's picture, less a margin, as the field that blocks are pushed within."""
    width, height = display.size_mm
    inset = _FIELD_INSET_MM
    corners = [
        (inset, inset), (inset, height - inset), (width - inset, height - inset),
        (width - inset, inset),
    ]  # fmt: skip
    return Field(corners=tuple(display.to_robot(right, down) for right, down in corners))


def _ends(push: Push) -> tuple[Point, Point]:
    return (push.start.x_mm, push.start.y_mm), (push.end.x_mm, push.end.y_mm)


def _way_mm(one: LyingBlock, other: LyingBlock) -> float:
    return math.hypot(one.body.x_mm - other.body.x_mm, one.body.y_mm - other.body.y_mm)
