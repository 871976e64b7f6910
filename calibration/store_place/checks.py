"""Whether a store can be where it is said to lie: every slot in reach, none on the screen."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from calibration.verdict import Finding, Grade
from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import JointPositions, Pose
from cell.motion.guard import Guard
from cell.profile import DisplayProfile, Profile, StoreProfile
from cell.store import StorePlan, TablePlace, place_of_slot

Points = NDArray[np.float64]


def reach_finding(profile: Profile, plan: StorePlan, store: StoreProfile) -> Finding | None:
    """Return which slots the guarded arm cannot serve, at travelling and at laying height."""
    guard = Guard.from_profile(profile)
    rest = JointPositions(tuple(profile.arm.rest_deg))
    refused: list[tuple[int, str]] = []
    for slot in plan.slots:
        problem = _problem(guard, profile, rest, place_of_slot(slot, store))
        if problem:
            refused.append((slot.number, problem))
    if not refused:
        return None
    numbers = ", ".join(str(number) for number, _ in refused)
    return Finding(
        code="out-of-reach",
        grade=Grade.BAD,
        text=f"the arm cannot serve slot{'s' * (len(refused) > 1)} {numbers} there; slot "
        f"{refused[0][0]}: {refused[0][1]}",
        hint="move the sheet nearer to the arm or away from what is in the way",
    )


def screen_finding(
    display: DisplayProfile, store: StoreProfile, size_mm: tuple[float, float]
) -> Finding | None:
    """Return whether the sheet lies over the screen's picture."""
    wide, tall = size_mm
    sheet = _rectangle(store.corner_mm, store.angle_deg, wide, tall)
    panel = _rectangle(
        (display.corner_x_mm, display.corner_y_mm),
        display.angle_deg,
        display.width_px * display.pixel_mm,
        display.height_px * display.pixel_mm,
    )
    depth = overlap_mm(sheet, panel)
    if depth <= 0.0:
        return None
    return Finding(
        code="over-screen",
        grade=Grade.BAD,
        text=f"the sheet reaches {depth:.1f} mm over the screen's picture",
        hint="move the sheet off the screen; if it lies beside it, touch the corners again, or "
        "calibrate where the screen is",
    )


def overlap_mm(first: Points, second: Points) -> float:
    """Return how far two rectangles (4, 2) reach into each other; 0 or less if they do not.

    The smallest overlap over the directions of all sides (separating axes).
    """
    least = math.inf
    for corners in (first, second):
        for side in (corners[1] - corners[0], corners[3] - corners[0]):
            axis = side / np.linalg.norm(side)
            one, other = first @ axis, second @ axis
            least = min(least, float(min(one.max(), other.max()) - max(one.min(), other.min())))
    return least


def _problem(guard: Guard, profile: Profile, rest: JointPositions, place: TablePlace) -> str:
    """Return why a slot cannot be served, empty if it can."""
    arm, heights = profile.arm, profile.heights
    over = _grip_pose(place, heights.service_mm)
    try:
        guard.check_pose_joint(rest, over, posture=arm.posture, percent=arm.joint_speed_percent)
        above = guard.arm.solve(over, arm.posture, rest)
        for holds_block in (False, True):
            guard.check_linear(
                above,
                over.at_height(heights.laying_mm),
                posture=arm.posture,
                speed_mm_s=arm.linear_speed_mm_s,
                holds_block=holds_block,
            )
    except (MotionRefused, UnreachablePose) as error:
        return str(error)
    return ""


def _grip_pose(place: TablePlace, z_mm: float) -> Pose:
    """Return the pose of the gripper over a block, turned the short way."""
    turn = (place.yaw_deg + 90.0) % 180.0 - 90.0
    c_deg = 180.0 + turn if turn <= 0 else turn - 180.0
    return Pose(place.x_mm, place.y_mm, z_mm, 180.0, 0.0, c_deg)


def _rectangle(
    corner_mm: tuple[float, float], angle_deg: float, wide_mm: float, tall_mm: float
) -> Points:
    angle = math.radians(angle_deg)
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([along[1], -along[0]])
    corner = np.array(corner_mm)
    return np.array(
        [
            corner,
            corner + along * wide_mm,
            corner + along * wide_mm + across * tall_mm,
            corner + across * tall_mm,
        ]
    )
