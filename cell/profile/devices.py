"""Gripper, television and outputs of a cell."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile


class GripperProfile(Table):
    """The gripper and its fingers."""

    model: Literal["schunk-pg70"]
    enabled: bool = True
    """Whether the cell has its gripper; without it no block is moved."""
    serial: SerialProfile
    module_id: Annotated[int, Field(ge=1, le=255)] = 12
    stroke_mm: Positive
    open_mm: Positive
    """Opening with which a block is approached and released."""
    speed_mm_s: Positive
    acceleration_mm_s2: Positive
    grip_current_a: Positive
    finger_width_mm: Positive
    """Size of a finger along the block's face."""
    finger_thickness_mm: Positive
    """Size of a finger along the closing direction."""
    tip_below_tool_mm: Positive
    """How far the fingertips reach past the tool point."""


class DisplayProfile(Table):
    """The television under the playground."""

    model: Literal["sharp-lc40le705"]
    enabled: bool = True
    """Whether the cell has its television; without it the playground keeps its look."""
    serial: SerialProfile
    input: int = 1
    width_px: int = 1920
    height_px: int = 1080
    corner_x_mm: float
    """Robot x of the picture's upper left corner."""
    corner_y_mm: float
    """Robot y of the picture's upper left corner."""
    angle_deg: float
    """Angle from robot X to the picture's rightward direction, counter-clockwise."""
    pixel_mm: Positive
    """Size of a pixel of the panel."""


class OutputsProfile(Table):
    """Which output of the arm controller switches what."""

    lights: int
    gripper_power: int
    magnet: int
