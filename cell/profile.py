"""The profile of a cell: every figure that differs from one cell to the next.

A profile is a TOML file; `cell/profiles/` holds the shipped ones. The models
below are the file's fields, one class a table, all frozen.
"""

from __future__ import annotations

import tomllib
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cell.devices.camera import CameraSettings
from cell.errors import ProfileError

Positive = Annotated[float, Field(gt=0)]
Kind = str
Colour = str


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ServerProfile(_Table):
    """How experiment clients reach the cell."""

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 10993
    dialect: Literal["1.2", "1.3", "1.4", "1.5"] = "1.5"
    idle_timeout_s: Positive = 600.0
    max_line_bytes: Annotated[int, Field(ge=64)] = 4096
    max_connections: Annotated[int, Field(ge=1)] = 16


class SerialProfile(_Table):
    """A serial port and its parameters."""

    port: str
    baud: int
    data_bits: Literal[7, 8] = 8
    parity: Literal["none", "even", "odd"]
    stop_bits: Literal[1, 2]


class ArmProfile(_Table):
    """The arm, its controller and its limits."""

    model: Literal["melfa-rv6sdl"]
    serial: SerialProfile
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


class GripperProfile(_Table):
    """The gripper and its fingers."""

    model: Literal["schunk-pg70"]
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


class DisplayProfile(_Table):
    """The television under the playground."""

    model: Literal["sharp-lc40le705"]
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


class OutputsProfile(_Table):
    """Which output of the arm controller switches what."""

    lights: int
    gripper_power: int
    magnet: int


class CameraProfile(_Table):
    """One camera: who it is, how it is set, where its picture lies."""

    model: str = "Flea2 FL2G-13S2C"
    number: int
    guid: str
    settings: CameraSettings
    plane_map: (
        tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
        | None
    ) = None
    """Picture (1280 x 960) to robot x, y at the height of the block tops."""


class LatticeProfile(_Table):
    """Where the lattice lies in the robot frame."""

    step_mm: Positive = 20.0
    angle_deg: float = 90.0
    origin_mm: tuple[float, float] = (710.0, -265.0)


class StoreProfile(_Table):
    """Where the store plan lies: plan x along `angle_deg`, plan y to its right."""

    corner_mm: tuple[float, float]
    angle_deg: float = 0.0


class HeightsProfile(_Table):
    """Heights of the tool point above the robot's base plane."""

    surface_mm: float
    """Height of the glass and of the store's sheet."""
    service_mm: float = 200.0
    laying_mm: float = 55.0


class BlockProfile(_Table):
    """Size of one kind of block; the fingers close across `width_mm`."""

    shape: Literal["box", "cylinder"]
    length_mm: Positive
    width_mm: Positive
    height_mm: Positive
    arch_radius_mm: Annotated[float, Field(ge=0)] = 0.0
    """Radius of a round opening along the width, at the middle of the bottom; 0 for none."""


class BoxProfile(_Table):
    """A box that no part of the arm may enter, in the robot frame."""

    name: str
    min_mm: tuple[float, float, float]
    max_mm: tuple[float, float, float]


class TwinCameraProfile(_Table):
    """Where the twin's camera stands and what its lens does (1280 x 960 pixels)."""

    mount: Literal["world", "flange"] = "world"
    position_mm: tuple[float, float, float]
    rotation_deg: tuple[float, float, float]
    """A, B, C of mount-from-camera, R = Rz(C)·Ry(B)·Rx(A); the camera looks along its z."""
    focal_px: Positive
    centre_px: tuple[float, float]
    k1: float = 0.0
    k2: float = 0.0
    noise: float = 1.5
    """Standard deviation of the sensor noise in grey levels."""
    vignetting: float = 0.05
    """Share of light lost in the picture's corners."""


class TwinProfile(_Table):
    """How imperfect the twin is."""

    placement_scatter_mm: float = 0.3
    placement_scatter_deg: float = 0.5
    cameras: dict[str, TwinCameraProfile]


class Profile(_Table):
    """Everything that is particular to one cell."""

    name: str
    server: ServerProfile = ServerProfile()
    arm: ArmProfile
    gripper: GripperProfile
    display: DisplayProfile
    outputs: OutputsProfile
    cameras: dict[str, CameraProfile]
    lattice: LatticeProfile = LatticeProfile()
    store: StoreProfile
    heights: HeightsProfile
    blocks: dict[Kind, BlockProfile]
    boxes: tuple[BoxProfile, ...] = ()
    twin: TwinProfile


def load_profile(name_or_path: str) -> Profile:
    """Load a shipped profile by name or any profile by path.

    Raises:
        ProfileError: There is no such profile, it is not TOML, or a field is wrong.
    """
    return parse_profile(profile_text(name_or_path), name_or_path)


def profile_text(name_or_path: str) -> str:
    """Return the TOML text of a profile.

    Raises:
        ProfileError: There is no such profile, or it cannot be read.
    """
    path = Path(name_or_path)
    try:
        if path.suffix == ".toml":
            return path.read_text("utf-8")
        shipped = resources.files("cell") / "profiles" / f"{name_or_path}.toml"
        if shipped.is_file():
            return shipped.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ProfileError(f"the profile {name_or_path} cannot be read: {error}") from error
    raise ProfileError(
        f"there is no profile {name_or_path!r}; shipped are {', '.join(shipped_profiles())}, "
        "and a path must end in .toml"
    )


def shipped_profiles() -> list[str]:
    """Return the names of the shipped profiles."""
    folder = resources.files("cell") / "profiles"
    return sorted(
        f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")
    )


def parse_profile(text: str, source: str) -> Profile:
    """Read a profile from TOML text.

    Args:
        text: The TOML text.
        source: Where it comes from, for messages.

    Raises:
        ProfileError: The text is not TOML, or a field is wrong; every wrong field is named.
    """
    try:
        return Profile.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ProfileError(f"{source} is not valid TOML: {error}") from error
    except ValidationError as error:
        problems = "; ".join(
            f"{'.'.join(str(part) for part in e['loc'])}: {e['msg']}" for e in error.errors()
        )
        raise ProfileError(f"{source}: {problems}") from error
