"""The look of the arm, its gripper and the camera pillars, as placed solids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from cell.kinematics import LinkPoints, Matrix34
from cell.profile import BoxProfile, GripperProfile
from cell.twin.cameras.figures import Figure, Matrix, Point
from cell.twin.cameras.shapes import Colour, Solid, ball, box, frustum, taper

_CAST: Colour = (0.80, 0.81, 0.79)
_COVER: Colour = (0.26, 0.28, 0.31)
_METAL: Colour = (0.55, 0.56, 0.58)
_GRIPPER: Colour = (0.33, 0.35, 0.38)
_JAW: Colour = (0.62, 0.63, 0.65)
_RUBBER: Colour = (0.14, 0.14, 0.15)
_PILLAR: Colour = (0.60, 0.62, 0.64)
_CAMERA: Colour = (0.16, 0.17, 0.19)
_GLOSS = 0.35

_JAW_START_MM = 88.0
_FINGER_START_MM = 108.0
_PAD_MM = 30.0


class ArmSkeleton(Protocol):
    """What drawing needs of the arm's kinematics."""

    def chain(self, joints_deg: tuple[float, ...]) -> tuple[LinkPoints, Matrix34]:
        """Return the points along the arm and robot-from-tool."""


def place(
    solid: Solid, rotation: Matrix, place_mm: Point, colour: Colour, gloss: float = _GLOSS
) -> Figure:
    """Return a solid of the machinery at a place."""
    return Figure(solid, rotation, place_mm, colour, gloss)


def _frame(along: Point, side: Point) -> Matrix:
    """Return the rotation whose z is `along` and whose y is as near to `side` as can be."""
    z = along / math.sqrt(along @ along)
    y = side - z * (side @ z)
    y /= math.sqrt(y @ y)
    (yx, yy, yz), (zx, zy, zz) = y.tolist(), z.tolist()
    # Written out: numpy's cross product takes longer than all the rest.
    return np.array(
        [
            [yy * zz - yz * zy, yx, zx],
            [yz * zx - yx * zz, yy, zy],
            [yx * zy - yy * zx, yz, zz],
        ]
    )


def _drum(
    centre: Point,
    axis: Point,
    radius_mm: float,
    half_mm: float,
    cap_mm: float,
) -> list[Figure]:
    """Return a joint's drum with its two dark covers."""
    up = np.array([0.0, 0.0, 1.0])
    rotation = _frame(axis, up if abs(axis[2]) < 0.9 else np.array([1.0, 0.0, 0.0]))
    parts = [
        place(frustum(radius_mm, radius_mm, 2 * half_mm), rotation, centre - axis * half_mm, _CAST)
    ]
    for sign in (-1.0, 1.0):
        turned = rotation @ np.diag([1.0, sign, sign])
        foot = centre + axis * sign * half_mm
        parts.append(place(frustum(cap_mm, cap_mm - 6, 12.0, 16), turned, foot, _COVER))
    return parts


@lru_cache(maxsize=8)
def arm_figures(points: LinkPoints, surface_mm: float) -> tuple[Figure, ...]:
    """Return the arm from its base to its flange, in the look of an RV-6SDL."""
    shoulder, elbow, axis, wrist, flange = (np.array(p) for p in points[1:6])
    turn = math.atan2(shoulder[1], shoulder[0])
    cos, sin = math.cos(turn), math.sin(turn)
    radial, side = np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])
    upright = np.stack([radial, side, np.array([0.0, 0.0, 1.0])], axis=1)
    still = np.eye(3)
    floor = np.array([0.0, 0.0, surface_mm])
    motor_box = taper((120, 150), (110, 130), 150.0)
    figures = [
        place(taper((300, 300), (270, 270), 70.0, 0.2), still, floor, _COVER),
        place(frustum(124, 112, 110.0), still, floor + (0, 0, 70.0), _CAST),
        place(taper((250, 230), (220, 215), 120.0), upright, floor + (0, 0, 180.0), _CAST),
        place(motor_box, upright, floor + (0, 0, 300.0) - radial * 75, _COVER),
        *_drum(shoulder, side, 92.0, 104.0, 66.0),
    ]
    upper = _frame(elbow - shoulder, side)
    length = float(np.linalg.norm(elbow - shoulder))
    figures += _bar(shoulder, upper, (0.0, length), (168, 132), (122, 116), pieces=2)
    figures += _drum(elbow, side, 68.0, 88.0, 48.0)
    fore_rotation = _frame(wrist - axis, side)
    fore = fore_rotation[:, 2]
    reach = float(np.linalg.norm(wrist - axis))
    offset = _frame(axis - elbow, side) if np.linalg.norm(axis - elbow) > 1 else fore_rotation
    figures += _bar(elbow, offset, (10.0, 100.0), (130, 140), (136, 132), pieces=1)
    figures += _bar(axis - fore * 95.0, fore_rotation, (0.0, 165.0), (128, 122), (136, 128), 1)
    figures += _bar(axis, fore_rotation, (70.0, reach - 40.0), (122, 112), (88, 94), pieces=2)
    figures.append(place(frustum(30, 44, 6.0), fore_rotation, axis - fore * 101, _COVER))
    tip = _frame(flange - wrist, side if abs((flange - wrist) @ side) < 80 else radial)
    figures += [
        place(frustum(46, 52, 14.0), fore_rotation, wrist - fore * 52, _COVER),
        place(ball(54.0), still, wrist, _CAST),
        place(frustum(44, 40, 44.0), tip, wrist + tip[:, 2] * 30, _CAST),
        place(frustum(36, 36, 11.0), tip, flange - tip[:, 2] * 11, _METAL, 0.7),
    ]
    return tuple(figures)


