"""Where the arm stands, and what its controller knows of its kinematics."""

from __future__ import annotations

import math
from typing import Protocol

from cell.geometry import JointPositions, Pose
from cell.twin.bodies import JointTuple


class ArmKinematics(Protocol):
    """What the controller needs to know of its arm; poses are the tool point's."""

    def solve(
        self,
        pose: Pose,
        posture: int,
        near: JointPositions | None = None,
        turns: int | None = None,
    ) -> JointPositions:
        """Return the joint angles of a pose in a posture (FL1) and turn (FL2).

        Raises:
            UnreachablePose: There are none within the limits.
        """

    def forward(self, joints: JointPositions) -> Pose:
        """Return the pose of joint angles."""

    def posture(self, joints: JointPositions) -> int:
        """Return the flag FL1 of joint angles."""

    def turns(self, joints: JointPositions) -> int:
        """Return the flag FL2 of joint angles."""


class Stand:
    """Where the arm stands: joints, pose and flags, computed when first asked for."""

    __slots__ = ("joints_deg", "_kinematics", "_pose", "_posture", "_reported")

    def __init__(
        self,
        kinematics: ArmKinematics,
        joints_deg: JointTuple,
        pose: Pose | None = None,
        posture: int | None = None,
    ) -> None:
        self.joints_deg = joints_deg
        self._kinematics = kinematics
        self._pose = pose
        self._posture = posture
        self._reported = pose if pose is not None and _is_canonical(pose) else None

    @property
    def pose(self) -> Pose:
        """The pose, as it was asked for if the arm was sent there."""
        if self._pose is None:
            self._pose = self.reported_pose
        return self._pose

    @property
    def reported_pose(self) -> Pose:
        """The pose with its angles in the range in which they are reported."""
        if self._reported is None:
            self._reported = self._kinematics.forward(JointPositions(self.joints_deg))
        return self._reported

    @property
    def posture(self) -> int:
        """The flag FL1."""
        if self._posture is None:
            self._posture = self._kinematics.posture(JointPositions(self.joints_deg))
        return self._posture

    @property
    def turns(self) -> int:
        """The flag FL2."""
        if min(self.joints_deg) >= -180.0 and max(self.joints_deg) <= 180.0:
            return 0
        return self._kinematics.turns(JointPositions(self.joints_deg))


def six(angles_deg: tuple[float, ...]) -> JointTuple:
    """Return six joint angles as the twin's tuple."""
    a, b, c, d, e, f = angles_deg
    return a, b, c, d, e, f


def flange_height_mm(pose: Pose, tool_mm: tuple[float, float, float]) -> float:
    """Return the flange's height: the tool point's less the third row of R times the tool."""
    a, b = math.radians(pose.a_deg), math.radians(pose.b_deg)
    level = math.cos(b)
    x, y, z = tool_mm
    return pose.z_mm + math.sin(b) * x - level * (math.sin(a) * y + math.cos(a) * z)


def _is_canonical(pose: Pose) -> bool:
    """Return whether the angles are the ones that the pose's rotation would be printed with."""
    return (
        -180.0 < pose.a_deg <= 180.0 and -90.0 < pose.b_deg < 90.0 and -180.0 < pose.c_deg <= 180.0
    )
