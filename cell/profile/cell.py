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
from cell.profile.recognition import RecognitionProfile
from cell.profile.table import Kind, Name, NotNegative, Positive, Table, Text
from cell.profile.watching import ReportsProfile, WatchdogProfile


class ServerProfile(Table):
    """How experiment clients reach the cell."""

    host: Text = "127.0.0.1"
    """Address to listen on; anything but 127.0.0.1 lets other machines in."""
    port: Annotated[int, Field(ge=0, le=65535)] = 10993
    """TCP port to listen on, 0 for a free one."""
    dialect: Literal["1.2", "1.3", "1.4", "1.5"] = "1.5"
    """Version of MAS that is spoken."""
    idle_timeout_s: Positive = 600.0
    """Silence after which a client is disconnected."""
    max_line_bytes: Annotated[int, Field(ge=64)] = 4096
    """Longest line that a client may send."""
    max_connections: Annotated[int, Field(ge=1)] = 16
    """How many clients may be connected at once."""


class TwinLightProfile(Table):
    """How the twin's lamps differ from the light that the cameras' settings were made for."""

    level: NotNegative = 1.0
    """Light of the lamps; 1 is nominal."""
    red: Positive = 1.0
    """Red of the lamps' light against its green."""
    blue: Positive = 1.0
    """Blue of the lamps' light against its green."""
    flicker: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Share of the lamps' light that swings with the mains, twice a period."""
    mains_hz: Positive = 50.0
    """Frequency of the mains."""


class TwinProfile(Table):
    """How imperfect the twin is."""

    placement_scatter_mm: NotNegative = 0.3
    """Standard deviation of where a released block comes to lie."""
    placement_scatter_deg: NotNegative = 0.5
    """Standard deviation of how a released block is turned."""
    light: TwinLightProfile = TwinLightProfile()
    """The lamps."""
    cameras: dict[str, TwinCameraProfile]
    """A twin for each camera, by the same names."""


ArmProfile = Annotated[MelfaProfile | Ibm7545Profile | LynxProfile, Field(discriminator="model")]


class CellProfile(Table):
    """What every cell has: an arm, cameras, boxes in its way, and who watches over it."""

    name: Name
    """Name of the cell; its state is kept in a folder of this name."""
    server: ServerProfile = ServerProfile()
    """How experiment clients reach the cell."""
    arm: ArmProfile
    """The arm; `model` says which, and with it which further fields there are."""
    cameras: dict[str, CameraProfile] = {}
    """The cameras, each by a name of its own."""
    web_camera: WebCameraProfile | None = None
    """A network camera that people look through."""
    boxes: tuple[BoxProfile, ...] = ()
    """Boxes that no part of the arm may enter."""
    demands: dict[str, Positive] = {}
    """Greatest error in mm of each kind of calibration, such as `homography`, below which no
    task begins; a kind that is not calibrated at all does not meet it."""
    watchdog: WatchdogProfile = WatchdogProfile()
    """The test of every component when no session runs."""
    reports: ReportsProfile = ReportsProfile()
    """Where failures are reported to."""


class Profile(CellProfile):
    """A cell whose arm moves blocks between a store and a playground on a screen."""

    arm: MelfaProfile
    """The arm over the playground."""
    gripper: GripperProfile
    """The gripper that moves the blocks."""
    display: DisplayProfile
    """The television under the playground."""
    outputs: OutputsProfile
    """Which output of the arm controller switches what."""
    manipulation: ManipulationProfile = ManipulationProfile()
    """Whether the arm moves blocks."""
    lattice: LatticeProfile = LatticeProfile()
    """Where the lattice lies in the robot frame."""
    store: StoreProfile
    """Where the store plan lies."""
    heights: HeightsProfile
    """Heights of the tool point."""
    blocks: dict[Kind, BlockProfile]
    """Size of each kind of block."""
    recognition: RecognitionProfile | None = None
    """What was learned of the blocks' looks, if it was."""
    twin: TwinProfile
    """How imperfect the twin is, and where its cameras stand."""

    @property
    def block_top_mm(self) -> float:
        """Height of the upper faces of the highest blocks above the robot's base plane."""
        return self.heights.surface_mm + max(b.height_mm for b in self.blocks.values())
