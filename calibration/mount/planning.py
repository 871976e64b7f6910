"""Poses to look from: those that tell most, that the guard passes.

Each next pose is the one that adds most to the information about lens, mount and target
(D-optimal design, greedy), reckoned with where the camera roughly hangs.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from calibration.mount.fit import ArmNoise, information
from calibration.mount.model import MountState, MountView, Scene, transform, turned
from calibration.mount.targets import Target
from cell.errors import MotionRefused, UnreachablePose
from cell.geometry import JointPositions, Pose, Transform
from cell.motion.guard import Guard
from cell.profile import Profile

Points = NDArray[np.float64]

_DISTANCES_MM = (270.0, 340.0, 410.0)
_LEANS_DEG = ((0, 0), (20, 0), (-20, 0), (0, 20), (0, -20), (15, 15), (-15, -15), (28, 0), (0, 28))
_TURNS_DEG = (0.0, 90.0, 180.0, 270.0)
_SHARES = (0.35, 0.65)
_EDGE_PX = 50.0
_SIGMA_PX = 0.3
_LEAST_SEEN = 1.3
_MOST_SEEN = 40
_PRIOR = np.array([90.0, 20, 20, 0.2, 0.2, *[0.1] * 3, *[30.0] * 3, *[0.05] * 3, *[30.0] * 3])
"""Standard deviations of what is known beforehand, so that the first choices are defined."""


class Poses:
    """Chooses one pose after the other.

    Args:
        profile: The cell's profile.
        target: What is looked at.
        guess: Roughly the lens and the mount.
        noise: How exact the arm is.
        aside_deg: How far all are turned about the camera's view, so that others are fresh.
    """

    def __init__(
        self,
        profile: Profile,
        target: Target,
        guess: MountState,
        noise: ArmNoise,
        *,
        aside_deg: float = 0.0,
    ) -> None:
        self._profile = profile
        self._guard = Guard.from_profile(profile)
        tool = np.eye(4)
        tool[:3, 3] = profile.arm.tool_mm
        self._flange_from_tool = Transform(tool)
        self._known = np.diag(1.0 / _PRIOR**2)
        self._left: list[tuple[Pose, Points]] = []
        for flange in _flanges(target, guess, aside_deg):
            view = MountView(
                label="", robot_from_flange=flange, points_mm=target.points_mm,
                pixels=np.zeros((len(target.points_mm), 2)),
            )  # fmt: skip
            inside = np.flatnonzero(Scene([view]).inside(guess, _EDGE_PX))
            if len(inside) < _LEAST_SEEN * target.least:
                continue
            inside = inside[:: max(1, len(inside) // _MOST_SEEN)]
            seen = MountView(
                label="", robot_from_flange=flange, points_mm=target.points_mm[inside],
                pixels=np.zeros((len(inside), 2)),
            )  # fmt: skip
            told = information(Scene([seen]), guess, noise, _SIGMA_PX)
            self._left.append(((flange @ self._flange_from_tool).to_pose(), told))

    def flange(self, pose: Pose) -> Transform:
        """Return robot_from_flange of a pose of the tool point."""
        return Transform.from_pose(pose) @ self._flange_from_tool.inverse()

    def next(self, here: JointPositions) -> Pose | None:
        """Return the best pose that the guard lets the arm go to from here, None if none is left.

        Args:
            here: Where the arm's joints are.
        """
        arm = self._profile.arm
        while self._left:
            gains = np.linalg.slogdet(self._known + np.stack([told for _, told in self._left]))[1]
            pose, told = self._left.pop(int(np.argmax(gains)))
            try:
                self._guard.check_pose_joint(
                    here, pose, posture=arm.posture, percent=arm.joint_speed_percent
                )
            except (MotionRefused, UnreachablePose):
                continue
            self._known = self._known + told
            return pose
        return None


def _flanges(target: Target, guess: MountState, aside_deg: float) -> list[Transform]:
    """Return places of the flange from which the camera looks at parts of the target."""
    found = []
    wide, tall = target.size_mm
    flange_from_camera = guess.flange_from_camera
    for distance, lean, turn, across, down in itertools.product(
        _DISTANCES_MM, _LEANS_DEG, _TURNS_DEG, _SHARES, _SHARES
    ):
        aim = target.guess.apply(np.array([across * wide, down * tall, 0.0]))
        leaned = turned(np.array([math.radians(lean[0]), math.radians(lean[1]), 0.0]))
        rolled = turned(np.array([0.0, 0.0, math.radians(turn + aside_deg)]))
        looking = target.guess.rotation @ leaned @ rolled
        camera = transform(looking, aim - distance * looking[:, 2])
        found.append(camera @ flange_from_camera.inverse())
    return found
