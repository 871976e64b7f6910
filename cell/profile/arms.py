"""The arms that there are: controller, limits, speeds, wires."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile, TcpProfile


class MelfaProfile(Table):
    """The arm, its controller and its limits."""

    model: Literal["melfa-rv6sdl"]
    """Which arm it is: a Mitsubishi RV-6SDL, six turning joints, on a CRnD controller."""
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    """The port of the controller."""
    tcp: TcpProfile | None = None
    """Where the controller is reached over the network; used instead of the port if given."""
    tcp_framing: Literal["text", "hc"] = "text"
    """How messages travel over the network: as plain text, or in the HC frames that the maker's
    tool speaks; the controller is asked to change to them whenever it is connected to."""
    robot: Annotated[int, Field(ge=1, le=3)] = 1
    """Number of the robot at the controller."""
    slot: Annotated[int, Field(ge=1, le=32)] = 1
    """Task slot of the controller that runs the program."""
    joint_min_deg: tuple[float, float, float, float, float, float]
    """Least angles of J1 to J6 (the controller's MEJAR)."""
    joint_max_deg: tuple[float, float, float, float, float, float]
    """Greatest angles of J1 to J6 (the controller's MEJAR)."""
    joint_speed_deg_s: tuple[float, float, float, float, float, float]
    """Greatest speeds of J1 to J6."""
    flange_min_z_mm: float
    """Lowest height of the flange above the robot's base plane (the controller's MEPAR)."""
    tool_mm: tuple[float, float, float] = (0.0, 0.0, 159.2)
    """Tool point from the flange (the controller's MEXTL)."""
    linear_speed_mm_s: Positive
    """Speed of the tool point along lines, unless another is set."""
    max_linear_speed_mm_s: Positive
    """Greatest speed of the tool point that may be set."""
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    """Share of the joints' full speed in joint moves, unless another is set."""
    posture: Annotated[int, Field(ge=0, le=7)] = 7
    """The controller's flags FL1 used for every pose; 7 is right, above, non-flip."""
    rest_deg: tuple[float, float, float, float, float, float]
    """Joint angles where the arm stands aside, out of every camera's way."""
