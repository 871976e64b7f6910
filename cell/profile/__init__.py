"""The profile of a cell: every figure that differs from one cell to the next.

A profile is a TOML file; `cell/profiles/` holds the shipped ones. The models here are the
file's fields, one class a table, all frozen.
"""

from __future__ import annotations

from cell.profile.arms import MelfaProfile
from cell.profile.cameras import (
    CameraProfile,
    LensProfile,
    PlaceProfile,
    TwinCameraProfile,
    WebCameraProfile,
)
from cell.profile.cell import (
    ArmProfile,
    CellProfile,
    Profile,
    ServerProfile,
    TwinLightProfile,
    TwinProfile,
)
from cell.profile.devices import DisplayProfile, GripperProfile, OutputsProfile
from cell.profile.findings import Finding, InvalidProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.profile.loading import (
    load_cell_profile,
    load_profile,
    parse_cell_profile,
    parse_profile,
)
from cell.profile.lynx import LynxProfile
from cell.profile.playground import (
    BlockProfile,
    BoxProfile,
    HeightsProfile,
    LatticeProfile,
    ManipulationProfile,
    StoreProfile,
)
from cell.profile.recognition import (
    LearnedColourProfile,
    LearnedKindProfile,
    RecognitionProfile,
)
from cell.profile.sources import profile_text, shipped_profiles, user_profiles
from cell.profile.table import Colour, Kind, Positive
from cell.profile.watching import BugzillaProfile, ReportsProfile, WatchdogProfile, WebhookProfile
from cell.profile.wires import SerialProfile, TcpProfile

__all__ = [
    "ArmProfile",
    "BlockProfile",
    "BoxProfile",
    "BugzillaProfile",
    "CameraProfile",
    "LearnedColourProfile",
    "LearnedKindProfile",
    "LensProfile",
    "PlaceProfile",
    "TwinLightProfile",
    "CellProfile",
    "Colour",
    "DisplayProfile",
    "Finding",
    "GripperProfile",
    "HeightsProfile",
    "Ibm7545Profile",
    "InvalidProfile",
    "Kind",
    "LatticeProfile",
    "LynxProfile",
    "ManipulationProfile",
    "MelfaProfile",
    "OutputsProfile",
    "Positive",
    "Profile",
    "RecognitionProfile",
    "ReportsProfile",
    "SerialProfile",
    "ServerProfile",
    "StoreProfile",
    "TcpProfile",
    "TwinCameraProfile",
    "TwinProfile",
    "WatchdogProfile",
    "WebCameraProfile",
    "WebhookProfile",
    "load_cell_profile",
    "load_profile",
    "parse_cell_profile",
    "parse_profile",
    "profile_text",
    "shipped_profiles",
    "user_profiles",
]
