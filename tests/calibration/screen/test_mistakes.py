"""What people do wrong with a calibration by the screen is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.screen.board import SeenBoard, find_board, judge_board, judge_rest
from calibration.screen.camera_model import LensPrior, fit_alone
from calibration.screen.decode import correspondences
from calibration.screen.held_out import left_out
from calibration.screen.joint_fit import Observations, fit_screen
from calibration.screen.judge import (
    judge_features,
    judge_fit,
    judge_map,
    judge_scale,
    screen_views,
)
from calibration.screen.patterns import RAMP
from calibration.screen.response import read_response
from calibration.screen.result import map_error
from calibration.verdict import Finding, Grade
from tests.calibration.screen.cell_on_stage import PANEL, Watched
from tests.calibration.screen.synthetic import synthetic_cell
from tests.cell.twin.cameras.stage import PROFILE, joints_at
from tests.cell.twin.cameras.test_patterns import PatternStage


@pytest.fixture(scope="module")
def given() -> Observations:
    return synthetic_cell(PROFILE, 7, cameras=("top",), noise_px=0.1).given


def codes(findings: tuple[Finding, ...]) -> list[str]:
    return [finding.code for finding in findings]


def scale_findings(given: Observations) -> tuple[Finding, ...]:
    seen = given.seen["top"]
    alone = fit_alone(seen, given.screen.pixel_mm, LensPrior(), 0.1).parameters
    bare = replace(given, blocks=())
    return judge_scale(given, screen_views(bare, np.concatenate([np.zeros(3), alone])))


def focal_px(given: Observations) -> float:
    found = fit_screen(given)
    return float(found.fit.parameters[given.offset("top")])


def test_nothing_is_said_where_nothing_is_wrong(given: Observations) -> None:
    found = fit_screen(given)
    assert judge_fit(found, left_out(found)) == ()
    assert scale_findings(given) == ()


def test_a_scaled_picture_or_another_panel_is_named(given: Observations) -> None:
    wrong = replace(given, screen=replace(given.screen, pixel_mm=given.screen.pixel_mm * 1.03))
    (finding,) = scale_findings(wrong)
    assert finding.code == "screen-scaled"
    assert finding.grade is Grade.BAD
    assert "0.46" in finding.text  # what a pixel would have


def test_a_picture_that_is_turned_round_is_named(given: Observations) -> None:
    wrong = replace(given, screen=replace(given.screen, angle_deg=-90.0))
    assert codes(scale_findings(wrong)) == ["screen-turned"]


def test_a_block_that_slipped_is_named(given: Observations) -> None:
    blocks = list(given.blocks)
    x, y = blocks[2].robot_mm
    blocks[2] = replace(blocks[2], robot_mm=(x + 5.0, y))
    found = fit_screen(replace(given, blocks=blocks))
    named = [f for f in judge_fit(found, left_out(found)) if f.code == "misplaced-point"]
    assert len(named) == 1
    assert named[0].samples == ("block 3",)


def test_one_plane_alone_does_not_tell_how_far_away_a_long_lens_is() -> None:
    cell = synthetic_cell(PROFILE, 7, cameras=("top",), blocks=0)
    trusted = replace(cell.given.screen, deviation_mm=0.1, deviation_deg=0.01)
    found = fit_screen(replace(cell.given, screen=trusted))
    focal = found.given.offset("top")
    deviation = float(np.sqrt(found.fit.covariance[focal, focal]))
    assert deviation > 0.02 * found.fit.parameters[focal]
    assert "not-tied-to-robot" in codes(judge_fit(found, ()))


def test_a_camera_that_sets_itself_is_named() -> None:
    stage = PatternStage()
    camera = stage.camera("top")
    assert judge_features("top", camera.features()) == ()
    camera.leave_auto("shutter")
    (finding,) = judge_features("top", camera.features())
    assert finding.code == "auto-exposure"
    assert "shutter" in finding.text


def test_a_mirrored_picture_a_covered_screen_and_a_knock_are_named() -> None:
    stage = PatternStage()
    watched = Watched(stage, stage.camera("top"))
    picture = watched.shot(PANEL.board())
    seen = find_board(picture, PANEL)
    assert len(seen.index) > 50
    assert judge_board("top", picture, seen, PANEL) == ()
    again = find_board(watched.shot(PANEL.board()), PANEL)
    assert judge_rest("top", seen, again) == ()
    mirrored = np.ascontiguousarray(picture[:, ::-1])
    assert codes(judge_board("top", mirrored, find_board(mirrored, PANEL), PANEL)) == [
        "picture-mirrored"
    ]
    dark = watched.shot(PANEL.field(0))
    assert codes(judge_board("top", dark, find_board(dark, PANEL), PANEL)) == ["screen-not-seen"]
    watched.camera.knock(0.6, -0.4)
    knocked = find_board(watched.shot(PANEL.board()), PANEL)
    assert codes(judge_rest("top", seen, knocked)) == ["camera-moved"]


def test_the_arm_over_the_screen_is_named() -> None:
    stage = PatternStage()
    stage.move(joints_at(450.0, 0.0, 200.0))
    seen = Watched(stage, stage.camera("top")).map()
    assert codes(judge_map("top", seen, correspondences(seen))) == ["arm-in-picture"]


def test_the_brightest_grey_that_no_camera_clips_is_found_with_the_screens_gamma() -> None:
    stage = PatternStage()
    watched = Watched(stage, stage.camera("top"))
    response = read_response("top", {value: watched.shot(PANEL.field(value)) for value in RAMP})
    assert response.findings == ()
    assert response.gamma == pytest.approx(2.2, abs=0.15)
    assert 140 < response.bright < 180
    assert watched.shot(PANEL.field(response.bright)).max() < 250


@pytest.mark.parametrize(
    ("black", "gain", "code"),
    [
        (180.0, 20.0, "lights-too-bright"),
        (5.0, 3.0, "screen-not-seen"),
        (20.0, 9000.0, "picture-clips"),
    ],
)
def test_light_that_leaves_nothing_for_the_pattern_is_named(
    black: float, gain: float, code: str
) -> None:
    fields = {
        value: np.full((96, 128, 3), np.clip(black + gain * (value / 255) ** 2.2, 0, 255), np.uint8)
        for value in RAMP
    }
    response = read_response("top", fields)
    assert codes(response.findings) == [code]


def test_places_that_no_lens_explains_are_named(given: Observations) -> None:
    seen = given.seen["top"]
    noise = np.random.default_rng(1).normal(0.0, 1.0, seen.pixels.shape)
    found = fit_screen(replace(given, seen={"top": replace(seen, pixels=seen.pixels + noise)}))
    named = [f for f in judge_fit(found, ()) if f.code == "lens-misfit"]
    assert [f.grade for f in named] == [Grade.DEGRADED]
    assert "1.00 px" in named[0].text


def test_a_pattern_seen_on_half_of_the_playground_is_named(given: Observations) -> None:
    seen = given.seen["top"]
    found = fit_screen(replace(given, seen={"top": seen.part(seen.pixels[:, 0] < 640.0)}))
    assert "little-coverage" in codes(judge_fit(found, ()))


def test_a_camera_whose_distance_nobody_knows_is_told_apart_from_badly_placed_blocks() -> None:
    free = synthetic_cell(PROFILE, 7, cameras=("top",), blocks=0, noise_px=1.5).given
    loose = replace(free, screen=replace(free.screen, deviation_mm=0.1, deviation_deg=0.01))
    assert "depth-unknown" in codes(judge_fit(fit_screen(loose), ()))
    given = synthetic_cell(PROFILE, 7, cameras=("top",)).given
    blocks = [replace(block, deviation_mm=2.0) for block in given.blocks]
    lens = LensPrior(focal_px=focal_px(given), focal_deviation_px=2.0)
    rough = replace(given, blocks=blocks, priors={"top": lens})
    assert "inaccurate" in codes(judge_fit(fit_screen(rough), ()))


def test_blocks_of_which_several_are_off_are_not_blamed_on_one(given: Observations) -> None:
    blocks = list(given.blocks)
    for index, (right, up) in {1: (5.0, 0.0), 4: (-4.0, 5.0)}.items():
        x, y = blocks[index].robot_mm
        blocks[index] = replace(blocks[index], robot_mm=(x + right, y + up))
    found = fit_screen(replace(given, blocks=blocks))
    named = [f.code for f in judge_fit(found, left_out(found))]
    assert "points-disagree" in named
    assert "misplaced-point" not in named


def test_a_board_that_is_covered_at_the_end_is_named() -> None:
    corners = np.arange(40)
    pixels = np.stack([20.0 * corners, 10.0 * corners], axis=1)
    first = SeenBoard(index=corners, pixels=pixels, places=pixels)
    last = SeenBoard(index=corners[:5], pixels=pixels[:5], places=pixels[:5])
    (finding,) = judge_rest("top", first, last)
    assert finding.code == "covered-meanwhile"
    assert finding.grade is Grade.BAD
    assert judge_rest("top", first, first) == ()


def test_the_scatter_of_points_is_no_error_of_the_map() -> None:
    random = np.random.default_rng(4)
    below, stated = 0, 0.0
    for _ in range(400):
        own, map_mm = random.normal(0.0, 0.3, (6, 2)), random.normal(0.0, 0.5, (6, 2))
        distances = np.hypot(*(own + map_mm).T).tolist()
        found, upper = map_error(distances, [0.3 * np.sqrt(2.0)] * 6, 0.2)
        assert found is not None
        assert upper is not None
        assert 0.2 <= found <= np.sqrt(np.mean(np.square(distances)))
        stated += found**2 / 400
        below += upper > 0.5 * np.sqrt(2.0)
    assert np.sqrt(stated) == pytest.approx(0.5 * np.sqrt(2.0), rel=0.05)
    assert 0.93 * 400 < below < 0.97 * 400
    assert map_error([], [], 0.2) == (None, None)
