"""The space that the arm and its hand take up, as simple bodies around their axes.

Two groups are told apart because they move differently: the *links* (upper arm,
elbow, forearm) turn with J1 to J3; the *hand* (wrist, gripper, fingers, a held
block) keeps its shape in the tool frame. The base column stands still and is left
out. Every body is a little larger than the metal.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import dist
from typing import NamedTuple

from cell.kinematics import Joints, LinkPoints, Matrix34, Point, SixAxisArm
from cell.motion.boxes import Bounds, segment_distance_mm, separations
from cell.profile import BlockProfile, GripperProfile

LINK_RADIUS_MM = 90.0
"""Upper arm, elbow and forearm; estimated from the maker's outline drawing."""
WRIST_RADIUS_MM = 60.0
"""Wrist up to the flange; estimated from the maker's outline drawing."""
GRIPPER_RADIUS_MM = 50.0
"""Body of the gripper between flange and fingers."""
FINGER_LENGTH_MM = 60.0
"""How far the gripper's body ends above the tool point."""

GROUPS = ("arm", "hand")


@dataclass(frozen=True, slots=True, kw_only=True)
class HandShape:
    """Half sizes of everything around the tool point, in the tool frame.

    Attributes:
        half_x_mm: Across the fingers' faces, or half a held block's length.
        half_y_mm: Along the closing direction, fingers wide open.
        below_mm: How far it reaches past the tool point along tool z.
    """

    half_x_mm: float
    half_y_mm: float
    below_mm: float

    @staticmethod
    def of_gripper(gripper: GripperProfile) -> HandShape:
        """Return the shape of the empty hand, fingers open to the full stroke."""
        return HandShape(
            half_x_mm=gripper.finger_width_mm / 2,
            half_y_mm=gripper.stroke_mm / 2 + gripper.finger_thickness_mm,
            below_mm=gripper.tip_below_tool_mm,
        )

    def holding(self, blocks: Iterable[BlockProfile]) -> HandShape:
        """Return the shape with the largest of some blocks gripped at its middle."""
        sizes = list(blocks)
        return HandShape(
            half_x_mm=max(self.half_x_mm, *(block.length_mm / 2 for block in sizes)),
            half_y_mm=max(self.half_y_mm, *(block.width_mm / 2 for block in sizes)),
            below_mm=max(self.below_mm, *(block.height_mm / 2 for block in sizes)),
        )


class Stance(NamedTuple):
    """The arm at one moment of a path.

    Attributes:
        t: Where on the path, 0 to 1.
        joints: Joint angles in degrees.
        points: The points along the arm.
        matrix: Robot-from-tool.
        links: Bounds of the links.
        hand: Bounds of the hand.
    """

    t: float
    joints: Joints
    points: LinkPoints
    matrix: Matrix34
    links: Bounds
    hand: Bounds

    @property
    def tool_mm(self) -> Point:
        """The tool point."""
        return self.points[6]

    @property
    def flange_z_mm(self) -> float:
        """Height of the flange."""
        return self.points[5][2]