def _bar(
    origin: Point,
    rotation: Matrix,
    reach_mm: tuple[float, float],
    start_mm: tuple[float, float],
    end_mm: tuple[float, float],
    pieces: int,
) -> list[Figure]:
    """Return a tapered bar along a frame's z, cut so that it sorts well by distance."""
    figures = []
    length = (reach_mm[1] - reach_mm[0]) / pieces
    for piece in range(pieces):
        low, high = piece / pieces, (piece + 1) / pieces
        widths = [
            tuple(round(s + (e - s) * share, 6) for s, e in zip(start_mm, end_mm, strict=True))
            for share in (low, high)
        ]
        solid = taper((widths[0][0], widths[0][1]), (widths[1][0], widths[1][1]), round(length, 6))
        foot = origin + rotation[:, 2] * (reach_mm[0] + piece * length)
        figures.append(place(solid, rotation, foot, _CAST))
    return figures


@dataclass(frozen=True, slots=True)
class GripperLook:
    """Sizes of the gripper as drawn.

    Attributes:
        profile: Sizes of the fingers.
        tool_mm: Flange to tool point along the tool's z.
        camera_mm: Where a camera hangs on the flange, None without one.
    """

    profile: GripperProfile
    tool_mm: float
    camera_mm: tuple[float, float, float] | None

    def body(self, rotation: Matrix, tool_point: Point) -> list[Figure]:
        """Return what does not move in the tool frame, from the flange down."""
        flange = tool_point - rotation[:, 2] * self.tool_mm
        down = rotation[:, 2]
        figures = [
            place(frustum(45, 45, 12.0), rotation, flange, _METAL, 0.7),
            place(box(66, 112, _JAW_START_MM - 12.0, 60.0), rotation, flange + down * 12, _GRIPPER),
        ]
        if self.camera_mm is not None:
            x, y, z = self.camera_mm
            at = flange + rotation @ np.array([x, y, z - 38.0])
            figures.append(place(box(30, 30, 34.0, 60.0), rotation, at, _CAMERA))
        return figures

    def finger(
        self,
        rotation: Matrix,
        tool_point: Point,
        opening_mm: float,
        sign: float,
    ) -> list[Figure]:
        """Return jaw, finger and rubber tip on one side of the tool's y, from the jaw down."""
        flange = tool_point - rotation[:, 2] * self.tool_mm
        thick = self.profile.finger_thickness_mm
        width = self.profile.finger_width_mm
        end = self.tool_mm + self.profile.tip_below_tool_mm
        aside = rotation[:, 1] * (sign * (opening_mm + thick) / 2)
        jaw_aside = aside + rotation[:, 1] * (sign * 3.0)
        down = rotation[:, 2]
        metal = end - _PAD_MM - _FINGER_START_MM
        return [
            place(box(width + 14, thick + 10, _FINGER_START_MM - _JAW_START_MM, 60.0),
                  rotation, flange + jaw_aside + down * _JAW_START_MM, _JAW, 0.6),
            place(box(width, thick, metal), rotation,
                  flange + aside + down * _FINGER_START_MM, _JAW, 0.6),
            place(box(width, thick, _PAD_MM), rotation,
                  flange + aside + down * (end - _PAD_MM), _RUBBER, 0.2),
        ]  # fmt: skip


def box_figures(boxes: tuple[BoxProfile, ...], surface_mm: float) -> tuple[Figure, ...]:
    """Return the cell's boxes that stand on the table, such as the camera pillars.

    Each is cut into pieces, so that they sort well by distance.
    """
    figures = []
    for item in boxes:
        if item.max_mm[2] <= surface_mm:
            continue
        low = np.maximum(np.array(item.min_mm), (-math.inf, -math.inf, surface_mm))
        size = np.array(item.max_mm) - low
        pieces = max(1, round(float(size[2]) / 250))
        solid = box(float(size[0]), float(size[1]), float(size[2]) / pieces, 60.0)
        for piece in range(pieces):
            foot = low + size * (0.5, 0.5, piece / pieces)
            figures.append(place(solid, np.eye(3), foot, _PILLAR))
    return tuple(figures)
