"""What a stance or a stretch of a path does wrong, before it is put in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FaultKind = Literal["joint", "plane", "box", "reach", "speed", "jump"]


@dataclass(frozen=True, slots=True)
class Fault:
    """One constraint that a motion violates.

    Attributes:
        kind: Which sort of constraint.
        index: Which joint (0 for J1) or which box.
        group: For a box: 0 the arm, 1 the hand.
        excess: By how much, in the constraint's own unit; 0 when found between stances.
        t: Where on the path it was found.
        ratio: For a speed: the share of the asked speed that would be allowed.
    """

    kind: FaultKind
    t: float
    index: int = 0
    group: int = 0
    excess: float = 0.0
    ratio: float = 1.0

    @property
    def key(self) -> tuple[FaultKind, int, int]:
        """The constraint itself, wherever it is violated."""
        return (self.kind, self.index, self.group)
