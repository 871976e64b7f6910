"""The SCARA arm of the avrs cell, behind its slave's dual-port registers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile

Four = tuple[float, float, float, float]


class Ibm7545Profile(Table):
    """An IBM 7545: two turning links, a sliding spindle, a roll."""

    model: Literal["ibm-7545"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    """The port of the bridge to the registers."""
    link_mm: tuple[Positive, Positive] = (400.0, 250.0)
    joint_min: Four
    """Least positions: deg, deg, mm, deg."""
    joint_max: Four
    joint_speed: Four
    """Greatest speeds: deg/s, deg/s, mm/s, deg/s."""
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    rest: Four
    """Joint positions where the arm stands aside."""
