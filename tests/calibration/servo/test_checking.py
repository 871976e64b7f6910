"""The check of servo maps at fresh poses."""

from __future__ import annotations

import numpy as np
import pytest

from calibration.catalogue import Site, has_check, start_check
from calibration.errors import CalibrationError
from calibration.record import CalibrationRecord, Measurement, make_record
from calibration.requests import Answer, Ask
from calibration.servo.measurement import measure_servos
from cell.kinematics.lynx import LynxArm
from cell.kinematics.servo_map import ArmCorrection, ServoMap
from cell.profile import load_cell_profile
from cell.profile.lynx import LynxProfile
from tests.calibration.moment import MOMENT
from tests.calibration.servo.bench import HIGH, LOW, Camera, plan, smooth_truth

PROFILE = load_cell_profile("lynx")
SITE = Site(profile=PROFILE, plan=None, current=())


def a_record() -> CalibrationRecord:
    assert isinstance(PROFILE.arm, LynxProfile)
    seen = Camera(smooth_truth(), plan(20, 5)).sights(np.random.default_rng(2))
    found = measure_servos(seen, LynxArm.from_profile(PROFILE.arm))
    return make_record(found, cell="lynx", measured_at=MOMENT, versions={}, answers={})


RECORD = a_record()


def turned(joint: int, by_deg: float) -> ArmCorrection:
    """The truth with one servo's horn turned."""
    truth = smooth_truth()
    maps = list(truth.maps)
    knots = tuple((given, reached + by_deg) for given, reached in maps[joint].knots_deg)
    maps[joint] = ServoMap(knots, maps[joint].joint)
    a, b, c, d, e = maps
    return ArmCorrection(maps=(a, b, c, d, e), sag=truth.sag)


def check(truth: ArmCorrection, count: int = 8) -> Measurement:
    """Check the record on an arm whose servos really go so."""
    poses = np.random.default_rng(4).uniform(LOW + 5.0, HIGH - 5.0, (count, 5))
    sights = Camera(truth, poses).sights(np.random.default_rng(5))
    given: dict[str, Answer] = {"fresh": float(count)}
    for number, sight in enumerate(sights, 1):
        at = sight.seen
        given[f"fresh-{number}-commanded"] = sight.commanded_deg
        given[f"fresh-{number}-marker"] = sight.mount
        given[f"fresh-{number}-seen"] = (at.x_mm, at.y_mm, at.z_mm, at.a_deg, at.b_deg, at.c_deg)
    procedure = start_check(RECORD, SITE)
    answer: Answer = None
    while True:
        try:
            request = procedure.send(answer)
        except StopIteration as stop:
            found: Measurement = stop.value
            return found
        answer = given.get(request.key, request.default) if isinstance(request, Ask) else None


def test_servos_that_go_as_they_went_pass_with_their_misses_in_mm() -> None:
    assert has_check(RECORD)
    found = check(smooth_truth())
    assert found.grade.value == "OK", found.findings
    assert found.accuracy.held_out_count == 8
    assert found.accuracy.held_out_rms is not None
    assert 0.1 < found.accuracy.held_out_rms < 1.6
    assert found.based_on == (RECORD.identity,)


@pytest.mark.parametrize("joint", range(5))
def test_a_horn_that_slipped_is_named_with_its_angle(joint: int) -> None:
    found = check(turned(joint, 3.0))
    (finding,) = found.findings
    assert finding.code == "servo-slipped"
    assert f"J{joint + 1} turned by" in finding.text
    assert "+2." in finding.text or "+3." in finding.text
    # The wrist moves a marker 40 mm from it by 2 mm only.
    assert found.grade.value == ("BAD" if joint < 3 else "DEGRADED")


def test_two_servos_that_slipped_are_told_without_naming_one() -> None:
    truth = turned(0, 3.0)
    maps = (truth.maps[0], *turned(2, -4.0).maps[1:])
    a, b, c, d, e = maps
    (finding,) = check(ArmCorrection(maps=(a, b, c, d, e), sag=truth.sag)).findings
    assert finding.code == "servos-changed"


def test_a_record_without_maps_is_refused() -> None:
    empty = RECORD.model_copy(update={"values": {}})
    with pytest.raises(CalibrationError, match="holds no servo maps"):
        next(start_check(empty, SITE))
