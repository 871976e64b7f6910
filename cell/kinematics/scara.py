"""A SCARA arm: two links that turn in the plane, a spindle that slides and rolls.

The robot frame's origin lies on joint 1's axis at the height of the tool point when the
spindle stands at its upper end, so Z is the slide's own position: 0 up, negative down.
Frames: x = l1·cos J1 + l2·cos(J1+J2), y likewise with sin, z = J3, roll = J1+J2+J4
(section G of the device facts; Bloch 1994, 4.11-4.12). The tool always points down.
"""

from __future__ import annotations

from math import acos, atan2, ceil, cos, degrees, floor, hypot, radians, sin, sqrt

from cell.errors import UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.kinematics.arm import JointUnit
from cell.profile.ibm7545 import Ibm7545Profile

ELBOW_POSITIVE = 0
"""Posture in which joint 2 turns counter-clockwise; the IBM 7545 has no other."""
ELBOW_NEGATIVE = 1
"""Posture in which joint 2 turns clockwise."""

_UNITS: tuple[JointUnit, ...] = ("deg", "deg", "mm", "deg")
_TURN_DEG = 360.0
_TILT_DEG = 0.05
"""How far from upright a pose may lean: rounding, no more."""
_SLACK = 1e-6

Four = tuple[float, float, float, float]
Point = tuple[float, float, float]


