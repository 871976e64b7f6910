from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from cell.devices.camera import MODES
from cell.errors import VisionError
from cell.pictures import PICTURE_NAMES
from cell.twin.cameras import TwinCamera
from cell.vision.picture_health import (
    PictureReference,
    judge_picture,
    make_reference,
    sharpness_at,
    shift_from,
)
from tests.cell.twin.cameras.stage import Stage, block, joints_at

NAMES = ("top", "oblique", "gripper")
KINDS = ("cube", "bridge", "cylinder")
COLOURS = ("red", "green", "blue", "yellow", "natural")


@cache
def references() -> dict[str, PictureReference]:
    made = {}
    for name in NAMES:
        stage = Stage().show("black")
        camera = stage.camera(name)
        black = camera.grab().pixels
        stage.show("white")
        made[name] = make_reference(name, [black, camera.grab().pixels])
    return made


def looked_at(name: str, seed: int) -> TwinCamera:
    """Return a healthy camera before a scene of chance; the gripper's at its rest pose."""
    generator = np.random.default_rng(seed)
    blocks = [
        block(
            str(generator.choice(KINDS)),
            str(generator.choice(COLOURS)),
            float(generator.uniform(320, 690)),
            float(generator.uniform(-320, 280)),
        )
        for _ in range(generator.integers(0, 5))
    ]
    stage = Stage().put(*blocks).show(PICTURE_NAMES[seed % len(PICTURE_NAMES)])
    if name != "gripper" and generator.random() < 0.6:
        x_mm, y_mm = float(generator.uniform(350, 680)), float(generator.uniform(-300, 250))
        stage.move(joints_at(x_mm, y_mm, 200.0))
    return stage.camera(name, seed=seed)


def faults_of(name: str, camera: TwinCamera) -> list[str]:
    return [f.fault for f in judge_picture(name, camera.grab().pixels, references())]


@pytest.mark.parametrize("seed", range(100), ids=lambda seed: f"seed{seed}")
def test_healthy_pictures_give_no_finding(seed: int) -> None:
    name = NAMES[seed % 3]
    camera = looked_at(name, seed)
    assert judge_picture(name, camera.grab().pixels, references()) == ()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [11, 12, 13])
def test_each_seeded_fault_is_found_and_named(name: str, seed: int) -> None:
    camera = looked_at(name, seed)
    camera.cover_lens()
    assert faults_of(name, camera) == ["dark"]
    camera.mend()
    camera.defocus(3.0)
    assert faults_of(name, camera) == ["out of focus"]
    camera.mend()
    for knock in ((5.0, 0.0), (-4.0, 6.0), (30.0, -20.0)):
        camera.knock(*knock)
        assert "moved" in faults_of(name, camera)
    camera.mend()
    settings = camera.settings()
    camera.configure(replace(settings, gain_db=24.0)).require()
    assert faults_of(name, camera) == ["overexposed"]
    camera.configure(settings).require()
    assert faults_of(name, camera) == []


@pytest.mark.parametrize(("one", "other"), [("top", "oblique"), ("oblique", "gripper")])
def test_cameras_that_changed_places_are_told_by_their_pictures(one: str, other: str) -> None:
    stage = Stage().show("water")
    first, second = stage.camera(one), stage.camera(other)
    first.swap_places(second)
    for name, camera, shown in ((one, first, other), (other, second, one)):
        (finding,) = judge_picture(name, camera.grab().pixels, references())
        assert (finding.fault, finding.other) == ("swapped", shown)
        assert shown in finding.text


@pytest.mark.parametrize("knock", [(8.0, 0.0), (0.0, -6.0), (-21.0, 13.0)])
def test_shift_is_measured_to_a_pixel(knock: tuple[float, float]) -> None:
    camera = looked_at("oblique", 4)
    camera.knock(*knock)
    shift = shift_from(camera.grab().pixels, references()["oblique"])
    assert (shift.dx_px, shift.dy_px) == pytest.approx(knock, abs=1.0)


def test_small_modes_are_judged_by_the_reference_of_the_full_one() -> None:
    stage = Stage().show("mash")
    camera = stage.camera("oblique")
    camera.open(MODES[0])
    assert judge_picture("oblique", camera.grab().pixels, references()) == ()
    camera.knock(10.0, 0.0)
    (finding,) = judge_picture("oblique", camera.grab().pixels, references())
    assert finding.fault == "moved"
    assert finding.measured == pytest.approx(10.0, abs=1.5)


@pytest.mark.parametrize("name", NAMES)
def test_sharpness_falls_steadily_with_defocus(name: str) -> None:
    camera = looked_at(name, 1)
    values = []
    for sigma_px in (0.0, 1.0, 2.0, 4.0, 6.0):
        camera.defocus(sigma_px)
        values.append(sharpness_at(camera.grab().pixels, references()[name]))
    steps = [later / sooner for sooner, later in pairwise(values)]
    assert max(steps) < 0.96
    assert values[-1] < 0.6 * values[0]


def test_light_is_judged_even_without_a_reference() -> None:
    camera = looked_at("top", 2)
    assert judge_picture("top", camera.grab().pixels) == ()
    camera.cover_lens()
    (finding,) = judge_picture("top", camera.grab().pixels)
    assert finding.fault == "dark"
    assert "take the cap off" in finding.text


def test_pictures_without_anything_in_common_make_no_reference() -> None:
    dark, bright = (np.full((96, 128, 3), level, np.uint8) for level in (0, 200))
    with pytest.raises(VisionError, match="nothing in common"):
        make_reference("top", [dark, bright])
    with pytest.raises(VisionError, match="one size"):
        make_reference("top", [])
