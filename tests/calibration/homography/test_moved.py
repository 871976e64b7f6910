"""The camera, or the object, is moved while the wizard measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from calibration.homography.finding import ObjectNotFound, Seen, on_screen
from calibration.homography.judging import Pairs
from calibration.homography.knowledge import knowledge_of
from calibration.homography.noise import PairNoise
from calibration.homography.outliers import judge_noise
from calibration.homography.procedure import calibrate_homography
from calibration.homography.sampling import Pair
from calibration.homography.standing_still import judge_camera, shift_between
from calibration.record import Measurement
from calibration.requests import Request, StandAside
from cell.profile import load_profile
from cell.twin_cell import TwinCell
from tests.calibration.hidden_truth import PLAYGROUND_CORNERS_MM, hidden, true_view, with_true_lens
from tests.calibration.playing import codes, played, site_of, twin_of

NOMINAL = load_profile("mash")


def scene(shift_px: tuple[float, float], object_px: tuple[float, float], seed: int) -> Pair:
    """A picture at half size of a lit screen's corner, with the object on it."""
    random = np.random.default_rng(seed)
    grey = np.full((480, 640), 140.0, np.float32)
    back = np.array([[1.0, 0.0, 0.5 * shift_px[0]], [0.0, 1.0, 0.5 * shift_px[1]]])
    grey[40:, :590] = 250.0
    grey = np.asarray(cv2.warpAffine(cv2.GaussianBlur(grey, (0, 0), 1.0), back, (640, 480),
                                     borderMode=cv2.BORDER_REPLICATE), np.float32)  # fmt: skip
    u, v = object_px
    cv2.circle(grey, (round(u / 2), round(v / 2)), 14, 90.0, -1)
    grey += random.normal(0.0, 1.0, grey.shape).astype(np.float32)
    seen = Seen(u_px=u, v_px=v, radius_px=28.0, deviation_px=0.02, edge_px=2.0,
                is_side_hidden=False)  # fmt: skip
    return Pair(label=f"pair {seed}", point_mm=(0.0, 0.0), pixel=(u, v), seen=seen, picture="",
                levels=None, still=grey)  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_a_shift_of_the_fixed_scene_is_measured_whatever_the_object_does(seed: int) -> None:
    random = np.random.default_rng(seed)
    truth = random.uniform(-12.0, 12.0, 2)
    found = shift_between(scene((0.0, 0.0), (200.0, 300.0), 1),
                          scene((truth[0], truth[1]), (900.0, 700.0), 2))  # fmt: skip
    assert found is not None
    assert found == pytest.approx(truth, abs=0.1), seed


def test_a_camera_that_stands_still_is_not_accused() -> None:
    for seed in range(1, 6):
        spots = np.random.default_rng(seed).uniform((100, 150), (1100, 850), (2, 2))
        pairs = [scene((0.0, 0.0), (float(u), float(v)), seed + i)
                 for i, (u, v) in enumerate(spots)]  # fmt: skip
        assert judge_camera(pairs) == (), seed


def test_pictures_without_anything_fixed_say_nothing() -> None:
    bare = [replace(scene((0.0, 0.0), (300.0 * i, 400.0), i), label=f"pair {i}") for i in (1, 2)]
    random = np.random.default_rng(1)
    white = [random.normal(250.0, 0.5, (480, 640)).astype(np.float32) for _ in bare]
    pairs = [replace(pair, still=still) for pair, still in zip(bare, white, strict=True)]
    assert shift_between(*pairs) is None
    assert judge_camera(pairs) == ()


def wizard(meddle: Callable[[TwinCell, int], None]) -> Measurement:
    """Calibrate; `meddle` is called each time the arm has stepped aside, with how often."""
    truth = hidden(NOMINAL, 9)
    profile = with_true_lens(NOMINAL, truth)
    aside = 0
    with twin_of(profile, truth, 9) as cell:

        def after(request: Request) -> None:
            nonlocal aside
            if isinstance(request, StandAside):
                aside += 1
                meddle(cell, aside)

        return played(calibrate_homography(site_of(profile)), {"fresh": 3.0}, cell, after=after)


