"""Gripper, television and outputs of a cell."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile

Output = Annotated[int, Field(ge=0, le=255)]


class GripperProfile(Table):
    """The gripper and its fingers."""

    model: Literal["schunk-pg70"]
    """Which gripper it is: a SCHUNK PG-70, two fingers, motor driven."""
    enabled: bool = True
    """Whether the cell has its gripper; without it no block is moved."""
    serial: SerialProfile
    """The port of the gripper's module."""
    module_id: Annotated[int, Field(ge=1, le=255)] = 12
    """Number of the module on its bus."""
    stroke_mm: Positive
    """Greatest opening between the fingers."""
    open_mm: Positive
    """Opening with which a block is approached and released."""
    speed_mm_s: Positive
    """Speed of the opening."""
    acceleration_mm_s2: Positive
    """Acceleration of the opening."""
    grip_current_a: Positive
    """Motor current with which a block is gripped; it sets the force."""
    finger_width_mm: Positive
    """Size of a finger along the block's face."""
    finger_thickness_mm: Positive
    """Size of a finger along the closing direction."""
    tip_below_tool_mm: Positive
    """How far the fingertips reach past the tool point."""


class DisplayProfile(Table):
    """The television under the playground."""

    model: Literal["sharp-lc40le705"]
    """Which television it is: a Sharp LC-40LE705."""
    enabled: bool = True
    """Whether the cell has its television; without it the playground keeps its look."""
    serial: SerialProfile
    """The port of the television's remote control."""
    input: Annotated[int, Field(ge=1)] = 1
    """Number of the input that the computer's picture comes in at."""
    width_px: Annotated[int, Field(ge=1)] = 1920
    """Width of the picture."""
    height_px: Annotated[int, Field(ge=1)] = 1080
    """Height of the picture."""
    page_port: Annotated[int, Field(ge=1, le=65535)] = 8320
    """TCP port, on this computer, of the page that the television's browser shows."""
    corner_x_mm: float
    """Robot x of the picture's upper left corner."""
    corner_y_mm: float
    """Robot y of the picture's upper left corner."""
    angle_deg: float
    """Angle from robot X to the picture's rightward direction, counter-clockwise."""
    pixel_mm: Positive
    """Size of a pixel of the panel."""

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the picture."""
        return self.width_px * self.pixel_mm, self.height_px * self.pixel_mm

    def to_robot(self, right_mm: float, down_mm: float) -> tuple[float, float]:
        """Return robot x, y of a place so far right of and below the picture's corner."""
        turn = math.radians(self.angle_deg)
        cos, sin = math.cos(turn), math.sin(turn)
        return (
            self.corner_x_mm + cos * right_mm + sin * down_mm,
            self.corner_y_mm + sin * right_mm - cos * down_mm,
        )


class OutputsProfile(Table):
    """Which output of the arm controller switches what."""

    lights: Output
    """Bit of the cell's lights."""
    gripper_power: Output
    """Bit of the gripper's power."""
    magnet: Output
    """Bit of the electromagnet (tool 2)."""
