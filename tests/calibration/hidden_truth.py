"""Cells that are not what their profile says: what calibrations have to find out.

A hidden truth goes into `assemble_twin(profile, plan, truth=hidden(profile, seed))`. The
program knows the profile alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cell.geometry import CameraView, LensModel, Pose, Transform
from cell.profile import DisplayProfile, LensProfile, Profile, TwinCameraProfile, TwinProfile

PLAYGROUND_CORNERS_MM = ((300.0, -350.0), (700.0, -350.0), (700.0, 300.0), (300.0, 300.0))
"""Between them accuracy is stated."""

_MOST_TRIES = 5000
_ROWS_PX = (60.0, 870.0)
_COLUMNS_PX = (0.0, 1279.0)
_SCREEN_MARGIN_MM = 1.5

Points = NDArray[np.float64]


def hidden(profile: Profile, seed: int) -> Profile:
    """Return how a cell of this profile might really be.

    The top camera stands up to 20 mm and 1.5 deg elsewhere, its focal length is up to 3 % and
    its centre up to 15 px off, k1 is -0.12 to 0.02 and k2 -0.03 to 0.03. The lamps give 70 to
    130 % of their light. The screen's corner is up to 5 mm and its picture up to 0.5 deg off.
    Whoever put the camera up saw to it that blocks anywhere on the playground are seen whole,
    with lit screen around them: draws where they are not are drawn again.
    """
    random = np.random.default_rng([seed, 0x7247])
    for _ in range(_MOST_TRIES):
        camera = _camera(profile.twin.cameras["top"], random)
        display = _display(profile.display, random)
        if _sees_the_playground(profile, camera, display):
            break
    else:
        raise AssertionError(f"seed {seed}: no such cell has its playground in view")
    light = profile.twin.light.model_copy(update={"level": float(random.uniform(0.7, 1.3))})
    cameras = {**profile.twin.cameras, "top": camera}
    twin: TwinProfile = profile.twin.model_copy(update={"cameras": cameras, "light": light})
    return profile.model_copy(update={"twin": twin, "display": display})


def true_view(truth: Profile, camera: str = "top") -> CameraView:
    """Return where a fixed camera of the twin really stands and what its lens does."""
    return view_of(truth.twin.cameras[camera])


def view_of(camera: TwinCameraProfile) -> CameraView:
    """Return the view of a camera of the twin that is fixed in the cell."""
    return CameraView(
        LensModel(
            width_px=1280,
            height_px=960,
            focal_u_px=camera.focal_px,
            focal_v_px=camera.focal_px,
            centre_u_px=camera.centre_px[0],
            centre_v_px=camera.centre_px[1],
            k1=camera.k1,
            k2=camera.k2,
        ),
        Transform.from_pose(Pose(*camera.position_mm, *camera.rotation_deg)),
    )


def with_true_lens(profile: Profile, truth: Profile) -> Profile:
    """Return a profile that knows the top camera's lens as it really is, but not its place."""
    own = truth.twin.cameras["top"]
    lens = LensProfile(
        focal_px=(own.focal_px, own.focal_px), centre_px=own.centre_px, k1=own.k1, k2=own.k2
    )
    top = profile.cameras["top"].model_copy(update={"lens": lens})
    return profile.model_copy(update={"cameras": {**profile.cameras, "top": top}})


def block_top_mm(profile: Profile) -> float:
    """Return the height of the block tops."""
    return profile.heights.surface_mm + max(b.height_mm for b in profile.blocks.values())


def playground_grid(across: int = 5, along: int = 5) -> Points:
    """Return points all over the playground with its corners, shape (n, 2), robot mm."""
    x, y = np.meshgrid(np.linspace(300.0, 700.0, across), np.linspace(-350.0, 300.0, along))
    return np.stack([x.ravel(), y.ravel()], axis=1)


def _camera(camera: TwinCameraProfile, random: np.random.Generator) -> TwinCameraProfile:
    return camera.model_copy(
        update={
            "position_mm": _moved(camera.position_mm, 20.0, random),
            "rotation_deg": _moved(camera.rotation_deg, 1.5, random),
            "focal_px": float(camera.focal_px * random.uniform(0.97, 1.03)),
            "centre_px": _moved(camera.centre_px, 15.0, random),
            "k1": float(random.uniform(-0.12, 0.02)),
            "k2": float(random.uniform(-0.03, 0.03)),
        }
    )


def _display(display: DisplayProfile, random: np.random.Generator) -> DisplayProfile:
    corner = _moved((display.corner_x_mm, display.corner_y_mm), 5.0, random)
    return display.model_copy(
        update={
            "corner_x_mm": corner[0],
            "corner_y_mm": corner[1],
            "angle_deg": float(display.angle_deg + random.uniform(-0.5, 0.5)),
        }
    )


def _moved(
    values: tuple[float, ...], most: float, random: np.random.Generator
) -> tuple[float, ...]:
    return tuple(float(value + random.uniform(-most, most)) for value in values)


def _sees_the_playground(
    profile: Profile, camera: TwinCameraProfile, display: DisplayProfile
) -> bool:
    """Tell whether blocks on the playground's corners are seen whole, on lit screen."""
    view = view_of(camera)
    top, surface = block_top_mm(profile), profile.heights.surface_mm
    turn = np.radians(np.arange(0.0, 360.0, 15.0))
    ring = 16.5 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    edge = (np.array(PLAYGROUND_CORNERS_MM)[:, None, :] + ring).reshape(-1, 2)
    seen = view.to_picture(edge, top)
    if not (_within(seen[:, 0], _COLUMNS_PX) and _within(seen[:, 1], _ROWS_PX)):
        return False
    hidden_mm = view.to_robot(seen, surface) - (display.corner_x_mm, display.corner_y_mm)
    angle = math.radians(display.angle_deg)
    right = hidden_mm @ (math.cos(angle), math.sin(angle))
    down = hidden_mm @ (math.sin(angle), -math.cos(angle))
    margin = _SCREEN_MARGIN_MM
    wide, high = display.width_px * display.pixel_mm, display.height_px * display.pixel_mm
    return _within(right, (margin, wide - margin)) and _within(down, (margin, high - margin))


def _within(values: Points, bounds: tuple[float, float]) -> bool:
    return bool(values.min() >= bounds[0] and values.max() <= bounds[1])