class ScaraArm:
    """Forward and inverse kinematics of one SCARA arm with its limits.

    Args:
        link_mm: Lengths of the two links.
        joint_min: Least positions: deg, deg, mm, deg.
        joint_max: Greatest positions.
        joint_speed: Greatest speeds, in the joints' units a second.
        link_height_mm: Height of the links over the tool point's upper end.
    """

    def __init__(
        self,
        *,
        link_mm: tuple[float, float],
        joint_min: Four,
        joint_max: Four,
        joint_speed: Four,
        link_height_mm: float,
    ) -> None:
        self.link_mm = link_mm
        self._min = joint_min
        self._max = joint_max
        self._speed = joint_speed
        self._height_mm = link_height_mm

    @staticmethod
    def from_profile(profile: Ibm7545Profile) -> ScaraArm:
        """Return the arm that a profile describes."""
        return ScaraArm(
            link_mm=profile.link_mm,
            joint_min=profile.joint_min,
            joint_max=profile.joint_max,
            joint_speed=profile.joint_speed,
            link_height_mm=profile.link_height_mm,
        )

    @property
    def joint_units(self) -> tuple[JointUnit, ...]:
        """Unit of each joint: deg, deg, mm, deg."""
        return _UNITS

    @property
    def joint_min(self) -> tuple[float, ...]:
        """Least position of each joint."""
        return self._min

    @property
    def joint_max(self) -> tuple[float, ...]:
        """Greatest position of each joint."""
        return self._max

    @property
    def joint_speed(self) -> tuple[float, ...]:
        """Greatest speed of each joint, in its unit a second."""
        return self._speed

    def forward(self, joints: JointPositions) -> Pose:
        """Return where the tool point is, tool down, its roll in (-180, 180]."""
        j1, j2, j3, j4 = joints.values
        first, both = radians(j1), radians(j1 + j2)
        l1, l2 = self.link_mm
        return Pose(
            l1 * cos(first) + l2 * cos(both),
            l1 * sin(first) + l2 * sin(both),
            j3,
            180.0,
            0.0,
            _folded_deg(j1 + j2 + j4),
        )

    def solve(self, pose: Pose, posture: int, near: JointPositions | None = None) -> JointPositions:
        """Return the joints for a pose.

        Args:
            pose: Where the tool point shall be; the tool must point down.
            posture: `ELBOW_POSITIVE` or `ELBOW_NEGATIVE`.
            near: Joints whose turn is kept where joint 1 or 4 could stand a turn apart.

        Raises:
            UnreachablePose: It leans, is out of reach or outside a joint's limits; the error
                says which joint, its value and the limit.
        """
        self._require_upright(pose)
        j2 = self._second_deg(pose)
        if posture == ELBOW_NEGATIVE:
            j2 = -j2
        l1, l2 = self.link_mm
        bend = radians(j2)
        j1 = degrees(atan2(pose.y_mm, pose.x_mm) - atan2(l2 * sin(bend), l1 + l2 * cos(bend)))
        j1 = self._turned(0, j1, near)
        j4 = self._turned(3, pose.c_deg + 180.0 - pose.a_deg - j1 - j2, near)
        values = (j1, j2, pose.z_mm, j4)
        self._require_limits(pose, values)
        return JointPositions(tuple(self._settled(axis, v) for axis, v in enumerate(values)))

    def link_points_mm(self, values: tuple[float, ...]) -> tuple[Point, ...]:
        """Return foot of the column, shoulder, elbow, spindle and tool point."""
        j1, j2, j3, _ = values
        first, both = radians(j1), radians(j1 + j2)
        l1, l2 = self.link_mm
        h = self._height_mm
        elbow_x, elbow_y = l1 * cos(first), l1 * sin(first)
        x, y = elbow_x + l2 * cos(both), elbow_y + l2 * sin(both)
        return (
            (0.0, 0.0, self._min[2]),
            (0.0, 0.0, h),
            (elbow_x, elbow_y, h),
            (x, y, h),
            (x, y, j3),
        )

    def _second_deg(self, pose: Pose) -> float:
        """Return joint 2 (0 to 180) by the law of cosines."""
        l1, l2 = self.link_mm
        reach = hypot(pose.x_mm, pose.y_mm)
        for limit, is_out in ((l1 + l2, reach > l1 + l2), (abs(l1 - l2), reach < abs(l1 - l2))):
            if is_out and abs(reach - limit) > _SLACK:
                raise _unreachable(
                    pose, "reach", "mm", reach, limit, "from the column's axis is out of reach"
                )
        cosine = (reach * reach - l1 * l1 - l2 * l2) / (2.0 * l1 * l2)
        return degrees(acos(min(1.0, max(-1.0, cosine))))

    def _turned(self, axis: int, angle_deg: float, near: JointPositions | None) -> float:
        """Return the angle, whole turns aside, that the limits allow and lies nearest."""
        low, high = self._min[axis], self._max[axis]
        wanted = 0.5 * (low + high) if near is None else near.values[axis]
        first = ceil((low - angle_deg) / _TURN_DEG - _SLACK)
        last = floor((high - angle_deg) / _TURN_DEG + _SLACK)
        turns = range(first, last + 1) or (round((0.5 * (low + high) - angle_deg) / _TURN_DEG),)
        return min((angle_deg + _TURN_DEG * turn for turn in turns), key=lambda a: abs(a - wanted))

    def _settled(self, axis: int, value: float) -> float:
        return min(max(value, self._min[axis]), self._max[axis])

    def _require_upright(self, pose: Pose) -> None:
        cosine = -cos(radians(pose.a_deg)) * cos(radians(pose.b_deg))
        sine = sqrt(max(0.0, 1.0 - cosine * cosine))
        tilt_deg = degrees(atan2(sine, cosine))
        if tilt_deg > _TILT_DEG:
            raise _unreachable(
                pose, "tilt", "deg", tilt_deg, 0.0, "from upright; this arm's tool points down"
            )

    def _require_limits(self, pose: Pose, values: Four) -> None:
        worst, worst_axis = _SLACK, -1
        for axis, value in enumerate(values):
            excess = max(self._min[axis] - value, value - self._max[axis])
            if excess > worst:
                worst, worst_axis = excess, axis
        if worst_axis >= 0:
            value = values[worst_axis]
            limit = (
                self._max[worst_axis] if value > self._max[worst_axis] else self._min[worst_axis]
            )
            raise _unreachable(
                pose,
                f"J{worst_axis + 1}",
                _UNITS[worst_axis],
                value,
                limit,
                "is beyond the joint's limit",
            )


def _unreachable(
    pose: Pose, what: str, unit: JointUnit, value: float, limit: float, why: str
) -> UnreachablePose:
    return UnreachablePose(
        f"the pose {pose} cannot be reached: {what} {value:.1f} {unit} {why} ({limit:.1f} {unit})",
        what=what,
        value=value,
        limit=limit,
        unit=unit,
    )


def _folded_deg(angle_deg: float) -> float:
    """Return the same direction in (-180, 180]."""
    return -((180.0 - angle_deg) % _TURN_DEG) + 180.0
