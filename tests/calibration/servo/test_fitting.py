from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.errors import FitFailed
from calibration.least_squares import differences
from calibration.servo.chain import MarkerChain
from calibration.servo.fitting import ServoFit, ServoModel, fit_servos
from calibration.servo.judge import gripper_deviation
from calibration.servo.samples import BACK, TOP, MarkerNoise, Sight
from calibration.statistics import t_quantile
from cell.kinematics.servo_map import ArmCorrection
from tests.calibration.servo.bench import (
    GEOMETRY,
    HIGH,
    LOW,
    SAG,
    Camera,
    curve,
    plan,
    smooth_truth,
    truth_at,
)

KNOTS = [np.linspace(LOW[i], HIGH[i], 3) for i in range(5)]
FIGURES = [SAG.shoulder_deg, SAG.elbow_deg, SAG.wrist_deg, SAG.hand_share]


def in_order(truth: ArmCorrection) -> np.ndarray:
    return np.array([*(y for servo in truth.maps for _, y in servo.knots_deg), *FIGURES])


def sights(seed: int, factor: float = 1.0) -> list[Sight]:
    return Camera(smooth_truth(), plan()).sights(np.random.default_rng(seed), factor)


def found(seed: int) -> ServoFit:
    return fit_servos(sights(seed), GEOMETRY)


def gripper_miss_mm(correction: ArmCorrection | None, count: int = 400) -> float:
    fresh = np.random.default_rng(99).uniform(LOW + 1, HIGH - 1, (count, 5))
    chain = MarkerChain(GEOMETRY, [BACK.tool_from_marker] * count)
    true = chain.places(smooth_truth().reached_all(fresh))[0]
    thought = fresh if correction is None else correction.reached_all(fresh)
    off = chain.places(thought)[0] - true
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def test_slopes_are_those_of_finite_differences_at_the_solution() -> None:
    model = ServoModel(sights(1, 1e-6), GEOMETRY, (BACK, TOP), MarkerNoise())
    truth = truth_at(model.knots)
    p = in_order(truth)
    away = np.abs(model.slopes(p) - differences(model.residuals, p)).max()
    assert away < 2e-2 * np.abs(model.slopes(p)).max()
    exact = Camera(truth, plan()).sights(np.random.default_rng(1), 1e-9)
    model = ServoModel(exact, GEOMETRY, (BACK, TOP), MarkerNoise())
    assert np.abs(model.slopes(p) - differences(model.residuals, p)).max() < 1e-5


def test_regions_hold_the_truth_in_93_to_97_of_100_calibrations() -> None:
    runs, held = 1000, 0
    truth = truth_at(KNOTS)
    camera, true = Camera(truth, plan(20, 5)), in_order(truth)
    inside = np.zeros(true.size)
    for seed in range(runs):
        fit = fit_servos(camera.sights(np.random.default_rng(seed)), GEOMETRY, knots=KNOTS)
        assert not fit.held, seed
        held += fit.holds(true)
        deviation = np.sqrt(np.diag(fit.covariance))
        inside += np.abs(fit.parameters - true) <= t_quantile(0.95, fit.freedom) * deviation
    assert 0.93 <= held / runs <= 0.97, f"{held} of {runs} (seeds 0 to {runs - 1})"
    assert 0.94 <= inside.mean() / runs <= 0.96, inside
    assert inside.min() / runs > 0.92, inside
    assert inside.max() / runs < 0.98, inside


def test_smooth_servos_outside_the_model_s_class_lie_in_the_bands_nearly_as_often() -> None:
    inside = []
    for seed in range(20):
        fit = found(seed)
        for joint in range(5):
            true = curve(joint, fit.knots_deg[joint])
            ours = np.array([y for _, y in fit.correction.maps[joint].knots_deg])
            inside += (np.abs(ours - true) <= fit.band_deg(joint)).tolist()
    assert np.mean(inside) > 0.88, np.mean(inside)


def test_the_simultaneous_band_is_wider_and_holds_all_knots_of_a_joint() -> None:
    fit = found(3)
    for joint in range(5):
        assert (fit.simultaneous_band_deg(joint) > fit.band_deg(joint)).all()
        true = curve(joint, fit.knots_deg[joint])
        ours = np.array([y for _, y in fit.correction.maps[joint].knots_deg])
        assert (np.abs(ours - true) <= fit.simultaneous_band_deg(joint)).all()


def test_the_gripper_is_known_to_half_a_millimetre_instead_of_fifteen() -> None:
    before = gripper_miss_mm(None)
    after = [gripper_miss_mm(found(seed).correction) for seed in range(5)]
    assert before > 10.0
    assert max(after) < 0.8, (before, after)


def test_the_predicted_deviation_of_the_gripper_is_what_it_shows() -> None:
    fresh = np.random.default_rng(99).uniform(LOW + 1, HIGH - 1, (200, 5))
    predicted = float(np.sqrt((gripper_deviation(found(4), fresh, GEOMETRY) ** 2).mean()))
    shown = float(np.mean([gripper_miss_mm(found(seed).correction, 200) for seed in range(6)]))
    assert 0.5 < shown / predicted < 2.0, (shown, predicted)


def test_place_and_turn_alone_are_enough_with_wider_bands() -> None:
    blind = MarkerNoise(height_mm=None, tilt_deg=None)
    fit = fit_servos(sights(5), GEOMETRY, noise=blind)
    whole = found(5)
    assert fit.freedom < whole.freedom
    assert fit.band_deg(1).mean() > whole.band_deg(1).mean()
    assert (
        np.abs(np.array(fit.correction.maps[0].knots_deg)[:, 1] - curve(0, fit.knots_deg[0])).max()
        < 0.5
    )


def test_sag_is_held_and_said_to_be_where_no_sight_tells_it() -> None:
    rows = plan(0, 15)
    one_joint = rows[:15]
    still = np.concatenate([rows[:15], rows[60:]])
    assert len(one_joint) == 15
    spread = np.random.default_rng(3).uniform(LOW, HIGH, (30, 5))
    spread[:, 1:4] = np.linspace(0, 1, 30)[:, None] * (HIGH - LOW)[1:4] * 0.5 + LOW[1:4]
    camera = Camera(smooth_truth(), np.concatenate([still, spread]))
    fit = fit_servos(camera.sights(np.random.default_rng(1)), GEOMETRY)
    assert fit.held


def test_a_joint_that_never_moved_is_refused_by_name() -> None:
    rows = plan()
    rows[:, 2] = 20.0
    camera = Camera(smooth_truth(), rows)
    with pytest.raises(FitFailed, match="J3 was commanded to 1 angles"):
        fit_servos(camera.sights(np.random.default_rng(1)), GEOMETRY)


def test_an_unknown_marker_is_refused() -> None:
    wrong = [replace(sight, mount="side") for sight in sights(1)]
    with pytest.raises(FitFailed, match="'side'"):
        fit_servos(wrong, GEOMETRY)


def test_a_servo_against_its_stop_gives_a_map_that_still_rises() -> None:
    truth = smooth_truth()
    rows = plan()
    stopped = rows.copy()
    stopped[:, 0] = np.minimum(stopped[:, 0], 30.0)
    camera = Camera(truth, stopped)
    camera.commanded = rows
    fit = fit_servos(camera.sights(np.random.default_rng(2)), GEOMETRY)
    assert fit.flat == ("J1",)
    assert (np.diff([y for _, y in fit.correction.maps[0].knots_deg]) > 0).all()
