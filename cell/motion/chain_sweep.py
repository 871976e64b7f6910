"""Whether a chain of links may go along a path of joint positions, everything in between too.

Theory. A path is a row of stances between which the joints move evenly. Between two
stances no point of a body travels further than `ChainHull.way_mm`. A body whose distances
from a box at both ends add up to that much cannot touch it in between; likewise the tool
point and the faces of the work space. A stretch of which this cannot be said is halved,
down to `FINEST_MM`. There both ends must be clear, and the bodies, which are thicker by
half of that (`MARGIN_MM`), cannot have touched in between.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import TypeAlias

from cell.geometry import JointPositions
from cell.kinematics.arm import ArmKinematics
from cell.motion.boxes import Bounds
from cell.motion.chain_hull import ChainHull, Point, clearance_mm
from cell.motion.refusals import Fault, FaultKind

FINEST_MM = 0.5
"""Length of a stretch, by the way of the body that moves most, that is not halved further."""
MARGIN_MM = 0.25
"""By how much every body is thicker than its radius: half of `FINEST_MM`."""
LIMIT_SLACK = 0.01
"""Controllers read joints out with two decimals."""
WORK_SLACK_MM = 0.5
"""The tool point may be this far outside the work space: rounding, and half of `FINEST_MM`."""
_ESCAPE_MM = 2.0
_GROWTH = 1e-6

_Faults: TypeAlias = dict[tuple[FaultKind, int, int], Fault]

WORK_SPACE = -1
"""Index of the work space in a fault of kind `plane`."""


@dataclass(frozen=True, slots=True)
class ChainStance:
    """An arm at one moment: joints, tool point, and how far it is from everything.

    Attributes:
        values: The joints.
        tool_mm: The tool point.
        clearances: From each box, the arm's and the hand's; then from the work space's faces.
    """

    values: tuple[float, ...]
    tool_mm: Point
    clearances: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ChainWalk:
    """How far a path is free: the last stance that is allowed, and what is violated beyond.

    Attributes:
        last: The last stance that is allowed.
        fault: What is violated beyond it, None when the whole path is free.
        worst: The stance at which that was seen.
    """

    last: ChainStance
    fault: Fault | None = None
    worst: ChainStance | None = None


class ChainSweep:
    """Checks paths of one arm against joint limits, boxes and the work space.

    Args:
        arm: The arm's kinematics.
        hull: Its bodies, thicker by `MARGIN_MM`.
        boxes: What no body may enter.
        work_space: What the tool point must not leave, or None.
        is_loaded: Whether something is between the fingers.
    """

    def __init__(
        self,
        arm: ArmKinematics,
        hull: ChainHull,
        boxes: Sequence[Bounds],
        work_space: Bounds | None,
        *,
        is_loaded: bool,
    ) -> None:
        self._arm = arm
        self._hull = hull
        self._boxes = tuple(boxes)
        self._work_space = work_space
        self._is_loaded = is_loaded

    def stance(self, values: tuple[float, ...]) -> ChainStance:
        """Return the arm's stance at joint positions."""
        bodies = self._hull.bodies(values, is_loaded=self._is_loaded)
        clearances = []
        for box in self._boxes:
            clearances.append(min((clearance_mm(body, box) for body in bodies[:-1]), default=inf))
            clearances.append(clearance_mm(bodies[-1], box))
        pose = self._arm.forward(JointPositions(values))
        tool = (pose.x_mm, pose.y_mm, pose.z_mm)
        clearances.append(self._within_mm(tool))
        return ChainStance(values, tool, tuple(clearances))

    def faults(self, stance: ChainStance) -> Iterator[Fault]:
        """Yield every constraint that a stance violates, and by how much."""
        for axis, (value, low, high) in enumerate(
            zip(stance.values, self._arm.joint_min, self._arm.joint_max, strict=True)
        ):
            excess = max(low - value, value - high)
            if excess > LIMIT_SLACK:
                yield Fault("joint", 0.0, axis, excess=excess)
        for index, clearance in enumerate(stance.clearances[:-1]):
            if clearance < 0.0:
                yield Fault("box", 0.0, index // 2, index % 2, excess=-clearance)
        if stance.clearances[-1] < 0.0:
            yield Fault("plane", 0.0, WORK_SPACE, excess=-stance.clearances[-1])

    def walk(self, path: Sequence[tuple[float, ...]]) -> ChainWalk:
        """Go along a path whose first stance may violate something, if only ever less so."""
        here = self.stance(path[0])
        before = {fault.key: fault for fault in self.faults(here)}
        for values in path[1:]:
            target = self.stance(values)
            if before:
                walk, before = self._escape(here, target, before)
                if walk.fault is not None:
                    return walk
                here = walk.last
            if not before:
                walk = self._go(here, target)
                if walk.fault is not None:
                    return walk
                here = walk.last
        return ChainWalk(here)

    def _go(self, first: ChainStance, last: ChainStance) -> ChainWalk:
        """Go evenly from a stance that violates nothing to another."""
        here, ahead = first, [last]
        while ahead:
            there = ahead[-1]
            way_mm = self._hull.way_mm(here.values, there.values)
            if self._is_far(here, there, way_mm):
                here = ahead.pop()
                continue
            fault = next(self.faults(there), None)
            if way_mm > FINEST_MM:
                ahead.append(self.stance(_middle(here.values, there.values)))
            elif fault is None:
                here = ahead.pop()
            else:
                return ChainWalk(here, fault, self._worst(fault, there, last))
        return ChainWalk(here)

    def _escape(
        self,
        first: ChainStance,
        last: ChainStance,
        before: _Faults,
    ) -> tuple[ChainWalk, _Faults]:
        """Go on while something is violated; each violation may only become less."""
        here = first
        steps = 1 + int(self._hull.way_mm(first.values, last.values) / _ESCAPE_MM)
        for step in range(1, steps + 1):
            there = (
                last
                if step == steps
                else self.stance(_between(first.values, last.values, step / steps))
            )
            now = {fault.key: fault for fault in self.faults(there)}
            for key, fault in now.items():
                if key not in before or fault.excess > before[key].excess + _GROWTH:
                    return ChainWalk(here, fault, self._worst(fault, there, last)), before
            here, before = there, now
            if not now:
                break
        return ChainWalk(here), before

    def _is_far(self, here: ChainStance, there: ChainStance, way_mm: float) -> bool:
        """Return whether nothing can be violated between two stances, nor at the second."""
        for a, b in zip(here.clearances, there.clearances, strict=True):
            if a + b < way_mm or b < 0.0:
                return False
        arm = self._arm
        return all(
            low - LIMIT_SLACK <= value <= high + LIMIT_SLACK
            for low, value, high in zip(arm.joint_min, there.values, arm.joint_max, strict=True)
        )

    def _worst(self, fault: Fault, there: ChainStance, last: ChainStance) -> ChainStance:
        """Return the stretch's end if it violates the same constraint, else where it begins to."""
        return last if any(found.key == fault.key for found in self.faults(last)) else there

    def _within_mm(self, tool: Point) -> float:
        if self._work_space is None:
            return inf
        low, high = self._work_space[:3], self._work_space[3:]
        inside = min(min(t - a, b - t) for t, a, b in zip(tool, low, high, strict=True))
        return inside + WORK_SLACK_MM


def _between(first: tuple[float, ...], last: tuple[float, ...], share: float) -> tuple[float, ...]:
    return tuple([a + share * (b - a) for a, b in zip(first, last, strict=True)])


def _middle(first: tuple[float, ...], last: tuple[float, ...]) -> tuple[float, ...]:
    return tuple([0.5 * (a + b) for a, b in zip(first, last, strict=True)])
