"""Which slot a block that was found goes to, and keeping the ledger to what is seen."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cell.cleaning.sight import LyingBlock
from cell.errors import StoreError
from cell.ledger import Ledger
from cell.manipulation import NEAR_MM, Manipulator
from cell.store import StorePlan, TablePlace

_SAME_MM = 1.0


class FreeSlots:
    """Finds a free slot for each block; no slot is felt twice.

    Args:
        manipulator: Feels slots.
        ledger: Knows which blocks are out.
        plan: The store.
    """

    def __init__(self, manipulator: Manipulator, ledger: Ledger, plan: StorePlan) -> None:
        self._manipulator = manipulator
        self._ledger = ledger
        self._plan = plan
        self._full: set[int] = set()

    def is_home(self, block: LyingBlock) -> bool:
        """Return whether a block lies in a slot of its kind and colour."""
        places = (
            self._manipulator.slot_place(slot.number)
            for slot in self._plan.slots_of(block.kind, block.colour)
        )
        return any(_distance_mm(block, place) < NEAR_MM for place in places)

    def note(self, blocks: Sequence[LyingBlock]) -> tuple[int, ...]:
        """Write where the camera sees the blocks that the ledger has out.

        Blocks of a kind and colour are all alike: the nearest is taken for the ledger's.

        Returns:
            Slots of the blocks that the ledger has out and nobody sees.
        """
        out = self._ledger.blocks_out()
        pairs = sorted(
            (_distance_mm(block, place), number, index)
            for number, place in out.items()
            for index, block in enumerate(blocks)
            if self._fits(number, block)
        )
        matched: dict[int, int] = {}
        for distance, number, index in pairs:
            if number in matched or index in matched.values():
                continue
            matched[number] = index
            if distance > _SAME_MM:
                self._ledger.released(number, blocks[index].place)
        return tuple(number for number in out if number not in matched)

    def slot_for(self, block: LyingBlock) -> int:
        """Return the slot to bring a block to; from now on the ledger has it out there.

        First of those that the ledger has out, the nearest; then one whose block was lost;
        then the lowest in which the fingers feel nothing.

        Raises:
            StoreError: There is no such slot.
        """
        number = self._find(block)
        self._ledger.released(number, block.place)
        return number

    def filled(self, number: int) -> None:
        """Take note that a block was brought to a slot."""
        self._full.add(number)

    def feel(self, number: int) -> bool:
        """Return whether a slot that should be empty is not; its block is home then."""
        if not self._manipulator.feels_block(number):
            return False
        self._full.add(number)
        self._ledger.released(number, None)
        return True

    def _find(self, block: LyingBlock) -> int:
        slots = [
            slot.number
            for slot in self._plan.slots_of(block.kind, block.colour)
            if slot.number not in self._full
        ]
        out = self._ledger.blocks_out()
        known = [number for number in slots if number in out]
        if known:
            return min(known, key=lambda number: _distance_mm(block, out[number]))
        strays = self._ledger.strays()
        lost = [number for number in slots if number in strays]
        if lost:
            return lost[0]
        for number in slots:
            if not self._manipulator.feels_block(number):
                return number
            self._full.add(number)
        raise StoreError(f"the store has no free slot for a {block.name}")

    def _fits(self, number: int, block: LyingBlock) -> bool:
        slot = next((s for s in self._plan.slots if s.number == number), None)
        return slot is not None and (slot.kind, slot.colour) == (block.kind, block.colour)


def _distance_mm(block: LyingBlock, place: TablePlace) -> float:
    return math.hypot(block.body.x_mm - place.x_mm, block.body.y_mm - place.y_mm)
