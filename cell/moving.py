"""Moves over the playground as the cell's users ask for them."""

from __future__ import annotations

from cell.geometry import Pose
from cell.motion.guarded import GuardedArm


def move_over_table(
    arm: GuardedArm,
    service_mm: float,
    *,
    x_mm: float,
    y_mm: float,
    z_mm: float,
    rotation_deg: float,
) -> None:
    """Bring the tool point, gripper down, to a place above the table (robot frame).

    In a straight line when it stands at that height already; otherwise up to the service
    height, over, and down.

    Raises:
        ResumeRefused: The arm is held, and the check says no.
        MotionRefused: The guard turned it down.
        DeviceError: The arm did not get there.
    """
    arm.ensure_clear()
    target = Pose(x_mm, y_mm, z_mm, 180.0, 0.0, rotation_deg)
    here = arm.pose()
    if here == target:
        return
    if here.z_mm != z_mm or here.c_deg != rotation_deg:
        arm.raise_to(service_mm)
        arm.move_joint(target.at_height(max(z_mm, service_mm)))
    arm.move_linear(target)
