"""Whether an arm may go along a path: every stance, and everything in between.

Theory. Between two stances each point of the arm stays within a bounded deviation
(sagitta) of the straight line between its two places. So if a body lies beyond the
same face of a box in both stances, by at least that deviation, it never enters the
box in between; likewise for a plane. A stretch of which this cannot be said is
halved until it can, or until it is so short that the bodies' real distances decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil
from typing import NamedTuple

from cell.errors import UnreachablePose
from cell.kinematics import Joints, SixAxisArm
from cell.motion.boxes import Bounds, separations
from cell.motion.hull import ArmHull, Stance
from cell.motion.paths import Path
from cell.motion.refusals import Fault

TOUCH_MM = 0.05
"""Contact is no collision: a block that is put down touches the table."""
LIMIT_SLACK_DEG = 0.01
"""The controller reads joint angles out with two decimals."""
_JUMP_DEG = 15.0
_NEAR_LIMIT_DEG = 1.0
_STILL_DEG = 1e-3
"""A joint that moves less has no speed to speak of."""
_SHORT_MM = 2.0
_TINY_MM = 0.01
_GRAZE_MM = 1.0
_UNEVEN = 1.25
"""How much faster than its mean a joint may turn within a stretch that is not short."""
_ESCAPE_STEP_MM = 5.0


class Walk(NamedTuple):
    """How far a path is free.

    Attributes:
        last: The last stance that is allowed.
        fault: What is violated beyond it, None when the whole path is free.
    """

    last: Stance
    fault: Fault | None


class Sweep:
    """Checks paths of one arm and hand against limits, plane and boxes."""

    def __init__(
        self, arm: SixAxisArm, hull: ArmHull, boxes: Sequence[Bounds], flange_min_z_mm: float
    ) -> None:
        self._hull = hull
        self._boxes = tuple(boxes)
        self._floor_mm = flange_min_z_mm
        self._low = tuple(limit - LIMIT_SLACK_DEG for limit in arm.joint_min_deg)
        self._high = tuple(limit + LIMIT_SLACK_DEG for limit in arm.joint_max_deg)
        self._speed = arm.joint_speed_deg_s
        self._slowest = min(arm.joint_speed_deg_s)

    def is_clean(self, stance: Stance) -> bool:
        """Return whether a stance is quickly seen to violate nothing; else ask `faults`."""
        return (
            all(
                low <= angle <= high
                for low, angle, high in zip(self._low, stance.joints, self._high, strict=True)
            )
            and stance.points[5][2] >= self._floor_mm
            and all(_are_apart(stance.hand, stance.hand, box, 0.0) for box in self._boxes)
            and all(_are_apart(stance.links, stance.links, box, 0.0) for box in self._boxes)
        )

    def faults(self, stance: Stance) -> Iterator[Fault]:
        """Yield every constraint that a stance violates, and by how much."""
        t = stance.t
        for axis, angle in enumerate(stance.joints):
            excess = max(self._low[axis] - angle, angle - self._high[axis])
            if excess > 0.0:
                yield Fault("joint", t, axis, excess=excess)
        if stance.flange_z_mm < self._floor_mm - TOUCH_MM:
            yield Fault("plane", t, excess=self._floor_mm - stance.flange_z_mm)
        for index, box in enumerate(self._boxes):
            for group in (0, 1):
                bounds = stance.hand if group else stance.links
                if max(separations(bounds, box)) < -TOUCH_MM:
                    clearance = self._hull.clearance_mm(stance, group, box)
                    if clearance < -TOUCH_MM:
                        yield Fault("box", t, index, group, excess=-clearance)

    def walk(self, path: Path, start: Stance, end_t: float, duration_s: float | None) -> Walk:
        """Go along a path from a stance that violates nothing.

        Args:
            path: The path.
            start: A stance of it.
            end_t: Up to where.
            duration_s: How long the whole path takes, to check the joints' speeds;
                None where the joints set the pace.
        """
        here = start
        ahead = _cuts(path, start.t, end_t)
        known_mm: dict[tuple[float, int, int], float] = {}
        while ahead:
            t, there = ahead[-1]
            if there is None:
                try:
                    there = path.stance(t, here.joints)
                except UnreachablePose:
                    return Walk(here, Fault("reach", t))
            size_mm = path.length_mm * (t - here.t)
            doubt = self._doubt(path, here, there, size_mm, duration_s)
            if doubt is None:
                ahead.pop()
                here = there
                continue
            for fault in self.faults(there):
                return Walk(here, fault)
            is_box = doubt.kind == "box"
            if is_box and not self._may_collide(path, here, there, known_mm):
                ahead.pop()
                here = there
            elif self._is_settled(doubt, here, there, size_mm):
                return Walk(here, doubt)
            else:
                # Rolling joints are continuous only with the stance just before.
                ahead[-1] = (t, None if doubt.kind == "jump" else there)
                ahead.append((0.5 * (here.t + t), None))
        return Walk(here, None)

    def escape(self, path: Path, start: Stance) -> Walk:
        """Go along a path from a stance that violates something, until it violates nothing.

        Until then each violation may only become less, and none may be added.
        """
        here, before = start, {fault.key: fault for fault in self.faults(start)}
        steps = 1 + int(path.length_mm / _ESCAPE_STEP_MM)
        for step in range(1, steps + 1):
            t = step / steps
            try:
                there = path.stance(t, here.joints)
            except UnreachablePose:
                return Walk(here, Fault("reach", t))
            now = {fault.key: fault for fault in self.faults(there)}
            for key, fault in now.items():
                if key not in before or fault.excess > before[key].excess + 1e-9:
                    return Walk(here, fault)
            if axis := _jumping(here.joints, there.joints, _JUMP_DEG):
                return Walk(here, Fault("jump", t, axis - 1))
            here, before = there, now
            if not now:
                break
        return Walk(here, None)

    def _doubt(
        self, path: Path, here: Stance, there: Stance, size_mm: float, duration_s: float | None
    ) -> Fault | None:
        """Return a constraint that might be violated from a good stance up to the next."""
        doubt = self._joint_doubt(here, there, size_mm, duration_s)
        if doubt is not None:
            return doubt
        links_mm, hand_mm = path.sagitta_mm(here, there)
        lowest = min(here.points[5][2], there.points[5][2])
        if lowest - (hand_mm if size_mm > _SHORT_MM else 0.0) < self._floor_mm - TOUCH_MM:
            return Fault("plane", there.t)
        links_mm -= TOUCH_MM
        hand_mm -= TOUCH_MM
        index = 0
        for box in self._boxes:
            if not _are_apart(here.hand, there.hand, box, hand_mm):
                return Fault("box", there.t, index, 1)
            if not _are_apart(here.links, there.links, box, links_mm):
                return Fault("box", there.t, index, 0)
            index += 1  # noqa: SIM113 - an enumeration costs a tenth of the whole check
        return None

    def _joint_doubt(
        self, here: Stance, there: Stance, size_mm: float, duration_s: float | None
    ) -> Fault | None:
        a1, a2, a3, a4, a5, a6 = here.joints
        b1, b2, b3, b4, b5, b6 = there.joints
        l1, l2, l3, l4, l5, l6 = self._low
        h1, h2, h3, h4, h5, h6 = self._high
        if not (
            l1 <= b1 <= h1 and l2 <= b2 <= h2 and l3 <= b3 <= h3
            and l4 <= b4 <= h4 and l5 <= b5 <= h5 and l6 <= b6 <= h6
        ):  # fmt: skip
            return Fault("joint", there.t)
        if duration_s is None:
            return None
        is_short = size_mm <= _SHORT_MM
        seconds = (there.t - here.t) * (duration_s if is_short else duration_s / _UNEVEN)
        ways = (abs(b1 - a1), abs(b2 - a2), abs(b3 - a3), abs(b4 - a4), abs(b5 - a5), abs(b6 - a6))
        most = max(ways)
        if most > _JUMP_DEG:
            return Fault("jump", there.t, ways.index(most), excess=most)
        if most > self._slowest * seconds + _STILL_DEG:
            for axis, (way, speed) in enumerate(zip(ways, self._speed, strict=True)):
                if way > speed * seconds + _STILL_DEG:
                    return Fault("speed", there.t, axis, ratio=speed * seconds / way)
        if is_short:
            return None
        band = _NEAR_LIMIT_DEG + 0.5 * most
        if (
            l1 + band <= b1 <= h1 - band and l2 + band <= b2 <= h2 - band
            and l3 + band <= b3 <= h3 - band and l4 + band <= b4 <= h4 - band
            and l5 + band <= b5 <= h5 - band and l6 + band <= b6 <= h6 - band
        ):  # fmt: skip
            return None
        return Fault("joint", there.t)

    def _is_settled(self, doubt: Fault, here: Stance, there: Stance, size_mm: float) -> bool:
        """Return whether halving a stretch further would not resolve a doubt."""
        if doubt.kind == "box" and self._hull.way_mm(here, there, doubt.group) <= _GRAZE_MM:
            return True
        return size_mm <= (_SHORT_MM if doubt.kind == "speed" else _TINY_MM)

    def _may_collide(
        self, path: Path, here: Stance, there: Stance, known_mm: dict[tuple[float, int, int], float]
    ) -> bool:
        """Return whether a stretch comes too close to a box, by real distances.

        A body whose distances from a box at both ends add up to more than its way and
        twice its deviation cannot reach the box in between.
        """
        sagitta = path.sagitta_mm(here, there)
        for group in (0, 1):
            bounds = (here.hand, there.hand) if group else (here.links, there.links)
            needed = 2.0 * (sagitta[group] - TOUCH_MM) + self._hull.way_mm(here, there, group)
            for index, box in enumerate(self._boxes):
                if _are_apart(*bounds, box, sagitta[group] - TOUCH_MM):
                    continue
                total = 0.0
                for stance in (here, there):
                    key = (stance.t, group, index)
                    if key not in known_mm:
                        known_mm[key] = self._hull.clearance_mm(stance, group, box)
                    total += known_mm[key]
                if total < needed:
                    return True
        return False


def _cuts(path: Path, start_t: float, end_t: float) -> list[tuple[float, Stance | None]]:
    """Return where to stand first, last one first, with stances still unknown."""
    count = max(1, ceil(path.steps * (end_t - start_t) - 1e-9))
    step = (end_t - start_t) / count
    return [(end_t, None), *((start_t + step * i, None) for i in range(count - 1, 0, -1))]


def _are_apart(first: Bounds, last: Bounds, box: Bounds, margin_mm: float) -> bool:
    """Return whether both bounds lie beyond one and the same face by a margin."""
    x0, y0, z0, x1, y1, z1 = box
    return (
        (first[2] - z1 >= margin_mm and last[2] - z1 >= margin_mm)
        or (x0 - first[3] >= margin_mm and x0 - last[3] >= margin_mm)
        or (y0 - first[4] >= margin_mm and y0 - last[4] >= margin_mm)
        or (first[1] - y1 >= margin_mm and last[1] - y1 >= margin_mm)
        or (first[0] - x1 >= margin_mm and last[0] - x1 >= margin_mm)
        or (z0 - first[5] >= margin_mm and z0 - last[5] >= margin_mm)
    )


def _jumping(first: Joints, last: Joints, limit_deg: float) -> int:
    """Return the first joint (1 to 6) that turns by more than a limit, 0 for none."""
    for axis, (a, b) in enumerate(zip(first, last, strict=True), 1):
        if abs(b - a) > limit_deg:
            return axis
    return 0
