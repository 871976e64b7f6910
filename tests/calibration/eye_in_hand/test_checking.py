"""The check of an eye in hand at fresh points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from calibration.catalogue import Site, has_check, start_check
from calibration.errors import CalibrationError
from calibration.eye_in_hand.measurement import measure_eye_in_hand
from calibration.record import CalibrationRecord, Measurement, make_record
from calibration.requests import Answer
from cell.geometry.eye_in_hand import EyeInHand
from cell.profile import load_cell_profile
from tests.calibration.eye_in_hand.bench import NOMINAL, TRUTH, Bench, play
from tests.calibration.moment import MOMENT

SITE = Site(profile=load_cell_profile("avrs"), plan=None, current=())


def a_record() -> CalibrationRecord:
    bench = Bench(3)
    found = measure_eye_in_hand(bench.samples(14, 3), bench.stages(3), (), NOMINAL)
    return make_record(found, cell="avrs", measured_at=MOMENT, versions={}, answers={})


def check(eye: EyeInHand, count: int = 5, **answers: float) -> Measurement:
    """Check the record on an arm whose eye really is so."""
    given: dict[str, Answer] = {"fresh": float(count), **answers}
    for number, fresh in enumerate(Bench(8, eye).fresh(count), 1):
        look, touch = fresh.look, fresh.touch
        given[f"fresh-{number}"] = (
            look.u_px, look.v_px, look.j1_deg, look.j2_deg, touch.j1_deg, touch.j2_deg,
        )  # fmt: skip
    found, _ = play(start_check(RECORD, SITE), given)
    return found


RECORD = a_record()


def test_an_eye_that_is_as_it_was_passes_with_its_misses_in_mm() -> None:
    assert has_check(RECORD)
    found = check(TRUTH)
    assert found.grade.value == "OK", found.findings
    assert found.accuracy.held_out_count == 5
    assert found.accuracy.held_out_rms is not None
    assert 0.05 < found.accuracy.held_out_rms < 1.0
    assert found.based_on == (RECORD.identity,)
    assert found.values == {}


@pytest.mark.parametrize(("shift_mm", "grade"), [(3.0, "DEGRADED"), (-6.0, "BAD")])
def test_a_camera_that_was_shifted_on_its_link_is_named(shift_mm: float, grade: str) -> None:
    found = check(replace(TRUTH, d_t_c_mm=TRUTH.d_t_c_mm + shift_mm))
    assert [finding.code for finding in found.findings] == ["camera-moved"]
    assert found.grade.value == grade
    assert found.accuracy.held_out_rms == pytest.approx(abs(shift_mm), abs=0.7)


def test_links_that_are_not_what_they_were_are_told_without_a_guess() -> None:
    found = check(replace(TRUTH, angle_error_deg=TRUTH.angle_error_deg + 4.0))
    (finding,) = found.findings
    assert finding.code in ("eye-moved", "camera-moved")
    assert found.grade.value == "BAD"


def test_the_limit_is_the_one_that_is_given() -> None:
    assert check(TRUTH, limit=0.05).grade.value == "BAD"
    assert np.isfinite(check(TRUTH, count=1).accuracy.held_out_max or np.nan)


def test_a_record_without_an_eye_is_refused() -> None:
    with pytest.raises(CalibrationError, match="holds no eye in hand"):
        play(start_check(RECORD.model_copy(update={"values": {}}), SITE), {})
