"""Cameras: who they are, how they are set, and where their twins stand."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Literal

from pydantic import Field, field_validator

from cell.devices.camera import CameraSettings
from cell.devices.camera_features import FeatureName
from cell.profile.table import NotNegative, Positive, Table, Text


class CameraProfile(Table):
    """One camera: who it is, how it is set, where its picture lies."""

    model: Text = "Flea2 FL2G-13S2C"
    """Maker's name of the camera."""
    number: Annotated[int, Field(ge=1)]
    """Number of the camera in the cell, as on its label; no two have the same."""
    guid: Text
    """The camera's own identity (GUID or serial number); never its place on the bus."""
    backend: Literal["dc1394", "v4l2", "file", "stream", "genicam"] = "dc1394"
    """How the camera is reached: FireWire, a Linux video device, a video file or a folder of
    pictures, a stream, or a GenICam producer. The twin's cameras need none."""
    source: str = ""
    """What the backend opens: a file or folder, a stream's URL, a GenTL producer (`.cti`).
    FireWire and video devices are found by `guid` alone and need none."""
    timeout_s: Positive = 2.0
    """How long to wait for a picture, in seconds."""
    raw: dict[FeatureName, Annotated[int, Field(ge=0)]] = Field(default_factory=dict)
    """Raw values by feature, for backends that do not reach absolute ones (FireWire and video
    devices through OpenCV); they go before `settings`."""
    settings: CameraSettings
    """Absolute values of the camera's features."""
    plane_map: (
        tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
        | None
    ) = None
    """Picture (1280 x 960) to robot x, y at the height of the block tops."""
    plane_map_guid: str = ""
    """GUID of the camera that `plane_map` was measured with; empty if it was not noted."""
    plane_map_date: date | None = None
    """Day on which `plane_map` was measured."""


class WebCameraProfile(Table):
    """A network camera that people look through (AXIS, VAPIX over HTTP)."""

    model: Text = "axis-211"
    """Maker's name of the camera."""
    url: Annotated[str, Field(pattern=r"^http://[^/\s]+/?$")]
    """Its address, such as `http://192.168.0.90`; without a name or a password."""
    user: str = ""
    """Name to log in with; empty where the camera asks for none."""
    password_variable: str = ""
    """Environment variable that holds the password; a profile never does."""
    timeout_s: Positive = 5.0
    """How long a request may take."""

    @field_validator("url", mode="before")
    @classmethod
    def _without_password(cls, url: object) -> object:
        """Refuse an address that a name or a password is written into; it is not repeated."""
        if isinstance(url, str) and "@" in url:
            raise ValueError(
                "holds a name or a password; write the name into `user`, and the name of an "
                "environment variable with the password into `password_variable`"
            )
        return url


class TwinCameraProfile(Table):
    """Where the twin's camera stands and what its lens does (1280 x 960 pixels)."""

    mount: Literal["world", "flange"] = "world"
    """What the camera is fixed to: the cell, or the arm's flange."""
    position_mm: tuple[float, float, float]
    """Where the lens is, in the frame of what it is fixed to."""
    rotation_deg: tuple[float, float, float]
    """A, B, C of mount-from-camera, R = Rz(C)·Ry(B)·Rx(A); the camera looks along its z."""
    focal_px: Positive
    """Focal length."""
    centre_px: tuple[float, float]
    """Where the lens's axis meets the picture."""
    k1: float = 0.0
    """First coefficient of radial distortion, without a unit."""
    k2: float = 0.0
    """Second coefficient of radial distortion, without a unit."""
    noise: NotNegative = 1.5
    """Standard deviation of the sensor noise in grey levels."""
    vignetting: Annotated[float, Field(ge=0, le=1)] = 0.05
    """Share of light lost in the picture's corners."""
