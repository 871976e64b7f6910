from __future__ import annotations

from dataclasses import replace

import numpy as np

from cell.devices.camera import Frame
from cell.twin.cameras import TwinCamera
from cell.vision.frame_watch import FrameWatch
from tests.cell.twin.cameras.stage import PROFILE, Stage


def frame(number: int, *, seed: int | None = None, time_s: float | None = None) -> Frame:
    generator = np.random.default_rng(number if seed is None else seed)
    return Frame(
        camera="top",
        number=number,
        time_s=number / 7.5 if time_s is None else time_s,
        pixels=generator.integers(0, 255, (48, 64, 3), dtype=np.uint8),
        settings=PROFILE.cameras["top"].settings,
    )


def fresh(stage: Stage, camera: TwinCamera) -> Frame:
    stage.clock.sleep(1 / 7.5)
    return camera.grab_fresh()


def test_different_frames_are_no_finding() -> None:
    watch = FrameWatch()
    assert [watch.see(frame(n)) for n in range(1, 20)] == [()] * 19


def test_same_frame_again_is_a_duplicate() -> None:
    watch = FrameWatch()
    watch.see(frame(1))
    (finding,) = watch.see(frame(1))
    assert (finding.fault, finding.number, finding.repeats) == ("duplicate", 1, 1)


def test_old_time_under_a_new_number_is_a_duplicate() -> None:
    watch = FrameWatch()
    watch.see(frame(1))
    (finding,) = watch.see(frame(2, time_s=1 / 7.5))
    assert finding.fault == "duplicate"
    assert "0.133 s" in finding.text


def test_same_pixels_under_new_numbers_are_a_frozen_camera_and_are_counted() -> None:
    watch = FrameWatch()
    watch.see(frame(1, seed=5))
    repeats = [watch.see(frame(n, seed=5))[0].repeats for n in (2, 3, 4)]
    assert repeats == [1, 2, 3]
    assert watch.see(frame(5, seed=6)) == ()


def test_more_repeats_may_be_allowed() -> None:
    watch = FrameWatch(least_repeats=3)
    found = [bool(watch.see(frame(n, seed=5))) for n in range(1, 6)]
    assert found == [False, False, False, True, True]


def test_reset_forgets_the_frames_before() -> None:
    watch = FrameWatch()
    watch.see(frame(7))
    watch.reset()
    assert watch.see(frame(1)) == ()


def test_one_different_pixel_is_enough_to_be_another_picture() -> None:
    watch = FrameWatch()
    first = frame(1)
    pixels = first.pixels.copy()
    pixels[10, 10, 1] ^= 1
    watch.see(first)
    assert watch.see(replace(first, number=2, time_s=9.0, pixels=pixels)) == ()


def test_twin_s_frozen_camera_is_noticed_at_the_next_frame_and_healthy_ones_never() -> None:
    stage = Stage()
    camera, watch = stage.camera("top"), FrameWatch()
    assert not any(watch.see(fresh(stage, camera)) for _ in range(5))
    camera.freeze()
    assert [f.fault for f in watch.see(fresh(stage, camera))] == ["frozen"]
    camera.freeze(False)
    assert watch.see(fresh(stage, camera)) == ()
