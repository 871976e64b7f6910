"""Appendix A's measurement: a point under the reference pixel, then the gripper over it.

With S = J1 + J2 of the first stage and (Δx, Δy) the way from the gripper's first place to its
second, d_t_c = |Δ| and b_angl = 180° - S + atan2(Δy, Δx). The printed A.5 adds
δ = atan(Δx/Δy) where it has to be taken away: with the source's own figures (J 45° and 105°,
b_angl 137.7°) it would give 102.3°.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan2, degrees, hypot, radians

import numpy as np
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.eye_in_hand.samples import Stages
from cell.geometry.eye_in_hand import EyeInHand, turned

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TwoStage:
    """What the repeated measurement gave.

    Attributes:
        d_t_c_mm: Mean distance from gripper to reference point.
        b_angle_deg: Direction of the mean.
        covariance: Of d_t_c (mm) and b_angle (deg), shape (2, 2); NaN from a single pair.
        freedom: Degrees of freedom of the spread.
        offsets_mm: The way to the reference point in link 2's frame, one a pair, shape (n, 2).
        spread_mm: Standard deviation of one pair in each direction; NaN from a single one.
    """

    d_t_c_mm: float
    b_angle_deg: float
    covariance: Array
    freedom: int
    offsets_mm: Array
    spread_mm: float

    @property
    def mean_mm(self) -> Array:
        """Mean of the offsets, shape (2,)."""
        mean: Array = self.offsets_mm.mean(axis=0)
        return mean

    def put_into(self, eye: EyeInHand) -> EyeInHand:
        """Return an eye with the measured distance and direction."""
        return replace(eye, d_t_c_mm=self.d_t_c_mm, b_angle_deg=self.b_angle_deg)


def two_stage(pairs: Sequence[Stages], eye: EyeInHand) -> TwoStage:
    """Average the ways from gripper to reference point.

    The ways are averaged as vectors in link 2's frame; their spread is taken to be the same in
    both directions, so that n pairs leave 2(n - 1) degrees of freedom.

    Args:
        pairs: One or more measurements.
        eye: Where the links' lengths come from.

    Raises:
        FitFailed: There is none, or the gripper stood in the same place in both stages.
    """
    if not pairs:
        raise FitFailed("no two-stage measurement; take two or three")
    seen = np.array([pair.seen_deg for pair in pairs])
    over = np.array([pair.over_deg for pair in pairs])
    ways = eye.gripper(over) - eye.gripper(seen)
    offsets = turned(ways, -seen.sum(axis=1))
    x, y = offsets.mean(axis=0)
    distance = hypot(x, y)
    if distance < 1.0:
        raise FitFailed(
            "the gripper stood in the same place in both stages; in the second it has to stand "
            "over the point that the first had on the reference pixel"
        )
    freedom = 2 * (len(pairs) - 1)
    spread = float(np.sqrt(((offsets - (x, y)) ** 2).sum() / freedom)) if freedom else float("nan")
    per_deg = distance * radians(1.0)
    return TwoStage(
        d_t_c_mm=distance,
        b_angle_deg=(180.0 + degrees(atan2(y, x))) % 360.0,
        covariance=np.diag([1.0, per_deg**-2]) * spread**2 / len(pairs),
        freedom=freedom,
        offsets_mm=offsets,
        spread_mm=spread,
    )
