"""The small arm of hobby servos of the lynx cell, behind its servo controller."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile

Five = tuple[float, float, float, float, float]


class LynxProfile(Table):
    """A Lynx (AL5D): five turning joints on an SSC-32; its fingers are a sixth servo."""

    model: Literal["lynx-al5d"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    joint_min_deg: Five
    joint_max_deg: Five
    joint_speed_deg_s: Five
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    rest_deg: Five
    """Joint angles where the arm stands aside."""
