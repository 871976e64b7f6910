from __future__ import annotations

import datetime
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.record import Measurement, make_record
from calibration.requests import Answer, Ask, Request
from calibration.servo.measurement import measure_servos
from calibration.servo.procedure import servo_maps
from calibration.servo.samples import Sight
from calibration.verdict import Grade
from cell.geometry import Pose
from cell.kinematics.lynx import LynxArm
from cell.kinematics.servo_map import ArmCorrection, Five
from cell.profile import load_cell_profile
from cell.profile.lynx import LynxProfile
from tests.calibration.eye_in_hand.bench import play
from tests.calibration.servo.bench import HIGH, LOW, Camera, plan, smooth_truth

PROFILE = load_cell_profile("lynx")
assert isinstance(PROFILE.arm, LynxProfile)
ARM = LynxArm.from_profile(PROFILE.arm)


def sights(seed: int) -> list[Sight]:
    return Camera(smooth_truth(), plan(25, 7)).sights(np.random.default_rng(seed))


def moved(sight: Sight, factor: float) -> Sight:
    seen = sight.seen
    return replace(
        sight,
        seen=Pose(
            factor * seen.x_mm, factor * seen.y_mm, factor * seen.z_mm,
            seen.a_deg, seen.b_deg, seen.c_deg,
        ),
    )  # fmt: skip


def recommanded(sight: Sight, change: Callable[[list[float]], list[float]]) -> Sight:
    a, b, c, d, e = change(list(sight.commanded_deg))
    commanded: Five = (a, b, c, d, e)
    return replace(sight, commanded_deg=commanded)


def turned_round(joint: int) -> Callable[[list[float]], list[float]]:
    return lambda q: [-v if i == joint else v for i, v in enumerate(q)]


MISTAKES: dict[str, Callable[[Sight], Sight]] = {
    "seen-in-cm": lambda s: moved(s, 0.1),
    "seen-in-m": lambda s: moved(s, 0.001),
    "radians": lambda s: recommanded(s, lambda q: np.radians(q).tolist()),
    "reversed-J1": lambda s: recommanded(s, turned_round(0)),
    "reversed-J3": lambda s: recommanded(s, turned_round(2)),
    "reversed-J5": lambda s: recommanded(s, turned_round(4)),
    "swapped-J4-J5": lambda s: recommanded(s, lambda q: [*q[:3], q[4], q[3]]),
}


@pytest.mark.parametrize("code", MISTAKES)
def test_a_mistake_is_named(code: str) -> None:
    measurement = measure_servos([MISTAKES[code](sight) for sight in sights(1)], ARM)
    assert [finding.code for finding in measurement.findings] == [code]
    assert measurement.grade is Grade.BAD
    assert measurement.values == {}


def test_good_sights_are_not_blamed() -> None:
    for seed in range(4):
        measurement = measure_servos(sights(seed), ARM)
        assert measurement.grade is not Grade.BAD, measurement.findings
        assert not [f for f in measurement.findings if f.code == "play"]


def test_a_sight_that_does_not_belong_is_named() -> None:
    wrong = sights(3)
    seen = wrong[20].seen
    wrong[20] = replace(wrong[20], seen=replace(seen, x_mm=seen.x_mm + 6.0))
    measurement = measure_servos(wrong, ARM)
    apart = [f for f in measurement.findings if f.code == "sight-apart"]
    assert apart[0].samples == ("sight 21",)
    assert not next(s for s in measurement.samples if s.label == "sight 21").is_used


def test_play_of_a_joint_is_found_and_told() -> None:
    rows = np.repeat(plan(), 2, axis=0)
    camera = Camera(smooth_truth(), rows)
    up = np.arange(len(rows)) % 2 == 0
    shaken = rows.copy()
    shaken[:, 0] += np.where(up, -0.6, 0.6)
    other = Camera(smooth_truth(), shaken)
    other.commanded = camera.commanded
    seen = [
        replace(sight, came_from=1 if is_up else -1)
        for sight, is_up in zip(other.sights(np.random.default_rng(5)), up, strict=True)
    ]
    (finding,) = [f for f in measure_servos(seen, ARM).findings if f.code == "play"]
    assert "J1" in finding.text
    assert "1.2 deg" in finding.text or "1.3 deg" in finding.text or "1.1 deg" in finding.text


