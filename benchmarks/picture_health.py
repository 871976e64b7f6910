"""What it costs to judge a picture, and to watch frames for repetitions, on one core."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2

from benchmarks.measure import Result, median_s
from cell.clock import SimulatedClock
from cell.devices.camera import MODES, Frame
from cell.kinematics import SixAxisArm
from cell.profile import load_profile
from cell.twin.cameras import TwinCamera
from cell.twin.scene import Scene
from cell.vision.frame_watch import FrameWatch
from cell.vision.picture_health import judge_picture, make_reference

_FRAME_PERIOD_MS = 1000.0 / 7.5


def run() -> list[Result]:
    """Measure with references of three cameras, as the cell's own check does."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        frames = {name: _frames(name) for name in ("top", "oblique", "gripper")}
        references = {
            name: make_reference(name, [frame.pixels for frame in pair])
            for name, pair in frames.items()
        }
        pixels = frames["top"][0].pixels
        judge_ms = 1e3 * median_s(lambda: judge_picture("top", pixels, references), repeat=15)
        light_ms = 1e3 * median_s(lambda: judge_picture("top", pixels), repeat=15)
        watch_ms = _watch_ms(frames["top"][0])
    finally:
        cv2.setNumThreads(threads)
    return [
        _result("judge a picture against three references", judge_ms),
        _result("judge a picture's light alone", light_ms),
        _result("watch one frame for repetition, worst case", watch_ms),
    ]


def _result(name: str, value_ms: float) -> Result:
    return Result(
        name=name, value=value_ms, unit="ms", peer="a frame period", peer_value=_FRAME_PERIOD_MS
    )


def _frames(name: str) -> list[Frame]:
    """Return frames of one camera with the screen black and white, the arm at rest."""
    profile = load_profile("mash")
    arm = SixAxisArm.from_profile(profile.arm)
    frames = []
    for revision, picture in enumerate(("black", "white")):
        scene = Scene(
            revision=revision,
            blocks=(),
            joints_deg=profile.arm.rest_deg,
            opening_mm=60.0,
            picture=picture,
            are_lights_on=True,
        )
        camera = TwinCamera(
            name, profile, scene=_seen(scene), arm=arm, clock=SimulatedClock(), seed=1
        )
        camera.open(MODES[3])
        frames.append(camera.grab())
    return frames


def _seen(scene: Scene) -> Callable[[], Scene]:
    return lambda: scene


def _watch_ms(frame: Frame) -> float:
    """Return the time to find two equal pictures equal: every pixel is compared."""
    again = replace(frame, number=2, time_s=1.0, pixels=frame.pixels.copy())

    def job() -> None:
        watch = FrameWatch()
        watch.see(frame)
        watch.see(again)

    return 1e3 * median_s(job, repeat=15)
