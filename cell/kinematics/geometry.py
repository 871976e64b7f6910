"""Dimensions of six-axis arms with an offset shoulder and elbow and a ball wrist.

The family has J1 upright, J2 and J3 parallel to the floor, and J4, J5, J6 meeting
in one point. In the controller's joint angles its orientation is
R = Rz(J1) · Ry(J2 + J3) · Rz(J4) · Ry(J5) · Rz(J6); all angles 0 is the arm
stretched upwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from types import MappingProxyType


@dataclass(frozen=True, slots=True, kw_only=True)
class SixAxisGeometry:
    """Lengths of one arm, named as in its Denavit-Hartenberg table.

    Attributes:
        d1_mm: Base plane to shoulder (J2).
        a1_mm: J1 axis to shoulder.
        a2_mm: Upper arm, shoulder to elbow (J3).
        a3_mm: Elbow to the axis of the forearm.
        d4_mm: Forearm, up to the wrist's centre.
        d6_mm: Wrist's centre to flange.
    """

    d1_mm: float
    a1_mm: float
    a2_mm: float
    a3_mm: float
    d4_mm: float
    d6_mm: float

    def __post_init__(self) -> None:
        if self.a2_mm <= 0 or self.forearm_mm <= 0 or self.inner_reach_mm < 1e-6:
            raise ValueError(
                f"upper arm {self.a2_mm} mm and forearm {self.forearm_mm:.3f} mm must be positive "
                "and differ, or the wrist could lie in the shoulder"
            )

    @property
    def forearm_mm(self) -> float:
        """Elbow to wrist's centre in a straight line."""
        return hypot(self.a3_mm, self.d4_mm)

    @property
    def outer_reach_mm(self) -> float:
        """Largest distance of the wrist's centre from the shoulder."""
        return self.a2_mm + self.forearm_mm

    @property
    def inner_reach_mm(self) -> float:
        """Smallest distance of the wrist's centre from the shoulder."""
        return abs(self.a2_mm - self.forearm_mm)


RV_6SDL = SixAxisGeometry(d1_mm=350, a1_mm=85, a2_mm=380, a3_mm=100, d4_mm=425, d6_mm=85)
"""Mitsubishi RV-6SDL (and RV-6SL): 902 mm reach."""

RV_6SD = SixAxisGeometry(d1_mm=350, a1_mm=85, a2_mm=280, a3_mm=100, d4_mm=315, d6_mm=85)
"""Mitsubishi RV-6SD (and RV-6S): 696 mm reach; figures not confirmed by a second source."""

GEOMETRIES: Mapping[str, SixAxisGeometry] = MappingProxyType({"melfa-rv6sdl": RV_6SDL})
"""Geometry of each arm model that a profile may name."""
