"""Cameras: who they are, how they are set, and where their twins stand."""

from __future__ import annotations

from datetime import date
from typing import Literal

from cell.devices.camera import CameraSettings
from cell.profile.table import Positive, Table


class CameraProfile(Table):
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
    plane_map_guid: str = ""
    """GUID of the camera that `plane_map` was measured with; empty if it was not noted."""
    plane_map_date: date | None = None
    """Day on which `plane_map` was measured."""


class WebCameraProfile(Table):
    """A network camera that people look through (AXIS, VAPIX over HTTP)."""

    model: str = "axis-211"
    url: str
    """Its address, such as `http://192.168.0.90`."""
    user: str = ""
    password_variable: str = ""
    """Environment variable that holds the password; a profile never does."""
    timeout_s: Positive = 5.0


class TwinCameraProfile(Table):
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