class ArmHull:
    """Makes stances of one arm with one shape of hand."""

    __slots__ = ("_arm", "_hand", "_hull_half_z", "_hull_middle_z", "radii_mm")

    def __init__(self, arm: SixAxisArm, hand: HandShape) -> None:
        self._arm = arm
        self._hand = hand
        self._hull_half_z = 0.5 * (hand.below_mm + FINGER_LENGTH_MM)
        self._hull_middle_z = 0.5 * (hand.below_mm - FINGER_LENGTH_MM)
        shape = arm.geometry
        rod = shape.forearm_mm
        tool = sum(abs(offset) for offset in arm.tool_mm)
        past_wrist = shape.d6_mm + tool + hand.below_mm + hand.half_x_mm + hand.half_y_mm
        self.radii_mm = (shape.a1_mm + shape.a2_mm + rod, shape.a2_mm + rod, rod, past_wrist)
        """How far the arm reaches at most from J1, J2, J3 to the wrist, and past it."""

    def stance(self, t: float, joints: Joints) -> Stance:
        """Return the arm's stance at joint angles."""
        points, matrix = self._arm.chain(joints)
        _, (sx, sy, sz), (ex, ey, ez), (ox, oy, oz), (wx, wy, wz), (fx, fy, fz), _ = points
        r = LINK_RADIUS_MM
        links = (
            min(sx, ex, ox, wx) - r, min(sy, ey, oy, wy) - r, min(sz, ez, oz, wz) - r,
            max(sx, ex, ox, wx) + r, max(sy, ey, oy, wy) + r, max(sz, ez, oz, wz) + r,
        )  # fmt: skip
        r00, r01, r02, x, r10, r11, r12, y, r20, r21, r22, z = matrix
        half_x, half_y, half_z = self._hand.half_x_mm, self._hand.half_y_mm, self._hull_half_z
        middle, top = self._hull_middle_z, -FINGER_LENGTH_MM
        hx = abs(r00) * half_x + abs(r01) * half_y + abs(r02) * half_z
        hy = abs(r10) * half_x + abs(r11) * half_y + abs(r12) * half_z
        hz = abs(r20) * half_x + abs(r21) * half_y + abs(r22) * half_z
        cx, cy, cz = x + middle * r02, y + middle * r12, z + middle * r22
        gx, gy, gz = x + top * r02, y + top * r12, z + top * r22
        r, g = WRIST_RADIUS_MM, GRIPPER_RADIUS_MM
        hand = (
            min(wx - r, fx - r, gx - g, cx - hx), min(wy - r, fy - r, gy - g, cy - hy),
            min(wz - r, fz - r, gz - g, cz - hz), max(wx + r, fx + r, gx + g, cx + hx),
            max(wy + r, fy + r, gy + g, cy + hy), max(wz + r, fz + r, gz + g, cz + hz),
        )  # fmt: skip
        return Stance(t, joints, points, matrix, links, hand)

    def finger_bounds(self, stance: Stance) -> Bounds:
        """Return the bounds of fingers and held block alone."""
        m, hand = stance.matrix, self._hand
        halves = (hand.half_x_mm, hand.half_y_mm, self._hull_half_z)
        middle = self._hull_middle_z
        low, high = [], []
        for row in (0, 4, 8):
            half = sum(abs(m[row + axis]) * halves[axis] for axis in range(3))
            centre = m[row + 3] + middle * m[row + 2]
            low.append(centre - half)
            high.append(centre + half)
        return (low[0], low[1], low[2], high[0], high[1], high[2])

    def clearance_mm(self, stance: Stance, group: int, box: Bounds) -> float:
        """Return how far a group of bodies is from a box, negative by how deep it is in.

        Outside this is a distance (for the fingers a lower bound of it); inside it is
        the way out through the nearest face.
        """
        if group == 0:
            return min(_capsule(*body, box) for body in self._links(stance))
        fingers = max(separations(self.finger_bounds(stance), box))
        return min(fingers, *(_capsule(*body, box) for body in self._hand_axes(stance)))

    def way_mm(self, first: Stance, last: Stance, group: int) -> float:
        """Return how far a group of bodies moves at most, in a straight line."""
        p, q = first.points, last.points
        if group == 0:
            return max(dist(p[index], q[index]) for index in (1, 2, 3, 4))
        m, n = first.matrix, last.matrix
        turned = [dist((m[c], m[4 + c], m[8 + c]), (n[c], n[4 + c], n[8 + c])) for c in range(3)]
        corners = (
            dist(p[6], q[6])
            + turned[0] * self._hand.half_x_mm
            + turned[1] * self._hand.half_y_mm
            + turned[2] * max(self._hand.below_mm, FINGER_LENGTH_MM)
        )
        return max(corners, dist(p[4], q[4]), dist(p[5], q[5]))

    def _links(self, stance: Stance) -> tuple[tuple[Point, Point, float], ...]:
        p, r = stance.points, LINK_RADIUS_MM
        return ((p[1], p[2], r), (p[2], p[3], r), (p[3], p[4], r))

    def _hand_axes(self, stance: Stance) -> tuple[tuple[Point, Point, float], ...]:
        p, m, up = stance.points, stance.matrix, -FINGER_LENGTH_MM
        top = (m[3] + up * m[2], m[7] + up * m[6], m[11] + up * m[10])
        return ((p[4], p[5], WRIST_RADIUS_MM), (p[5], top, GRIPPER_RADIUS_MM))


def _capsule(start: Point, end: Point, radius_mm: float, box: Bounds) -> float:
    distance = segment_distance_mm(start, end, box) - radius_mm
    if distance >= 0.0:
        return distance
    bounds = (
        min(start[0], end[0]) - radius_mm, min(start[1], end[1]) - radius_mm,
        min(start[2], end[2]) - radius_mm, max(start[0], end[0]) + radius_mm,
        max(start[1], end[1]) + radius_mm, max(start[2], end[2]) + radius_mm,
    )  # fmt: skip
    return min(max(separations(bounds, box)), distance)
