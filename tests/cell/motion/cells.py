"""The mash cell's guard and places, and cells with other boxes, for the tests of motion."""

from __future__ import annotations

from cell.geometry import JointPositions, LatticeMap, Pose
from cell.kinematics import SixAxisArm
from cell.motion.guard import Guard
from cell.motion.hull import HandShape
from cell.profile import BoxProfile, load_profile

PROFILE = load_profile("mash")
GUARD = Guard.from_profile(PROFILE)
ARM = GUARD.arm
REST = JointPositions(PROFILE.arm.rest_deg)
LATTICE = LatticeMap(
    step_mm=PROFILE.lattice.step_mm,
    angle_deg=PROFILE.lattice.angle_deg,
    origin_x_mm=PROFILE.lattice.origin_mm[0],
    origin_y_mm=PROFILE.lattice.origin_mm[1],
)
CORNERS = {f"({x}, {y})": LATTICE.to_robot(x, y) for x in (0, 11) for y in (0, 11)}
PLAN = [
    (55, 50), (165, 50), (275, 50), (385, 50), (495, 50), (55, 150), (165, 150), (275, 150),
    (385, 150), (495, 150), (55, 250), (165, 250), (275, 250), (495, 250), (55, 350), (165, 350),
    (275, 350), (495, 350), (385, 350),
]  # fmt: skip
"""The store's slots in plan coordinates, slot 1 first; 19 is the calibration cylinder's."""
SLOTS = {f"slot {index}": (-250.0 + x, 700.0 - y) for index, (x, y) in enumerate(PLAN, 1)}
TABLE = BoxProfile(name="table", min_mm=(-1500, -1500, -800), max_mm=(1500, 1500, 38.5))
POST = BoxProfile(name="post", min_mm=(500, -10, 38.5), max_mm=(520, 10, 200))


def guard_with(boxes: list[BoxProfile], *, flange_min_z_mm: float = 50.0) -> Guard:
    """Return the mash arm's guard among other boxes."""
    hand = HandShape.of_gripper(PROFILE.gripper)
    return Guard(
        SixAxisArm.from_profile(PROFILE.arm),
        boxes=boxes,
        flange_min_z_mm=flange_min_z_mm,
        max_linear_speed_mm_s=PROFILE.arm.max_linear_speed_mm_s,
        hand=hand,
        loaded_hand=hand.holding(PROFILE.blocks.values()),
    )


def standing(x_mm: float, y_mm: float, z_mm: float) -> JointPositions:
    """Return the joint angles over a place, gripper down."""
    return ARM.solve(Pose(x_mm, y_mm, z_mm), 7)
