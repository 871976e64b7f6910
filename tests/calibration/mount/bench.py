"""Views of a board by a camera on a flange, with the noise of pictures and arm."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from calibration.mount.fit import ArmNoise
from calibration.mount.model import MountState, MountView, Scene, transform, turn_vector, turned
from cell.geometry import Pose, Transform

Points = NDArray[np.float64]

NOISE = ArmNoise(position_mm=0.05, angle_deg=0.01)
SIGMA_PX = 0.15
_DOWN = np.diag([1.0, -1.0, -1.0])


def grid(columns: int = 15, rows: int = 8, square_mm: float = 55.35) -> Points:
    """Return the corners (n, 3) of the board on the screen."""
    y, x = np.mgrid[1 : rows + 1, 1 : columns + 1] * square_mm
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)


def truth(random: np.random.Generator) -> MountState:
    """Return a camera as the mash cell has it, drawn anew."""
    mount = Pose(*(np.array([105.0, 0.0, 40.0]) + random.uniform(-10, 10, 3)),
                 *(np.array([-22.0, 0.0, 90.0]) + random.uniform(-2, 2, 3)))  # fmt: skip
    return MountState(
        lens=np.array([900 * random.uniform(0.97, 1.03), *(random.uniform(-8, 8, 2) + (640, 480)),
                       random.uniform(-0.15, 0.0), random.uniform(-0.02, 0.02)]),
        flange_from_camera=Transform.from_pose(mount),
        targets=(transform(np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
                           @ turned(random.normal(0, 0.01, 3)),
                           np.array([245.7, -555.6, 38.5]) + random.uniform(-3, 3, 3)),),
    )  # fmt: skip


def robot_from_flange(
    state: MountState, random: np.random.Generator, *, tilt_deg: float = 25.0, group: int = 0
) -> Transform:
    """Return where the flange is when the camera looks at the board from about 350 mm."""
    target = state.targets[group]
    aim = target.apply(np.array([random.uniform(250, 630), random.uniform(150, 350), 0.0]))
    lean = random.uniform(-1, 1, 2) * math.radians(tilt_deg)
    turn = (
        _DOWN
        @ turned(np.array([*lean, 0.0]))
        @ turned(np.array([0.0, 0.0, random.uniform(-math.pi, math.pi)]))
    )
    distance = random.uniform(260, 420)
    camera = transform(turn, aim - turn[:, 2] * distance)
    return camera @ state.flange_from_camera.inverse()


def seen(
    state: MountState,
    flange: Transform,
    points: Points,
    random: np.random.Generator,
    label: str,
    *,
    noise: ArmNoise = NOISE,
    sigma_px: float = SIGMA_PX,
    group: int = 0,
) -> MountView:
    """Return what is seen from a place of the flange that the arm tells not quite right."""
    blank = MountView(label=label, robot_from_flange=flange, points_mm=points,
                      pixels=np.zeros((len(points), 2)), group=group)  # fmt: skip
    scene = Scene([blank])
    pixels = -scene.residuals(state).reshape(-1, 2)
    keep = scene.inside(state, 15.0)
    pixels = pixels[keep] + random.normal(0, sigma_px, (int(keep.sum()), 2))
    told = flange @ transform(
        turned(random.normal(0, math.radians(noise.angle_deg), 3)),
        random.normal(0, noise.position_mm, 3),
    )
    return MountView(label=label, robot_from_flange=told, points_mm=points[keep], pixels=pixels)


def views_of(
    state: MountState,
    random: np.random.Generator,
    count: int = 12,
    *,
    noise: ArmNoise = NOISE,
    tilt_deg: float = 25.0,
    points: Points | None = None,
    sigma_px: float = SIGMA_PX,
) -> list[MountView]:
    """Return views from random places."""
    board = grid() if points is None else points
    return [
        seen(state, robot_from_flange(state, random, tilt_deg=tilt_deg), board, random,
             f"pose {i + 1}", noise=noise, sigma_px=sigma_px)
        for i in range(count)
    ]  # fmt: skip


def offset(fitted: MountState, true: MountState) -> Points:
    """Return the change that leads from fitted lens and mount to the true ones, (11,)."""
    turn = fitted.flange_from_camera.rotation.T @ true.flange_from_camera.rotation
    shift = true.flange_from_camera.translation_mm - fitted.flange_from_camera.translation_mm
    return np.concatenate([true.lens - fitted.lens, turn_vector(turn), shift])
