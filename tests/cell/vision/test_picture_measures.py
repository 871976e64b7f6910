from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.twin.cameras.light import flicker_share
from cell.vision.picture_measures import (
    draw_histogram,
    flicker,
    focus,
    histogram,
    patches,
    side_by_side,
)
from tests.cell.twin.cameras.stage import PROFILE, Stage, block

Pixels = NDArray[np.uint8]


def series(levels: list[float], seed: int = 3) -> list[Pixels]:
    """Return noisy pictures of one scene whose light is as given."""
    random = np.random.default_rng(seed)
    scene = random.uniform(40.0, 180.0, (24, 32, 3)).repeat(20, axis=0).repeat(20, axis=1)
    return [
        np.clip(scene * level + random.normal(0.0, 2.0, scene.shape), 0, 255).astype(np.uint8)
        for level in levels
    ]


def test_a_histogram_counts_every_pixel_and_its_ends() -> None:
    pixels = np.zeros((10, 20, 3), np.uint8)
    pixels[:, :5, 0] = 255
    pixels[:, :, 1] = 100
    found = histogram(pixels)
    assert found.counts.sum(axis=1).tolist() == [200, 200, 200]
    assert found.clipped_share == (0.25, 0.0, 0.0)
    assert found.black_share == (0.75, 0.0, 1.0)
    assert found.means == pytest.approx((63.75, 100.0, 0.0))
    assert found.percentile(0.8) == (255, 100, 0)


def test_patches_are_the_means_deviations_and_clipped_shares_of_their_pixels() -> None:
    random = np.random.default_rng(5)
    pixels = random.integers(0, 256, (96, 128, 3), dtype=np.uint8)
    cut = patches(pixels, 4, 3)
    part = pixels[32:64, 96:128].astype(float)
    assert cut.means.shape == (3, 4, 3)
    assert cut.means[1, 3] == pytest.approx(part.mean(axis=(0, 1)), abs=1e-3)
    assert cut.deviations[1, 3] == pytest.approx(part[..., 1].std(), abs=1e-2)
    assert cut.clipped[1, 3] == pytest.approx((part.max(axis=2) >= 252).mean(), abs=1e-6)


def test_sides_that_cannot_be_cut_are_refused() -> None:
    with pytest.raises(ValueError, match="100 x 96 px"):
        patches(np.zeros((96, 100, 3), np.uint8), 32, 24)


@pytest.mark.parametrize("name", ["top", "oblique"])
def test_focus_falls_with_blur_and_hardly_changes_with_light_or_blocks(name: str) -> None:
    stage = Stage().put(block("cube", "red", 400.0, 0.0)).show("black")
    camera = stage.camera(name)
    sharp = focus(camera.grab().pixels)
    stage.put(block("bridge", "blue", 520.0, -100.0, yaw_deg=30.0))
    assert focus(camera.grab().pixels) == pytest.approx(sharp, rel=0.03)
    before = PROFILE.cameras[name].settings.shutter_ms
    camera.set_absolute("shutter", 0.6 * before)
    assert focus(camera.grab().pixels) == pytest.approx(sharp, rel=0.03)
    camera.set_absolute("shutter", before)
    blurred = []
    for sigma_px in (0.8, 1.5, 3.0):
        camera.defocus(sigma_px)
        blurred.append(focus(camera.grab().pixels) / sharp)
    assert blurred == sorted(blurred, reverse=True)
    assert blurred[0] < 0.93
    assert blurred[1] < 0.85


@pytest.mark.parametrize("swing", [0.02, 0.1])
def test_flicker_is_the_swing_of_the_light(swing: float) -> None:
    light = [1.0 + swing * np.cos(2.0 * np.pi * n / 3.0 + 0.3) for n in range(6)]
    found = flicker(series(light))
    expected = (max(light) - min(light)) / 2.0
    assert found.swing_share == pytest.approx(expected, rel=0.06)
    assert found.noise_share < swing / 5.0


def test_steady_light_has_no_more_flicker_than_its_noise_accounts_for() -> None:
    for seed in range(10):
        found = flicker(series([1.0] * 5, seed))
        assert found.swing_share < 0.002, f"seed {seed}"


def test_flicker_needs_pictures_in_a_row() -> None:
    with pytest.raises(ValueError, match="at least 3"):
        flicker(series([1.0, 1.0]))


def test_a_shutter_of_whole_swings_lets_no_flicker_through() -> None:
    light = PROFILE.twin.light.model_copy(update={"flicker": 0.4})

    def shares(shutter_ms: float) -> NDArray[np.float64]:
        return np.array(
            [flicker_share(light, shutter_ms=shutter_ms, number=n, rate_hz=7.5) for n in range(12)]
        )

    assert np.ptp(shares(20.0)) < 1e-9
    assert np.ptp(shares(5.0)) > 0.3
    assert np.ptp(shares(1.0)) > np.ptp(shares(5.0)) > np.ptp(shares(16.0)) > 0.02
    still = light.model_copy(update={"flicker": 0.0})
    assert flicker_share(still, shutter_ms=1.0, number=7, rate_hz=7.5) == 1.0


def test_pictures_for_people_stand_beside_each_other_with_their_histograms() -> None:
    bright = np.full((960, 1280, 3), 200, np.uint8)
    dark = np.full((480, 640, 3), 20, np.uint8)
    both = side_by_side([("before", dark), ("after", bright)])
    assert both.shape == (780, 1280, 3)
    assert both[100, 100].tolist() == [20, 20, 20]
    assert both[100, 900].tolist() == [200, 200, 200]
    chart = draw_histogram(bright, "after")
    column = chart[60:254, 34 + 2 * 200]
    assert (column.min(axis=1) < 150).any()
    blurred = cv2.GaussianBlur(bright, (0, 0), 2.0)
    assert (draw_histogram(np.asarray(blurred, np.uint8), "after") == chart).all()
    with pytest.raises(ValueError, match="no pictures"):
        side_by_side([])
