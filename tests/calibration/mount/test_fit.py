"""Lens and mount from synthetic views: exact, honest, and mistakes by their names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.errors import FitFailed
from calibration.least_squares import differences
from calibration.mount.fit import ArmNoise, fit_mount
from calibration.mount.model import MountState, MountView, Scene, transform
from calibration.mount.result import judged
from calibration.mount.start import second_turn_deg, start_of
from calibration.record import Measurement
from calibration.statistics import chi_square_quantile, mahalanobis_squared
from calibration.verdict import Grade
from cell.geometry import Transform
from tests.calibration.mount.bench import (
    NOISE,
    grid,
    offset,
    robot_from_flange,
    seen,
    truth,
    views_of,
)

CASES = 500
SMALL = grid(8, 5, 105.0)

Points = NDArray[np.float64]


def judge(views: list[MountView]) -> Measurement:
    return judged("gripper", "a board", views, NOISE, surface_mm=38.5, quality_mm=1.0, pictures={})


def codes(measured: Measurement) -> set[str]:
    return {one.code for one in measured.findings}


def with_scale(views: list[MountView], factor: float) -> list[MountView]:
    return [replace(view, points_mm=view.points_mm * factor) for view in views]


def test_slopes_are_those_of_finite_differences() -> None:
    random = np.random.default_rng(1)
    state = truth(random)
    views = views_of(state, random, 3)
    views[2] = replace(views[2], group=1)
    state = replace(state, targets=state.targets * 2)
    scene = Scene(views)
    slopes, by_arm = scene.slopes(state, with_scale=True)
    measured = -differences(lambda change: scene.residuals(state.moved(change)), np.zeros(24))
    assert np.abs(slopes - measured).max() < 1e-5
    far = 1e-4
    for column in range(6):
        shift = np.zeros(6)
        shift[column] = far
        turn = np.zeros(3)
        turn[:] = shift[3:]
        pushed = [
            replace(
                view,
                robot_from_flange=MountState(
                    lens=state.lens,
                    flange_from_camera=view.robot_from_flange,
                    targets=(),
                )
                .moved(np.array([0, 0, 0, 0, 0, *turn, 0, 0, 0]))
                .flange_from_camera
                @ transform(np.eye(3), shift[:3]),
            )
            for view in views
        ]
        change = Scene(pushed).residuals(state) - scene.residuals(state)
        assert np.abs(-change / far - by_arm[:, column]).max() < 0.05


@pytest.mark.parametrize("seed", range(4))
def test_views_without_noise_give_the_exact_camera(seed: int) -> None:
    random = np.random.default_rng([seed, 2])
    true = truth(random)
    none = ArmNoise(position_mm=1e-9, angle_deg=1e-9)
    views = views_of(true, random, 8, noise=none, sigma_px=1e-6)
    start = start_of(views)
    assert start.scale == pytest.approx(1.0, abs=0.05), f"seed {seed}"
    fitted = fit_mount(views, replace(start, scale=1.0), none)
    far = offset(fitted.state, true)
    assert np.abs(far).max() < 1e-3, f"seed {seed}"


def test_95_percent_regions_hold_the_truth_in_93_to_97_percent() -> None:
    held_all, held_mount, strain = 0, 0, 0.0
    for case in range(CASES):
        random = np.random.default_rng([case, 3])
        true = truth(random)
        views = views_of(true, random, 8, points=SMALL)
        fitted = fit_mount(views, true.moved(random.normal(0, 1e-3, 17)), NOISE)
        off, covariance = offset(fitted.state, true), fitted.covariance[:11, :11]
        held_all += mahalanobis_squared(off, covariance) <= chi_square_quantile(0.95, 11)
        mount = off[5:]
        part = covariance[5:, 5:]
        held_mount += mahalanobis_squared(mount, part) <= chi_square_quantile(0.95, 6)
        strain += fitted.strain / fitted.freedom
    assert 0.93 <= held_all / CASES <= 0.97, f"{held_all} of {CASES}, seeds [case, 3]"
    assert 0.93 <= held_mount / CASES <= 0.97, f"{held_mount} of {CASES}, seeds [case, 3]"
    assert strain / CASES == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_good_views_are_ok_and_their_held_out_error_is_the_true_one(seed: int) -> None:
    random = np.random.default_rng([seed, 4])
    true = truth(random)
    measured = judge(views_of(true, random, 12))
    assert measured.grade is Grade.OK, (seed, measured.findings)
    assert measured.accuracy.held_out_rms is not None
    assert 0.03 < measured.accuracy.held_out_rms < 0.3, f"seed {seed}"
    assert measured.accuracy.predicted_rms is not None
    assert measured.accuracy.predicted_rms < 0.15
    assert set(measured.values) == {"cameras.gripper.lens", "cameras.gripper.mount"}
    assert len(measured.covariance) == len(measured.parameters) == 11


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("factor", "words"),
    [(1.02, "98.0"), (0.98, "102.0"), (0.1, "in centimetres"), (1 / 25.4, "in inches")],
)
def test_a_target_of_another_size_is_named_with_its_size(
    seed: int, factor: float, words: str
) -> None:
    random = np.random.default_rng([seed, 5])
    measured = judge(with_scale(views_of(truth(random), random, 12), factor))
    assert codes(measured) == {"wrong-scale"}, f"seed {seed}: {measured.findings}"
    assert words in measured.findings[0].text, f"seed {seed}"
    assert measured.values == {}


@pytest.mark.parametrize("seed", range(4))
def test_a_target_that_was_moved_is_named_with_when_and_how_far(seed: int) -> None:
    random = np.random.default_rng([seed, 6])
    true = truth(random)
    first = true.targets[0]
    pushed = transform(first.rotation, first.translation_mm + (4.0, 3.0, 0.0))
    after = replace(true, targets=(pushed,))
    split = 4 + seed
    views = []
    for index in range(12):
        now = true if index < split else after
        flange = robot_from_flange(now, random)
        views.append(seen(now, flange, grid(), random, f"pose {index + 1}"))
    measured = judge(views)
    assert codes(measured) == {"target-moved"}, f"seed {seed}: {measured.findings}"
    text = measured.findings[0].text
    assert f"between pose {split} and pose {split + 1}" in text, f"seed {seed}"
    assert " 5.0 mm" in text or " 4.9 mm" in text or " 5.1 mm" in text, text
    assert measured.grade is Grade.BAD


@pytest.mark.parametrize("seed", range(4))
def test_one_view_with_a_wrong_pose_is_left_out_by_its_name(seed: int) -> None:
    random = np.random.default_rng([seed, 7])
    true = truth(random)
    views = views_of(true, random, 12)
    wrong = transform(np.eye(3), np.array([0.0, 3.0, 0.0]))
    views[6] = replace(views[6], robot_from_flange=views[6].robot_from_flange @ wrong)
    measured = judge(views)
    assert codes(measured) == {"outlier-view"}, f"seed {seed}: {measured.findings}"
    assert measured.findings[0].samples == ("pose 7",)
    assert measured.grade is Grade.DEGRADED
    assert measured.values


def test_an_arm_less_exact_than_stated_is_told_and_widens_the_regions() -> None:
    random = np.random.default_rng(8)
    true = truth(random)
    loose = ArmNoise(position_mm=0.25, angle_deg=0.05)
    measured = judge(views_of(true, random, 14, noise=loose))
    assert codes(measured) == {"arm-inexact"}, measured.findings
    random = np.random.default_rng(8)
    exact = judge(views_of(truth(random), random, 14))
    wide, narrow = measured.parameters[8].deviation, exact.parameters[8].deviation
    assert wide is not None
    assert narrow is not None
    assert wide > 3.0 * narrow


def test_poses_turned_about_the_vertical_alone_are_refused_by_name() -> None:
    random = np.random.default_rng(9)
    true = truth(random)
    views = views_of(true, random, 12, tilt_deg=0.0)
    assert second_turn_deg(views) < 1e-1
    assert "no-rotation" in codes(judge(views))
    with pytest.raises(FitFailed, match="tilt"):
        start_of(views)


@pytest.mark.parametrize(("count", "grade"), [(0, "BAD"), (4, "BAD"), (7, "DEGRADED")])
def test_too_few_poses_are_named(count: int, grade: str) -> None:
    random = np.random.default_rng([count, 10])
    measured = judge(views_of(truth(random), random, count))
    found = {one.code: one.grade for one in measured.findings}
    assert found["too-few-poses"] == Grade(grade)
    assert bool(measured.values) is (grade != "BAD")


def test_a_transform_of_the_bench_is_told_not_quite_right() -> None:
    random = np.random.default_rng(11)
    true = truth(random)
    flange = robot_from_flange(true, random)
    told: Transform = seen(true, flange, grid(), random, "x").robot_from_flange
    assert 0.0 < float(np.linalg.norm(told.translation_mm - flange.translation_mm)) < 1.0
