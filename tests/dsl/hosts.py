"""A host that only remembers what it was asked for."""

from __future__ import annotations

from collections.abc import Sequence

from dsl.host import Placement


class RememberingHost:
    """Remembers every call; breaks at the next move when told to."""

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []
        self.is_broken = False

    def show(self, picture: str) -> None:
        self.calls.append(("show", picture))

    def lay_out(self, placements: Sequence[Placement]) -> None:
        self.calls.append(("lay_out", tuple(placements)))

    def move_to(self, x: int, y: int, travel_mm: float) -> None:
        if self.is_broken:
            raise OSError("the cable is out")
        self.calls.append(("move_to", x, y, travel_mm))