def test_held_out_and_uncorrected_distances_show_the_gain() -> None:
    fresh = Camera(
        smooth_truth(), np.random.default_rng(8).uniform(LOW + 1, HIGH - 1, (30, 5))
    ).sights(np.random.default_rng(9))
    measurement = measure_servos(sights(2), ARM, fresh=fresh)
    accuracy = measurement.accuracy
    assert accuracy.held_out_count == 30
    assert accuracy.held_out_rms is not None
    assert accuracy.held_out_rms < 1.2
    uncorrected = measurement.details["uncorrected_rms_mm"]
    assert isinstance(uncorrected, float)
    assert uncorrected > 5.0 * accuracy.held_out_rms


@pytest.mark.parametrize("count", [40, 45])
def test_how_exactly_servos_are_known_is_stated_from_45_sights_on(count: int) -> None:
    seen = Camera(smooth_truth(), plan(20, 5)).sights(np.random.default_rng(1))[:count]
    measurement = measure_servos(seen, ARM)
    used = sum(sample.is_used for sample in measurement.samples)
    is_stated = used >= 45
    assert is_stated == (count == 45)
    assert (measurement.covariance != ()) == is_stated
    assert any(p.deviation is not None for p in measurement.parameters) == is_stated
    assert (measurement.accuracy.predicted_rms is not None) == is_stated
    assert ("few-sights" in [f.code for f in measurement.findings]) == (not is_stated)
    assert any("how exactly" in text for text in measurement.not_known) == (not is_stated)
    assert measurement.accuracy.held_out_rms is not None
    assert "arm.correction" in measurement.values


class _Arm:
    """Answers the procedure like an arm under a camera that does what is advised."""

    def __init__(self, seed: int) -> None:
        self._generator = np.random.default_rng(seed)
        self._sight: Sight | None = None

    def answer(self, request: Request) -> Answer:
        if not isinstance(request, Ask):
            return None
        if request.key.endswith("-commanded"):
            assert isinstance(request.default, tuple)
            rows = np.array([request.default])
            (self._sight,) = Camera(smooth_truth(), rows).sights(self._generator)
            return request.default
        assert request.key
        if request.key.endswith("-marker"):
            assert self._sight is not None
            return self._sight.mount
        if request.key.endswith("-seen"):
            assert self._sight is not None
            seen = self._sight.seen
            return (seen.x_mm, seen.y_mm, seen.z_mm, seen.a_deg, seen.b_deg, seen.c_deg)
        return request.default


def _played(seed: int) -> tuple[Measurement, list[Request]]:
    procedure, arm = servo_maps(Site(profile=PROFILE, plan=None, current=())), _Arm(seed)
    asked: list[Request] = []
    answer: Answer = None
    while True:
        try:
            request = procedure.send(answer)
        except StopIteration as stop:
            return stop.value, asked
        asked.append(request)
        answer = arm.answer(request)


def test_a_played_calibration_that_takes_every_advice_becomes_the_profile_s() -> None:
    measurement, asked = _played(4)
    assert measurement.grade is not Grade.BAD, measurement.findings
    keys = [request.key for request in asked if isinstance(request, Ask)]
    assert len(set(keys)) == len(keys)
    record = make_record(
        measurement,
        cell="lynx",
        measured_at=datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC),
        versions={},
        answers={},
    )
    arm = calibrated_profile(PROFILE, [record]).arm
    assert isinstance(arm, LynxProfile)
    assert arm.correction is not None
    correction = ArmCorrection.from_profile(arm.correction)
    wanted = (10.0, 20.0, 15.0, 30.0, -10.0)
    reached = smooth_truth().reached(correction.command_for(wanted))
    assert np.abs(np.array(reached) - wanted).max() < 1.0
    assert np.abs(np.array(smooth_truth().reached(wanted)) - wanted).max() > 2.0


def test_another_arm_is_refused() -> None:
    site = Site(profile=load_cell_profile("avrs"), plan=None, current=())
    with pytest.raises(CalibrationError, match="ibm-7545"):
        play(servo_maps(site), {})
