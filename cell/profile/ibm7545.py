"""The SCARA arm of the avrs cell, behind its slave's dual-port registers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile

Four = tuple[float, float, float, float]


class WorkSpaceProfile(Table):
    """The upright box that the tool point must not leave, in the robot frame."""

    min_mm: tuple[float, float, float]
    max_mm: tuple[float, float, float]


class ServoProfile(Table):
    """The master's servo law: torque = 0x800 + kp·e + kv·(e - e_prev)/period, e in pulses."""

    period_us: Annotated[int, Field(ge=100, le=65535)] = 1000
    """Sample period, as written to the slave's register."""
    kp: Four = (60.0, 60.0, 55.0, 60.0)
    """Torque counts for each pulse of error."""
    kv: Four = (0.1, 0.1, 0.1, 0.1)
    """Torque counts for each pulse a second of error's change."""


class Ibm7545Profile(Table):
    """An IBM 7545: two turning links, a sliding spindle, a roll."""

    model: Literal["ibm-7545"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    """The port of the bridge to the registers."""
    link_mm: tuple[Positive, Positive] = (400.0, 250.0)
    link_height_mm: Positive = 200.0
    """Height of the links' middle over the tool point at the spindle's upper end."""
    link_radius_mm: Positive = 80.0
    """Half the thickness of the links, as the guard sees them."""
    tool_radius_mm: Positive = 45.0
    """Half the thickness of spindle and gripper, as the guard sees them."""
    joint_min: Four
    """Least positions: deg, deg, mm, deg."""
    joint_max: Four
    joint_speed: Four
    """Greatest speeds: deg/s, deg/s, mm/s, deg/s."""
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    posture: Annotated[int, Field(ge=0, le=1)] = 0
    """0: the elbow bends counter-clockwise, as the arm is built; 1: clockwise."""
    rest: Four
    """Joint positions where the arm stands aside."""
    work_space: WorkSpaceProfile | None = None
    """Where the tool point may be; anywhere in reach without it."""
    servo: ServoProfile = ServoProfile()

    @property
    def rest_deg(self) -> Four:
        """The rest under the name that other arms' profiles have; the slide's is in mm."""
        return self.rest
