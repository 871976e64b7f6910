"""Words and figures of a refusal: what is violated, by how much, how far one may go."""

from __future__ import annotations

from collections.abc import Sequence
from math import dist

from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import Pose
from cell.kinematics import Point, SixAxisArm, matrix_from_pose
from cell.kinematics.flags import posture_name
from cell.motion.boxes import AXES, Bounds, separations
from cell.motion.hull import GROUPS, ArmHull, Stance
from cell.motion.paths import LinearPath, Path
from cell.motion.refusals import Fault
from cell.motion.sweep import TOUCH_MM, Sweep

_HALVINGS = 20
_SLOWEST = 1e-4
"""Share of the asked speed below which no allowed speed is searched."""


class Explainer:
    """Makes refusals for one arm with one shape of hand in one cell."""

    def __init__(
        self,
        arm: SixAxisArm,
        hull: ArmHull,
        sweep: Sweep,
        box_names: Sequence[str],
        boxes: Sequence[Bounds],
        flange_min_z_mm: float,
    ) -> None:
        self._arm = arm
        self._hull = hull
        self._sweep = sweep
        self._box_names = tuple(box_names)
        self._boxes = tuple(boxes)
        self._floor_mm = flange_min_z_mm

    def refusal(
        self, path: Path, last: Stance, fault: Fault, duration_s: float | None, speed: float
    ) -> MotionRefused:
        """Return the error for a fault on a path that is free up to a stance."""
        last, fault = self._closed_in(path, last, fault, duration_s)
        if fault.kind == "speed" and duration_s is not None:
            return self._too_fast(path, fault, duration_s, speed)
        if fault.kind == "reach":
            return self._beyond_reach(path, last, fault)
        worst = self._worst(path, last, fault)
        if fault.kind == "plane":
            return MotionRefused(
                "flange",
                value=worst.flange_z_mm,
                limit=self._floor_mm,
                nearest=last.flange_z_mm,
                unit="mm",
                why="would come below its lowest height",
                nearest_point_mm=last.tool_mm,
            )
        if fault.kind == "box":
            return self._into_box(path, last, worst, fault)
        return self._past_joint(last, worst, fault)

    def wrong_posture(self, path: LinearPath, posture: int) -> MotionRefused:
        """Return the error for a line that would have to start in another posture."""
        start = path.start.joints
        try:
            wanted = path.stance(0.0, start).joints
        except UnreachablePose:
            wanted = start
        axis = max(range(6), key=lambda index: abs(wanted[index] - start[index]))
        return MotionRefused(
            f"J{axis + 1}",
            value=wanted[axis],
            limit=start[axis],
            nearest=start[axis],
            unit="deg",
            why=f"does not stand in posture {posture_name(posture)}, which a line cannot change",
            nearest_point_mm=path.start.tool_mm,
        )

    def unreachable(
        self, first: Stance, target: Pose, posture: int, error: UnreachablePose
    ) -> MotionRefused:
        """Return the error for a pose that the arm cannot take, joint by joint or otherwise.

        The nearest allowed values are those of the last reachable point on the straight
        line from where the tool stands.
        """
        path = LinearPath(self._arm, self._hull, first, matrix_from_pose(target), posture)
        low, high, best = 0.0, 1.0, first
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            try:
                stance = path.stance(middle, best.joints)
            except UnreachablePose:
                high = middle
                continue
            if self._arm.violations(stance.joints):
                high = middle
            else:
                low, best = middle, stance
        return self._out_of_reach(best, error, f"for {target}")

    def _closed_in(
        self, path: Path, last: Stance, fault: Fault, duration_s: float | None
    ) -> tuple[Stance, Fault]:
        """Close in on the place where a path stops being free."""
        if next(self._sweep.faults(last), None) is not None:
            return last, fault
        blocked_t = fault.t
        for _ in range(_HALVINGS):
            middle = 0.5 * (last.t + blocked_t)
            walk = self._sweep.walk(path, last, middle, duration_s)
            last = walk.last
            if walk.fault is not None:
                fault, blocked_t = walk.fault, walk.fault.t
        return last, fault

    def _worst(self, path: Path, last: Stance, fault: Fault) -> Stance:
        """Return the path's end if it violates the same constraint, else where it begins to."""
        for t in (1.0, fault.t):
            try:
                stance = path.stance(t, last.joints)
            except UnreachablePose:
                continue
            if any(found.key == fault.key for found in self._sweep.faults(stance)):
                return stance
        return path.stance(fault.t, last.joints)

    def _past_joint(self, last: Stance, worst: Stance, fault: Fault) -> MotionRefused:
        axis = fault.index
        value, nearest = worst.joints[axis], last.joints[axis]
        if fault.kind == "jump":
            return MotionRefused(
                f"J{axis + 1}",
                value=value,
                limit=nearest,
                nearest=nearest,
                unit="deg",
                why="would have to jump where the arm passes a singular stance",
                nearest_point_mm=last.tool_mm,
            )
        low, high = self._arm.joint_min_deg[axis], self._arm.joint_max_deg[axis]
        return MotionRefused(
            f"J{axis + 1}",
            value=value,
            limit=low if abs(value - low) < abs(value - high) else high,
            nearest=nearest,
            unit="deg",
            why="would pass its limit",
            nearest_point_mm=last.tool_mm,
        )

    def _into_box(self, path: Path, last: Stance, worst: Stance, fault: Fault) -> MotionRefused:
        """Word a collision along the axis that says most about it.

        That is the axis on which the body was still clear of the box, or else the one
        along which the tool was under way.
        """
        box = self._boxes[fault.index]
        clear = separations(self._bounds(last, fault.group), box)
        face = max(range(6), key=lambda index: clear[index])
        end = _tool_at(path, 1.0, last)
        if clear[face] > -2.0 * TOUCH_MM:
            axis = face // 2
        else:
            axis = max(range(3), key=lambda index: abs(end[index] - last.tool_mm[index]))
        limit = last.tool_mm[axis]
        if worst.t >= 1.0 and axis == face // 2:
            depth = -separations(self._bounds(worst, fault.group), box)[face]
            limit = end[axis] + (depth if face % 2 == 0 else -depth)
        return MotionRefused(
            f"tool {AXES[axis]}",
            value=end[axis],
            limit=limit,
            nearest=last.tool_mm[axis],
            unit="mm",
            why=f"would bring the {GROUPS[fault.group]} into the {self._box_names[fault.index]}",
            nearest_point_mm=last.tool_mm,
        )

    def _bounds(self, stance: Stance, group: int) -> Bounds:
        return stance.hand if group else stance.links

    def _beyond_reach(self, path: Path, last: Stance, fault: Fault) -> MotionRefused:
        for t in (1.0, fault.t):
            try:
                path.stance(t, last.joints)
            except UnreachablePose as error:
                return self._out_of_reach(last, error, "along the line")
        return self._past_joint(last, last, Fault("jump", fault.t))

    def _out_of_reach(self, last: Stance, error: UnreachablePose, where: str) -> MotionRefused:
        if error.unit == "deg":
            nearest = last.joints[int(error.what[1:]) - 1]
            why = f"cannot turn far enough {where}"
        else:
            nearest = dist(last.points[1], last.points[4])
            why = f"from shoulder to wrist is not enough {where}"
        return MotionRefused(
            error.what,
            value=error.value,
            limit=error.limit,
            nearest=nearest,
            unit=error.unit,
            why=why,
            nearest_point_mm=last.tool_mm,
        )

    def _too_fast(
        self, path: Path, fault: Fault, duration_s: float, speed_mm_s: float
    ) -> MotionRefused:
        """Find the largest speed at which no joint is too slow; the path's way stays the same."""
        ratio, axis = fault.ratio, fault.index
        allowed = 1.0
        while allowed > _SLOWEST:
            allowed *= min(ratio, 0.99)
            walk = self._sweep.walk(path, path.start, 1.0, duration_s / allowed)
            if walk.fault is None or walk.fault.kind != "speed":
                break
            ratio = walk.fault.ratio
        return MotionRefused(
            "linear speed",
            value=speed_mm_s,
            limit=speed_mm_s * allowed,
            nearest=speed_mm_s * allowed,
            unit="mm/s",
            why=f"is more than J{axis + 1} can follow "
            f"({self._arm.joint_speed_deg_s[axis]:g} deg/s)",
        )


def _tool_at(path: Path, t: float, near: Stance) -> Point:
    """Return the tool point on a path, where it can be told."""
    try:
        return path.stance(t, near.joints).tool_mm
    except UnreachablePose:
        return near.tool_mm
