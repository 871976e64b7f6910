"""The arms that there are: controller, limits, speeds, wires."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile, TcpProfile


class MelfaProfile(Table):
    """The arm, its controller and its limits."""

    model: Literal["melfa-rv6sdl"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    tcp: TcpProfile | None = None
    """Where the controller is reached over the network; used instead of the port if given."""
    robot: Annotated[int, Field(ge=1, le=3)] = 1
    slot: Annotated[int, Field(ge=1, le=32)] = 1
    joint_min_deg: tuple[float, float, float, float, float, float]
    joint_max_deg: tuple[float, float, float, float, float, float]
    joint_speed_deg_s: tuple[float, float, float, float, float, float]
    flange_min_z_mm: float
    tool_mm: tuple[float, float, float] = (0.0, 0.0, 159.2)
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    posture: Annotated[int, Field(ge=0, le=7)] = 7
    """The controller's flags FL1 used for every pose; 7 is right, above, non-flip."""
    rest_deg: tuple[float, float, float, float, float, float]
    """Joint angles where the arm stands aside, out of every camera's way."""
