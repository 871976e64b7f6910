"""Where a tool is: Cartesian poses and joint positions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and orientation in the robot frame, as the arm controller gives it.

    The orientation is R = Rz(c) · Ry(b) · Rx(a): rotations about the fixed X,
    then Y, then Z axis of the robot frame (the MELFA convention).
    """

    x_mm: float
    y_mm: float
    z_mm: float
    a_deg: float = 180.0
    b_deg: float = 0.0
    c_deg: float = 180.0

    def at_height(self, z_mm: float) -> Pose:
        """Return the same pose at another height."""
        return Pose(self.x_mm, self.y_mm, z_mm, self.a_deg, self.b_deg, self.c_deg)

    def __str__(self) -> str:
        return (
            f"({self.x_mm:.2f}, {self.y_mm:.2f}, {self.z_mm:.2f}) mm "
            f"({self.a_deg:.2f}, {self.b_deg:.2f}, {self.c_deg:.2f}) deg"
        )


@dataclass(frozen=True, slots=True)
class JointPositions:
    """Where every joint stands, in controller convention, J1 first.

    Degrees for joints that turn, millimetres for those that slide (the third of a SCARA);
    which is which, the arm's kinematics knows.
    """

    values: tuple[float, ...]

    def __str__(self) -> str:
        return "(" + ", ".join(f"{value:.2f}" for value in self.values) + ")"
