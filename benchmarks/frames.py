"""Fresh full-size frames of the twin's cameras, and the recognition, on one core.

Peer: the least that a picture with a lens can cost here, one copy and one remap of
a 1280 x 960 picture through a fixed-point map.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import cv2
import numpy as np

from benchmarks.measure import Result, median_s
from cell.clock import SimulatedClock
from cell.devices.camera import MODES
from cell.geometry import Pose
from cell.kinematics import SixAxisArm
from cell.profile import load_profile
from cell.twin.cameras import TwinCamera
from cell.twin.scene import Scene, SceneBlock
from cell.vision import find_blocks

_TARGET_MS = 10.0
_FRAMES = 60


def run() -> list[Result]:
    """Measure each camera with the arm moving over the laid-out playground."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        peer_ms = _remap_ms()
        results = [
            Result(
                name=f"fresh 1280x960 frame, {name} camera",
                value=_frame_ms(name),
                unit="ms",
                peer="copy and remap alone",
                peer_value=peer_ms,
                target=_TARGET_MS,
            )
            for name in ("top", "oblique", "gripper")
        ]
        return [*results, _recognition(peer_ms)]
    finally:
        cv2.setNumThreads(threads)


def _remap_ms() -> float:
    picture = np.random.default_rng(0).integers(0, 256, (960, 1280, 3), np.uint8)
    u, v = np.meshgrid(np.arange(1280, dtype=np.float32), np.arange(960, dtype=np.float32))
    bent = 1.0 + 0.02 * (((u - 640) / 640) ** 2 + ((v - 480) / 640) ** 2)
    first, second = cv2.convertMaps((u - 640) * bent + 640, (v - 480) * bent + 480, cv2.CV_16SC2)
    copy, out = np.empty_like(picture), np.empty_like(picture)

    def job() -> None:
        np.copyto(copy, picture)
        cv2.remap(copy, first, second, cv2.INTER_LINEAR, dst=out)

    return 1e3 * median_s(job, repeat=_FRAMES)


def _blocks() -> tuple[SceneBlock, ...]:
    """Return eight blocks on the playground and ten beside the arm."""
    colours = ("red", "green", "blue", "yellow", "natural")
    kinds = ("cube", "cylinder", "cube", "bridge")
    places = [(510 + 70 * (i % 3), -240 + 65 * (i // 3)) for i in range(8)]
    places += [(-200 + 105 * (i % 5), 450 + 110 * (i // 5)) for i in range(10)]
    return tuple(
        SceneBlock(
            block=f"slot {i}",
            kind=kinds[i % 4],
            colour=colours[i % 5],
            x_mm=x_mm,
            y_mm=y_mm,
            z_mm=38.5,
            yaw_deg=0.0,
        )
        for i, (x_mm, y_mm) in enumerate(places)
    )


def _camera(name: str, scene: Callable[[], Scene]) -> TwinCamera:
    profile = load_profile("mash")
    arm = SixAxisArm.from_profile(profile.arm)
    camera = TwinCamera(name, profile, scene=scene, arm=arm, clock=SimulatedClock(), seed=1)
    camera.open(MODES[3])
    return camera


def _frame_ms(name: str) -> float:
    profile = load_profile("mash")
    arm = SixAxisArm.from_profile(profile.arm)
    blocks = _blocks()
    poses = [Pose(500.0 + 9 * (i % 20), -240.0 + 2.5 * i, 136.5) for i in range(_FRAMES + 1)]
    scenes = itertools.cycle(
        Scene(
            revision=i,
            blocks=blocks,
            joints_deg=arm.solve(pose, profile.arm.posture).values,
            opening_mm=60.0,
            picture="forest",
            are_lights_on=True,
        )
        for i, pose in enumerate(poses)
    )
    return 1e3 * median_s(_camera(name, lambda: next(scenes)).grab, repeat=_FRAMES)


def _recognition(peer_ms: float) -> Result:
    rest_deg = load_profile("mash").arm.rest_deg
    scenes = [
        Scene(
            revision=i,
            blocks=_blocks(),
            joints_deg=rest_deg,
            opening_mm=60.0,
            picture=picture,
            are_lights_on=True,
        )
        for i, picture in enumerate(("white", "black"))
    ]
    shown = iter(scenes)
    camera = _camera("top", lambda: next(shown))
    white, black = camera.grab().pixels, camera.grab().pixels
    return Result(
        name="recognise the blocks in two pictures",
        value=1e3 * median_s(lambda: find_blocks(white, black), repeat=20),
        unit="ms",
        peer="copy and remap alone",
        peer_value=peer_ms,
    )
