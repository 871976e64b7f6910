"""Motions of an emulated module's fingers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from cell.twin.bodies import FingerMotion

MotionKind = Literal["reference", "position", "push"]
"""A push goes on until something blocks it: by current, by grip or by velocity."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A motion under way: what was asked and what the body says will come of it."""

    kind: MotionKind
    start_s: float
    start_mm: float
    target_mm: float
    speed_mm_s: float
    acceleration_mm_s2: float
    current_a: float
    plan: FingerMotion
    settle_s: float = 0.0

    @property
    def end_s(self) -> float:
        """When the module notices the end."""
        return self.plan.end_s + self.settle_s

    def velocity_mm_s(self, now_s: float) -> float:
        """Return the velocity on the trapezoid, negative when closing, zero once it ended."""
        if now_s >= self.plan.end_s:
            return 0.0
        distance_mm = self.target_mm - self.start_mm
        passed_s = now_s - self.start_s
        left_s = trapezoid_s(distance_mm, self.speed_mm_s, self.acceleration_mm_s2) - passed_s
        ramped = self.acceleration_mm_s2 * max(0.0, min(passed_s, left_s))
        return math.copysign(min(self.speed_mm_s, ramped), distance_mm)


def trapezoid_s(distance_mm: float, speed_mm_s: float, acceleration_mm_s2: float) -> float:
    """Return how long a move from rest to rest takes.

    With full speed reached, d/v + v/a; otherwise 2·sqrt(d/a).
    """
    distance_mm = abs(distance_mm)
    if distance_mm * acceleration_mm_s2 >= speed_mm_s * speed_mm_s:
        return distance_mm / speed_mm_s + speed_mm_s / acceleration_mm_s2
    return 2.0 * math.sqrt(distance_mm / acceleration_mm_s2)
