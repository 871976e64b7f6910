"""Cameras over a screen of dots: blocks anywhere, bumps of camera or screen, many at a time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from calibration.drift.check import DotReference, measured_reference
from calibration.drift.dots import dots
from calibration.playground import playground_grid
from cell.geometry import CameraView, Transform
from cell.profile import Profile, TwinCameraProfile
from cell.twin.scene import SceneBlock
from tests.calibration.hidden_truth import view_of
from tests.calibration.screen.cell_on_stage import PANEL, Watched, true_places_mm
from tests.cell.twin.cameras.stage import SURFACE_MM, block
from tests.cell.twin.cameras.test_patterns import PatternStage

TOP_MM = SURFACE_MM + 33.0
PLAYGROUND_MM = playground_grid()
COLOURS = ("red", "green", "blue", "yellow", "natural")

Points = NDArray[np.float64]


def litter(random: np.random.Generator, share: float, profile: Profile) -> tuple[SceneBlock, ...]:
    """Return blocks that cover about a share of the screen, none over another."""
    display = profile.display
    screen_mm2 = display.width_px * display.height_px * display.pixel_mm**2
    covered, laid, places = 0.0, [], np.empty((0, 3))
    for _ in range(4000):
        if covered >= share * screen_mm2:
            break
        kind = str(random.choice(["cube", "cylinder", "bridge", "bridge"]))
        size = profile.blocks[kind]
        radius = 0.5 * math.hypot(size.length_mm, size.width_mm)
        at = true_places_mm(profile, random.uniform((0, 0), (1920, 1080))[None])[0]
        yaw = float(random.uniform(0, 180))
        # Bridges lie side by side more closely than their corners would allow.
        near = np.hypot(*(places[:, :2] - at).T) if len(places) else np.empty(0)
        if (near < 0.6 * (places[:, 2] + radius)).any():
            continue
        places = np.vstack([places, [*at, radius]])
        laid.append(block(kind, str(random.choice(COLOURS)), *at.tolist(), yaw_deg=yaw))
        covered += size.length_mm * size.width_mm
    return tuple(laid)


def moved_camera(
    camera: TwinCameraProfile, shift_mm: Points, turn_deg: Points
) -> TwinCameraProfile:
    """Return a camera moved in its own frame."""
    x, y, z = np.radians(turn_deg)
    matrix = np.eye(4)
    left, _, right = np.linalg.svd(np.array([[1, -z, y], [z, 1, -x], [-y, x, 1]]))
    matrix[:3, :3], matrix[:3, 3] = left @ right, shift_mm
    pose = (view_of(camera).robot_from_camera @ Transform(matrix)).to_pose()
    return camera.model_copy(
        update={
            "position_mm": (pose.x_mm, pose.y_mm, pose.z_mm),
            "rotation_deg": (pose.a_deg, pose.b_deg, pose.c_deg),
        }
    )


def with_camera(profile: Profile, name: str, camera: TwinCameraProfile) -> Profile:
    """Return a cell with another camera."""
    cameras = {**profile.twin.cameras, name: camera}
    return profile.model_copy(update={"twin": profile.twin.model_copy(update={"cameras": cameras})})


def look(name: str, profile: Profile, blocks: tuple[SceneBlock, ...], *, seed: int) -> Points:
    """Return the two pictures of a check, (2, 960, 1280, 3)."""
    stage = PatternStage()
    stage.put(*blocks)
    watched = Watched(stage, stage.camera(name, profile=profile, seed=seed))
    return np.stack([watched.shot(dots(PANEL)), watched.shot(PANEL.field(0))])


def reference(name: str, profile: Profile) -> DotReference:
    """Return what a camera sees of the dots with nothing on the screen."""
    lit, dark = look(name, profile, (), seed=1)
    return measured_reference(name, view_of(profile.twin.cameras[name]), lit, dark, profile)


def bump_of(
    camera: TwinCameraProfile, random: np.random.Generator, *, is_turn: bool
) -> TwinCameraProfile:
    """Return a camera turned by 0.1 deg about any axis, or moved so that the playground moves.

    The second is shifted and turned by chance, and then by as much of it as puts the
    playground 1 mm off.
    """
    if is_turn:
        return moved_camera(camera, np.zeros(3), 0.1 * _direction(random))
    shift, turn = random.uniform(0, 1) * _direction(random), 0.03 * _direction(random)
    was, share = view_of(camera), 1.0
    for _ in range(5):
        now = view_of(moved_camera(camera, share * shift, share * turn))
        share /= apparent_mm(was, now)
    return moved_camera(camera, share * shift, share * turn)


def apparent_mm(was: CameraView, now: CameraView) -> float:
    """Return by how much (root mean square) what a camera tells of the playground is off."""
    seen = now.to_picture(PLAYGROUND_MM, TOP_MM)
    return float(
        np.sqrt(np.mean(np.sum((was.to_robot(seen, TOP_MM) - PLAYGROUND_MM) ** 2, axis=1)))
    )


def _direction(random: np.random.Generator) -> Points:
    way = random.standard_normal(3)
    return np.asarray(way / np.linalg.norm(way))
