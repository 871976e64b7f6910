"""The arms and seeded samples that the tests of kinematics share."""

from __future__ import annotations

import random

from cell.kinematics import RV_6SDL, Joints, SixAxisArm
from cell.profile import load_profile

MASH = SixAxisArm.from_profile(load_profile("mash").arm)
BARE = SixAxisArm(RV_6SDL, (-360.0,) * 6, (360.0,) * 6, (250.0, 267.0, 267.0, 352.0, 450.0, 660.0))
"""The same arm without a tool and practically without limits."""


def random_joints(seed: int, count: int, arm: SixAxisArm = MASH) -> list[Joints]:
    """Return joint angles within the arm's limits."""
    source = random.Random(seed)

    def one() -> Joints:
        j1, j2, j3, j4, j5, j6 = (
            source.uniform(low, high)
            for low, high in zip(arm.joint_min_deg, arm.joint_max_deg, strict=True)
        )
        return (j1, j2, j3, j4, j5, j6)

    return [one() for _ in range(count)]
