"""The store: which block has which slot, and where the slots lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cell.errors import StoreError
from cell.profile import StoreProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreSlot:
    """One place of the printed store plan.

    Attributes:
        number: Number printed beside the place.
        kind: Kind of block that belongs there.
        colour: Its colour.
        x_mm: Plan x, from the plan's upper left corner to the right.
        y_mm: Plan y, from the plan's upper left corner down.
    """

    number: int
    kind: str
    colour: str
    x_mm: float
    y_mm: float

    @property
    def block(self) -> str:
        """Identity of the block that belongs here."""
        return f"slot {self.number}"


@dataclass(frozen=True, slots=True)
class StorePlan:
    """All slots of a store."""

    slots: tuple[StoreSlot, ...]

    def slot(self, number: int) -> StoreSlot:
        """Return a slot by its number.

        Raises:
            StoreError: There is no such slot.
        """
        for slot in self.slots:
            if slot.number == number:
                return slot
        numbers = ", ".join(str(slot.number) for slot in self.slots)
        raise StoreError(f"the store has no slot {number}; it has {numbers}")

    def slots_of(self, kind: str, colour: str) -> tuple[StoreSlot, ...]:
        """Return the slots of one kind and colour, lowest number first."""
        found = [s for s in self.slots if s.kind == kind and s.colour == colour]
        return tuple(sorted(found, key=lambda slot: slot.number))


def with_calibration_object(plan: StorePlan, store: StoreProfile) -> StorePlan:
    """Return a plan with the slot of the cell's calibration object.

    A plan that has a slot of that number, or a store without such an object, stays as it is.
    """
    known = store.calibration
    if known is None or any(slot.number == known.number for slot in plan.slots):
        return plan
    own = StoreSlot(
        number=known.number,
        kind=known.kind,
        colour=known.colour,
        x_mm=known.place_mm[0],
        y_mm=known.place_mm[1],
    )
    return StorePlan((*plan.slots, own))


@dataclass(frozen=True, slots=True, kw_only=True)
class TablePlace:
    """A place for a block in the robot frame.

    Attributes:
        x_mm: Robot x of the block's centre.
        y_mm: Robot y of the block's centre.
        yaw_deg: Turn of the block's length from robot x, counter-clockwise.
    """

    x_mm: float
    y_mm: float
    yaw_deg: float


def place_of_slot(slot: StoreSlot, store: StoreProfile) -> TablePlace:
    """Return where a slot lies in the robot frame.

    Plan x runs along the profile's angle from robot x, plan y to its right, as on
    a sheet that is read from above.
    """
    cos, sin = math.cos(math.radians(store.angle_deg)), math.sin(math.radians(store.angle_deg))
    return TablePlace(
        x_mm=store.corner_mm[0] + cos * slot.x_mm + sin * slot.y_mm,
        y_mm=store.corner_mm[1] + sin * slot.x_mm - cos * slot.y_mm,
        yaw_deg=store.angle_deg,
    )
