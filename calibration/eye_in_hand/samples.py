"""What is measured for an eye in hand: looks at a point, touches of it, looks at a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """The point as the camera saw it.

    Attributes:
        label: Its name, such as `look 3`.
        u_px: Column where the point was seen.
        v_px: Row where the point was seen.
        j1_deg: Joint 1 when it was seen.
        j2_deg: Joint 2 when it was seen.
    """

    label: str
    u_px: float
    v_px: float
    j1_deg: float
    j2_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """The gripper stood over the point.

    Attributes:
        label: Its name, such as `touch 1`.
        j1_deg: Joint 1.
        j2_deg: Joint 2.
    """

    label: str
    j1_deg: float
    j2_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LineLook:
    """A straight edge as the camera saw it; the edge lies still while the arm turns.

    Attributes:
        label: Its name, such as `edge 1`.
        alpha_deg: Its direction in the picture on the table's scale, counter-clockwise from
            the picture's right.
        j1_deg: Joint 1.
        j2_deg: Joint 2.
        direction_deg: Its direction in the robot frame where that is known, such as from two
            of its points that the gripper stood over; None where it is not.
    """

    label: str
    alpha_deg: float
    j1_deg: float
    j2_deg: float
    direction_deg: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Stages:
    """One two-stage measurement (appendix A).

    Attributes:
        label: Its name, such as `pair 1`.
        seen_deg: Joints 1 and 2 with the point on the reference pixel.
        over_deg: Joints 1 and 2 with the gripper over the point.
    """

    label: str
    seen_deg: tuple[float, float]
    over_deg: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """How exactly things are measured: standard deviations.

    The fit finds out how large they are together; only their ratios are taken as given.

    Attributes:
        look_px: Of a seen point, in each direction.
        touch_mm: Of the gripper over a point, in each direction.
        line_deg: Of a seen line's direction.
    """

    look_px: float = 0.4
    touch_mm: float = 0.2
    line_deg: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Everything that is fitted together; looks and touches are of one point.

    Attributes:
        looks: The point as it was seen.
        touches: The gripper over it.
        lines: One edge as it was seen.
        noise: How exactly.
    """

    looks: tuple[Look, ...]
    touches: tuple[Touch, ...] = ()
    lines: tuple[LineLook, ...] = ()
    noise: Noise = Noise()

    @property
    def pixels(self) -> Array:
        """Where the point was seen, shape (n, 2)."""
        return np.array([(look.u_px, look.v_px) for look in self.looks]).reshape(-1, 2)

    @property
    def look_joints(self) -> Array:
        """Joints 1 and 2 of the looks, shape (n, 2)."""
        return joints_of(self.looks)

    @property
    def touch_joints(self) -> Array:
        """Joints 1 and 2 of the touches, shape (m, 2)."""
        return joints_of(self.touches)


def joints_of(samples: Sequence[Look] | Sequence[Touch] | Sequence[LineLook]) -> Array:
    """Return joints 1 and 2 of samples, shape (n, 2)."""
    return np.array([(sample.j1_deg, sample.j2_deg) for sample in samples]).reshape(-1, 2)
