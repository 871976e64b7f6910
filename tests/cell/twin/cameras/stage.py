"""A scene that tests set, and cameras that look at it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cell.clock import SimulatedClock
from cell.devices.camera import MODES, CameraMode
from cell.geometry import Pose
from cell.kinematics import SixAxisArm
from cell.profile import Profile, load_profile
from cell.store import StoreSlot
from cell.twin.cameras import TwinCamera
from cell.twin.scene import Scene, SceneBlock

PROFILE: Profile = load_profile("mash")
ARM = SixAxisArm.from_profile(PROFILE.arm)
SURFACE_MM = PROFILE.heights.surface_mm
SLOTS = (
    StoreSlot(number=7, kind="cube", colour="red", x_mm=165, y_mm=150),
    StoreSlot(number=16, kind="cylinder", colour="green", x_mm=165, y_mm=350),
)
FULL = MODES[3]

Pixels = NDArray[np.uint8]


def block(
    kind: str,
    colour: str,
    x_mm: float,
    y_mm: float,
    *,
    z_mm: float = SURFACE_MM,
    yaw_deg: float = 0.0,
) -> SceneBlock:
    """Return a block at a place."""
    return SceneBlock(
        block=f"{colour} {kind}",
        kind=kind,
        colour=colour,
        x_mm=x_mm,
        y_mm=y_mm,
        z_mm=z_mm,
        yaw_deg=yaw_deg,
    )


def joints_at(x_mm: float, y_mm: float, z_mm: float) -> tuple[float, ...]:
    """Return joint angles with the tool point at a place, gripper down."""
    return ARM.solve(Pose(x_mm, y_mm, z_mm), PROFILE.arm.posture).values


@dataclass
class Stage:
    """What the cameras see; every change raises the revision."""

    revision: int = 0
    blocks: tuple[SceneBlock, ...] = ()
    joints_deg: tuple[float, ...] = PROFILE.arm.rest_deg
    opening_mm: float = 60.0
    picture: str | None = "black"
    are_lights_on: bool = True
    clock: SimulatedClock = field(default_factory=SimulatedClock)

    def __call__(self) -> Scene:
        """Return the scene as it is set."""
        return Scene(
            revision=self.revision,
            blocks=self.blocks,
            joints_deg=self.joints_deg,
            opening_mm=self.opening_mm,
            picture=self.picture,
            are_lights_on=self.are_lights_on,
        )

    def put(self, *blocks: SceneBlock) -> Stage:
        """Lay out these blocks and no others."""
        self.revision += 1
        self.blocks = blocks
        return self

    def show(self, picture: str | None, *, are_lights_on: bool = True) -> Stage:
        """Set screen and lights."""
        self.revision += 1
        self.picture, self.are_lights_on = picture, are_lights_on
        return self

    def move(self, joints_deg: Sequence[float], opening_mm: float = 60.0) -> Stage:
        """Set the arm and the fingers."""
        self.revision += 1
        self.joints_deg, self.opening_mm = tuple(joints_deg), opening_mm
        return self

    def camera(
        self, name: str, mode: CameraMode = FULL, *, seed: int = 1, profile: Profile = PROFILE
    ) -> TwinCamera:
        """Return an open camera that looks at this scene."""
        camera = TwinCamera(
            name, profile, scene=self, arm=ARM, clock=self.clock, seed=seed, slots=SLOTS
        )
        camera.open(mode)
        return camera


def quiet_profile() -> Profile:
    """Return the profile without sensor noise."""
    cameras = {
        name: placing.model_copy(update={"noise": 0.0})
        for name, placing in PROFILE.twin.cameras.items()
    }
    return PROFILE.model_copy(update={"twin": PROFILE.twin.model_copy(update={"cameras": cameras})})


QUIET = quiet_profile()


def mean_at(pixels: Pixels, u_px: float, v_px: float, half_px: int = 6) -> NDArray[np.float64]:
    """Return the mean colour around a pixel."""
    u, v = round(u_px), round(v_px)
    part = pixels[v - half_px : v + half_px + 1, u - half_px : u + half_px + 1]
    return np.asarray(part.reshape(-1, 3).mean(axis=0))