def test_a_camera_bumped_between_two_pairs_is_named() -> None:
    def bump(cell: TwinCell, aside: int) -> None:
        if aside == 3:
            cell.behind.cameras["top"].knock(4.0, -3.0)

    found = wizard(bump)
    (finding,) = (f for f in found.findings if f.code == "camera-moved")
    assert "between pair 2 and pair 3" in finding.text
    assert "5." in finding.text or "4.9" in finding.text
    assert found.values == {}
    assert "object-moved" not in codes(found)


def test_an_object_pushed_along_the_fingers_is_off_there_and_once_more_and_named() -> None:
    def push(cell: TwinCell, aside: int) -> None:
        if aside == 3:
            (block,) = cell.world.blocks.all()
            moved = replace(block, x_mm=block.x_mm + 4.0, y_mm=block.y_mm + 4.0)
            cell.world.blocks.put(moved)

    found = wizard(push)
    (finding,) = (f for f in found.findings if f.code == "object-moved")
    assert finding.samples == ("pair 3", "pair 4")
    assert found.values == {}
    assert "camera-moved" not in codes(found)


PLACES = np.array([*PLAYGROUND_CORNERS_MM, (640.0, 60.0), (360.0, 120.0), (520.0, -260.0)])
LABELS = tuple(f"pair {i + 1}" for i in range(len(PLACES)))


def touched(seed: int, begin: int, end: int) -> list[tuple[str, ...]]:
    """Return which pairs are named where those of a range lie off by the same."""
    random = np.random.default_rng([seed, 5])
    truth = hidden(NOMINAL, seed % 8)
    known = knowledge_of(site_of(with_true_lens(NOMINAL, truth)), "top")
    at = PLACES + random.normal(0.0, 0.3, PLACES.shape)
    turn = random.uniform(0.0, 2.0 * np.pi)
    at[begin:end] += random.uniform(5.0, 9.0) * np.array([np.cos(turn), np.sin(turn)])
    seen = true_view(truth).to_picture(at, 71.5) + random.normal(0.0, 0.2, at.shape)
    found = judge_noise(Pairs(LABELS, seen, PLACES), known,
                        PairNoise(pixel_px=0.2, placement_mm=0.3), by_arm=True)  # fmt: skip
    return [finding.samples for finding in found if finding.code == "object-moved"]


@pytest.mark.parametrize("seed", range(4))
def test_the_pair_from_which_on_all_are_off_is_named(seed: int) -> None:
    begin = 2 + seed
    assert touched(seed, begin, len(PLACES)) == [LABELS[begin:]]


@pytest.mark.parametrize("seed", range(4))
def test_sound_pairs_are_not_accused(seed: int) -> None:
    assert touched(seed, 0, 0) == []


def test_lights_that_are_off_under_a_lit_screen_are_named_and_do_no_harm() -> None:
    with twin_of(NOMINAL, hidden(NOMINAL, 9), 9) as cell:
        cell.world.burn_out_lamps()
        found = played(calibrate_homography(site_of(NOMINAL)), {"fresh": 0.0}, cell)
    (finding,) = (f for f in found.findings if f.code == "lights-off")
    assert finding.grade.value == "DEGRADED"
    assert "cameras.top.plane_map" in found.values


def test_screen_and_lights_that_are_off_are_both_named() -> None:
    dark = np.full((96, 128, 3), 6, np.uint8)
    with pytest.raises(ObjectNotFound) as error:
        on_screen(dark, dark)
    assert [finding.code for finding in error.value.findings] == ["screen-off", "lights-off"]


def test_a_wrong_peak_of_the_correlation_accuses_nobody() -> None:
    with twin_of(NOMINAL, hidden(NOMINAL, 1010), 1010) as cell:
        found = played(calibrate_homography(site_of(NOMINAL)), {"fresh": 0.0}, cell)
    assert "camera-moved" not in codes(found)
    assert "cameras.top.plane_map" in found.values


@pytest.mark.parametrize("seed", range(8))
def test_a_move_of_one_and_a_half_pixels_is_seen_whatever_its_direction(seed: int) -> None:
    turn = float(np.random.default_rng([seed, 15]).uniform(0.0, 2.0 * np.pi))
    truth = (1.5 * np.cos(turn), 1.5 * np.sin(turn))
    pairs = [scene((0.0, 0.0), (200.0, 300.0), 1), scene(truth, (900.0, 700.0), 2)]
    assert [finding.code for finding in judge_camera(pairs)] == ["camera-moved"], seed
