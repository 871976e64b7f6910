from __future__ import annotations

import pytest

from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.eye_in_hand.procedure import eye_in_hand
from calibration.record import make_record
from calibration.requests import Answer, Ask
from calibration.verdict import Grade
from cell.profile import load_cell_profile
from cell.profile.ibm7545 import Ibm7545Profile
from tests.calibration.eye_in_hand.bench import TRUTH, Bench, play


def site(name: str = "avrs") -> Site:
    return Site(profile=load_cell_profile(name), plan=None, current=())


def answers(seed: int, looks: int = 12, touches: int = 3) -> dict[str, Answer]:
    bench = Bench(seed)
    samples = bench.samples(looks, touches)
    given: dict[str, Answer] = {"looks": float(looks), "touches": float(touches), "fresh": 2.0}
    for number, pair in enumerate(bench.stages(3), 1):
        given[f"pair-{number}-seen"] = pair.seen_deg
        given[f"pair-{number}-over"] = pair.over_deg
    for number, look in enumerate(samples.looks, 1):
        given[f"look-{number}"] = (look.u_px, look.v_px, look.j1_deg, look.j2_deg)
    for number, touch in enumerate(samples.touches, 1):
        given[f"touch-{number}"] = (touch.j1_deg, touch.j2_deg)
    for number, fresh in enumerate(bench.fresh(2), 1):
        look, touch = fresh.look, fresh.touch
        given[f"fresh-{number}"] = (
            look.u_px, look.v_px, look.j1_deg, look.j2_deg, touch.j1_deg, touch.j2_deg,
        )  # fmt: skip
    return given


def test_a_played_calibration_becomes_the_profile_s_eye_in_hand() -> None:
    import datetime

    measurement, _ = play(eye_in_hand(site()), answers(3))
    assert measurement.grade is not Grade.BAD, measurement.findings
    assert measurement.accuracy.held_out_count == 5
    assert measurement.accuracy.held_out_rms is not None
    assert measurement.accuracy.held_out_rms < 1.0
    record = make_record(
        measurement,
        cell="avrs",
        measured_at=datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC),
        versions={},
        answers={},
    )
    arm = calibrated_profile(site().profile, [record]).arm
    assert isinstance(arm, Ibm7545Profile)
    assert arm.eye_in_hand is not None
    eye = arm.eye_in_hand.value(arm.link_mm)
    assert eye.d_t_c_mm == pytest.approx(TRUTH.d_t_c_mm, abs=0.6)
    assert eye.link_1_mm == pytest.approx(TRUTH.link_1_mm, abs=1.5)


def test_the_same_answers_lead_to_the_same_questions() -> None:
    first, asked = play(eye_in_hand(site()), answers(4))
    second, again = play(eye_in_hand(site()), answers(4))
    assert asked == again
    assert first == second


def test_every_question_has_its_own_key_and_looks_are_suggested() -> None:
    _, asked = play(eye_in_hand(site()), answers(5))
    questions = [request for request in asked if isinstance(request, Ask)]
    assert len({question.key for question in questions}) == len(questions)
    looks = [question.question for question in questions if question.key.startswith("look-")]
    assert all("it should appear near" in text for text in looks if "Drive" in text)


def test_an_arm_without_a_second_link_s_camera_is_refused() -> None:
    with pytest.raises(CalibrationError, match="lynx-al5d"):
        play(eye_in_hand(site("lynx")), {})


def test_a_broken_count_is_refused_by_its_key() -> None:
    with pytest.raises(CalibrationError, match="looks: 2 is not"):
        play(eye_in_hand(site()), {**answers(1), "looks": 2.0})
