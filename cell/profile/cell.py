"""A whole cell: what every cell has, and what a cell with a playground has besides."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cell.profile.arms import MelfaProfile
from cell.profile.cameras import CameraProfile, TwinCameraProfile, WebCameraProfile
from cell.profile.devices import DisplayProfile, GripperProfile, OutputsProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.lynx import LynxProfile
from cell.profile.playground import (
    BlockProfile,
    BoxProfile,
    HeightsProfile,
    LatticeProfile,
    ManipulationProfile,
    StoreProfile,
)
from cell.profile.table import Kind, Positive, Table
from cell.profile.watching import ReportsProfile, WatchdogProfile


class ServerProfile(Table):
    """How experiment clients reach the cell."""

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 10993
    dialect: Literal["1.2", "1.3", "1.4", "1.5"] = "1.5"
    idle_timeout_s: Positive = 600.0
    max_line_bytes: Annotated[int, Field(ge=64)] = 4096
    max_connections: Annotated[int, Field(ge=1)] = 16


class TwinProfile(Table):
    """How imperfect the twin is."""

    placement_scatter_mm: float = 0.3
    placement_scatter_deg: float = 0.5
    cameras: dict[str, TwinCameraProfile]


ArmProfile = Annotated[MelfaProfile | Ibm7545Profile | LynxProfile, Field(discriminator="model")]


class CellProfile(Table):
    """What every cell has: an arm, cameras, boxes in its way, and who watches over it."""

    name: str
    server: ServerProfile = ServerProfile()
    arm: ArmProfile
    cameras: dict[str, CameraProfile] = {}
    web_camera: WebCameraProfile | None = None
    boxes: tuple[BoxProfile, ...] = ()
    watchdog: WatchdogProfile = WatchdogProfile()
    reports: ReportsProfile = ReportsProfile()


class Profile(CellProfile):
    """A cell whose arm moves blocks between a store and a playground on a screen."""

    arm: MelfaProfile
    gripper: GripperProfile
    display: DisplayProfile
    outputs: OutputsProfile
    manipulation: ManipulationProfile = ManipulationProfile()
    lattice: LatticeProfile = LatticeProfile()
    store: StoreProfile
    heights: HeightsProfile
    blocks: dict[Kind, BlockProfile]
    twin: TwinProfile
