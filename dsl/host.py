"""What a running task asks of the cell: the only way out of the language."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """One block of the store, and where on the lattice it shall lie.

    Attributes:
        slot: Number of the store slot it is taken from and brought back to.
        kind: Kind of block, such as `cube`.
        colour: Colour of the block, such as `red`.
        x: Lattice x of its centre.
        y: Lattice y of its centre.
        yaw_deg: Turn against the lattice, counter-clockwise; 0 in the shipped scripts.
    """

    slot: int
    kind: str
    colour: str
    x: int
    y: int
    yaw_deg: float = 0.0


class Host(Protocol):
    """A cell, as far as a task needs one. Every call returns when it is done."""

    def show(self, picture: str) -> None:
        """Show the background picture on the screen under the playground."""

    def lay_out(self, placements: Sequence[Placement]) -> None:
        """Bring each block from its store slot to its lattice point."""

    def move_to(self, x: int, y: int, travel_mm: float) -> None:
        """Bring the gripper over a lattice point, `travel_mm` above the block tops."""
