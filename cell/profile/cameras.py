"""Cameras: who they are, how they are set, and where their twins stand."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Literal

from pydantic import Field, field_validator

from cell.devices.camera import CameraSettings
from cell.devices.camera_features import FeatureName
from cell.geometry import (
    CameraView,
    LensModel,
    PlaneMap,
    PlaneView,
    Pose,
    TableView,
    Transform,
)
from cell.profile.table import NotNegative, Positive, Table, Text

_FULL_WIDTH_PX, _FULL_HEIGHT_PX = 1280, 960


class LensProfile(Table):
    """A camera's lens, in pixels of its largest picture (1280 x 960): Brown's model."""

    focal_px: tuple[Positive, Positive]
    """Focal length in columns and in rows."""
    centre_px: tuple[float, float]
    """Column and row where the lens's axis meets the picture."""
    k1: float = 0.0
    """First radial coefficient, without a unit."""
    k2: float = 0.0
    """Second radial coefficient, without a unit."""
    p1: float = 0.0
    """First tangential coefficient, without a unit."""
    p2: float = 0.0
    """Second tangential coefficient, without a unit."""
    k3: float = 0.0
    """Third radial coefficient, without a unit."""

    def model(self) -> LensModel:
        """Return the lens as a value."""
        return LensModel(
            width_px=_FULL_WIDTH_PX,
            height_px=_FULL_HEIGHT_PX,
            focal_u_px=self.focal_px[0],
            focal_v_px=self.focal_px[1],
            centre_u_px=self.centre_px[0],
            centre_v_px=self.centre_px[1],
            k1=self.k1,
            k2=self.k2,
            p1=self.p1,
            p2=self.p2,
            k3=self.k3,
        )


class PlaceProfile(Table):
    """Where a camera is: in the robot frame as its place, in the flange's frame as its mount."""

    position_mm: tuple[float, float, float]
    """Where the lens is."""
    rotation_deg: tuple[float, float, float]
    """A, B, C of frame-from-camera, R = Rz(C)·Ry(B)·Rx(A); the camera looks along its z."""

    def transform(self) -> Transform:
        """Return robot-from-camera of a place, flange-from-camera of a mount."""
        return Transform.from_pose(Pose(*self.position_mm, *self.rotation_deg))


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
    fixed_to: Literal["cell", "arm"] = "cell"
    """What it is fastened to: the cell, so that it stands still, or the arm, which moves it."""
    settings: CameraSettings
    """Absolute values of the camera's features, with the lights on."""
    settings_lights_off: CameraSettings | None = None
    """The same with the lights off, where the camera shall be set otherwise then; for backends
    that reach absolute values."""
    plane_map: (
        tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
        | None
    ) = None
    """Picture (1280 x 960) to robot x, y at the height of the block tops."""
    plane_map_guid: str = ""
    """GUID of the camera that `plane_map` was measured with; empty if it was not noted."""
    plane_map_date: date | None = None
    """Day on which `plane_map` was measured."""
    lens: LensProfile | None = None
    """Its lens, if it was measured; with `place` it takes the place of `plane_map`."""
    place: PlaceProfile | None = None
    """Where it stands, if that was measured; only for a camera that does not move."""
    mount: PlaceProfile | None = None
    """Where it hangs on the arm's flange, if that was measured; in the flange's frame, and only
    for a camera that moves with it."""

    @property
    def stands_still(self) -> bool:
        """Whether its picture keeps its place on the table while the arm moves."""
        return self.fixed_to == "cell" and self.mount is None

    def settings_for(self, *, are_lights_on: bool) -> CameraSettings:
        """Return the settings for a state of the cell's lights."""
        if are_lights_on or self.settings_lights_off is None:
            return self.settings
        return self.settings_lights_off

    def view(self, block_top_mm: float) -> TableView | None:
        """Return where its picture lies in the robot frame, None if that was not measured.

        Args:
            block_top_mm: Height of the block tops, at which a `plane_map` holds.
        """
        if self.lens is not None and self.place is not None:
            return CameraView(self.lens.model(), self.place.transform())
        if self.plane_map is not None:
            return PlaneView(PlaneMap(self.plane_map), block_top_mm)
        return None


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
