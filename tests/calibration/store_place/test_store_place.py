"""Where the store's sheet lies: fits that are honest, mistakes by name, the procedure played."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from datetime import UTC, datetime
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.applying import calibrated_profile
from calibration.catalogue import Site
from calibration.errors import CalibrationError, FitFailed
from calibration.pictures import picture_of
from calibration.procedure import Procedure
from calibration.record import CalibrationRecord, Measurement, make_record
from calibration.requests import (
    Answer,
    Ask,
    Capture,
    ReadTool,
    Request,
    StandAside,
    Tell,
    ToolReading,
    Value,
)
from calibration.statistics import chi_square_quantile
from calibration.store_place.checking import check_store_place
from calibration.store_place.checks import overlap_mm, reach_finding, screen_finding
from calibration.store_place.fitting import Touched, fit_corners, placed
from calibration.store_place.mistakes import misfit_finding, named_mistake, scale_finding
from calibration.store_place.procedure import store_place
from calibration.verdict import Grade
from cell.geometry import JointPositions, Pose
from cell.profile import PlaceProfile, Profile, StoreProfile, load_profile
from cell.profile.cameras import LensProfile
from cell.sheet import lay_out
from cell.store import StorePlan
from tests.cell.sheet.bench import MASH_SLOTS, picture_of_sheet, view_from

PROFILE: Profile = load_profile("mash")
PLAN = StorePlan(MASH_SLOTS)
LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)
SIZE = (float(LAYOUT.width_mm), float(LAYOUT.height_mm))
CORNERS = np.array([(0.0, 0.0), (SIZE[0], 0.0), SIZE, (0.0, SIZE[1])])
NAMES = ("upper-left", "upper-right", "lower-right", "lower-left")

Points = NDArray[np.float64]


def corners_at(x_mm: float, y_mm: float, angle_deg: float, count: int = 4) -> Points:
    return placed(np.array([x_mm, y_mm, angle_deg]), CORNERS[:count])


def touched(points: Points, *, noise_mm: float = 0.3, scale: float = 1.0) -> Touched:
    return Touched(size_mm=SIZE, scale=scale, points_mm=points, noise_mm=noise_mm)


def site(profile: Profile = PROFILE) -> Site:
    return Site(profile=profile, plan=PLAN, current=())


def play(
    procedure: Procedure,
    answers: dict[str, Value],
    touches: Sequence[Sequence[float]] = (),
    pictures: Sequence[NDArray[np.uint8]] = (),
) -> Measurement:
    """Play a procedure: answers by key or default, touches and pictures in their order."""
    waiting, shots = list(touches), list(pictures)

    def answer(request: Request) -> Answer:
        match request:
            case Ask(key=key, default=default):
                if request.kind == "done":
                    return True
                value = answers.get(key, default)
                assert value is not None, f"no answer to {key}"
                return value
            case Tell() | StandAside():
                return None
            case ReadTool():
                x, y = waiting.pop(0)
                return ToolReading(pose=Pose(x, y, 60.0), joints=JointPositions((0.0,) * 6))
            case Capture(camera=camera):
                return picture_of(camera, shots.pop(0))
        raise AssertionError(f"nobody answers {request}")

    def played() -> Generator[Request, None, None]:
        measured.append((yield from _answered(procedure, answer)))

    measured: list[Measurement] = []
    for _ in played():
        pass
    return measured[0]


def _answered(
    procedure: Procedure, answer: Callable[[Request], Answer]
) -> Generator[Request, None, Measurement]:
    request = next(procedure)
    while True:
        yield request
        try:
            request = procedure.send(answer(request))
        except StopIteration as end:
            return cast(Measurement, end.value)


def recorded(measured: Measurement) -> CalibrationRecord:
    return make_record(
        measured, cell="mash", measured_at=datetime(2026, 1, 2, tzinfo=UTC), versions={}, answers={}
    )


def codes(measured: Measurement) -> set[str]:
    return {one.code for one in measured.findings}


@pytest.mark.parametrize("count", [2, 3, 4])
def test_exact_corners_give_the_exact_place(count: int) -> None:
    fitted = fit_corners(touched(corners_at(-243.2, 688.1, 3.4, count)))
    assert fitted.corner_mm == pytest.approx((-243.2, 688.1), abs=1e-6)
    assert fitted.angle_deg == pytest.approx(3.4, abs=1e-8)
    assert len(fitted.held_out_mm) == (count if count > 2 else 0)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_the_95_percent_region_holds_the_truth_in_93_to_97_of_100_cases(count: int) -> None:
    random = np.random.default_rng([count, 4])
    bound, held, cases = chi_square_quantile(0.95, 3), 0, 1000
    for _ in range(cases):
        truth = np.array([*random.uniform(-300, 700, 2), random.uniform(-180, 180)])
        points = placed(truth, CORNERS[:count]) + random.normal(0, 0.3, (count, 2))
        fitted = fit_corners(touched(points))
        off = np.array([*fitted.corner_mm, fitted.angle_deg]) - truth
        off[2] = math.degrees(math.remainder(math.radians(off[2]), math.tau))
        held += float(off @ np.linalg.solve(fitted.covariance, off)) <= bound
    assert 0.93 <= held / cases <= 0.97, f"seed [{count}, 4]: {held}"


def test_a_printers_scale_is_taken_from_the_ruler() -> None:
    points = placed(np.array([-250.0, 700.0, 1.0]), CORNERS * 0.97)
    fitted = fit_corners(touched(points, scale=0.97))
    assert np.abs(fitted.residuals_mm).max() < 1e-6
    found = scale_finding(0.97)
    assert found is not None
    assert found.code == "printed-scale"
    assert "97.0 %" in found.text
    assert scale_finding(1.001) is None


@pytest.mark.parametrize(
    ("points", "code"),
    [
        (corners_at(-250, 700, 0) / 10.0, "wrong-unit"),
        (corners_at(-250, 700, 0) / 25.4, "wrong-unit"),
        (corners_at(-250, 700, 0, 2)[::-1], "swapped-corners"),
        (corners_at(-250, 700, 0)[[1, 0, 3, 2]], "mirrored"),
        (corners_at(-250, 700, 0)[[0, 3]], "wrong-corner"),
        (corners_at(-250, 700, 0)[[0, 2]], "wrong-corner"),
        (corners_at(-250, 700, 0)[[0, 1, 1, 3]], "same-corner"),
        (corners_at(-250, 700, 180, 4), "swapped-corners"),
    ],
)
def test_a_mistake_with_the_corners_is_named(points: Points, code: str) -> None:
    found = named_mistake(touched(points), PROFILE.store)
    assert found is not None
    assert found.code == code
    assert found.grade is Grade.BAD
    assert found.hint


def test_corners_touched_well_are_no_mistake() -> None:
    random = np.random.default_rng(5)
    alarms = 0
    for case in range(500):
        place = random.uniform(-300, 700), random.uniform(-300, 700), random.uniform(-30, 30)
        points = corners_at(*place) + random.normal(0, 0.3, (4, 2))
        assert named_mistake(touched(points), PROFILE.store) is None, f"seed 5, case {case}"
        alarms += misfit_finding(touched(points), fit_corners(touched(points))) is not None
    assert alarms <= 4


@pytest.mark.parametrize("count", [2, 4])
def test_a_corner_that_does_not_fit_is_named(count: int) -> None:
    points = corners_at(-250, 700, 0, count)
    points[1] += (6.0, 0.0)
    found = misfit_finding(touched(points), fit_corners(touched(points)))
    assert found is not None
    assert found.code == "corners-disagree"
    assert "553.0 mm" in found.text or "upper right" in found.text


def test_one_corner_or_all_at_one_point_are_refused() -> None:
    with pytest.raises(FitFailed, match="two at least"):
        fit_corners(touched(corners_at(0, 0, 0, 1)))
    with pytest.raises(FitFailed, match="different ones"):
        fit_corners(touched(np.zeros((3, 2))))


def test_the_profiles_own_store_is_in_reach_and_beside_the_screen() -> None:
    assert reach_finding(PROFILE, PLAN, PROFILE.store) is None
    assert screen_finding(PROFILE.display, PROFILE.store, SIZE) is None


def test_a_store_too_far_away_names_its_slots() -> None:
    far = StoreProfile(corner_mm=(-250.0, 1100.0))
    found = reach_finding(PROFILE, PLAN, far)
    assert found is not None
    assert found.code == "out-of-reach"
    assert "slots 1, 2" in found.text


def test_a_sheet_on_the_screen_says_how_far() -> None:
    over = StoreProfile(corner_mm=(-250.0, 690.0))
    found = screen_finding(PROFILE.display, over, SIZE)
    assert found is not None
    assert "8.0 mm" in found.text
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    assert overlap_mm(square, square + 3.0) < 0.0


def test_touched_corners_become_values_of_the_profile() -> None:
    truth = (-247.0, 703.0, 0.8)
    random = np.random.default_rng(3)
    points = corners_at(*truth) + random.normal(0, 0.2, (4, 2))
    measured = play(store_place(site()), {"noise": 0.2}, touches=points.tolist())
    assert measured.grade is Grade.OK, measured.findings
    profile = calibrated_profile(PROFILE, [recorded(measured)])
    assert profile.store.corner_mm == pytest.approx(truth[:2], abs=0.8)
    assert profile.store.angle_deg == pytest.approx(truth[2], abs=0.1)
    assert measured.accuracy.held_out_count == 4
    assert measured.accuracy.held_out_rms is not None
    assert measured.accuracy.held_out_rms < 1.0
    assert measured.accuracy.predicted_rms is not None


def test_two_typed_corners_tell_that_the_held_out_error_is_not_known() -> None:
    first, second = corners_at(-250, 700, 0, 2).tolist()
    measured = play(
        store_place(site()),
        {"way": "type", "corners": 2.0, NAMES[0]: tuple(first), NAMES[1]: tuple(second)},
    )
    assert measured.grade is Grade.OK
    assert measured.accuracy.held_out_rms is None
    assert any("not fitted on" in text for text in measured.not_known)


def test_a_ruler_of_97_mm_is_bad_whatever_the_corners_say() -> None:
    points = placed(np.array([-250.0, 700.0, 0.0]), CORNERS * 0.97)
    measured = play(store_place(site()), {"ruler": 97.0}, touches=points.tolist())
    assert measured.grade is Grade.BAD
    assert codes(measured) == {"printed-scale"}


@pytest.mark.parametrize(
    ("answers", "words"),
    [({"ruler": 10.0}, "millimetres"), ({"corners": 5.0}, "2, 3 or 4"), ({"noise": 0.0}, "above")],
)
def test_answers_that_cannot_be_are_refused(answers: dict[str, Value], words: str) -> None:
    with pytest.raises(CalibrationError, match=words):
        play(store_place(site()), answers, touches=corners_at(0, 0, 0).tolist())


def seeing_profile() -> Profile:
    """Return a profile whose oblique camera is calibrated, looking down at the sheet."""
    view = view_from(PROFILE.store, height_mm=700.0, tilt_deg=12.0)
    pose = view.robot_from_camera.to_pose()
    lens = view.lens
    camera = PROFILE.cameras["oblique"].model_copy(
        update={
            "lens": LensProfile(
                focal_px=(lens.focal_u_px, lens.focal_v_px),
                centre_px=(lens.centre_u_px, lens.centre_v_px),
                k1=lens.k1,
            ),
            "place": PlaceProfile(
                position_mm=(pose.x_mm, pose.y_mm, pose.z_mm),
                rotation_deg=(pose.a_deg, pose.b_deg, pose.c_deg),
            ),
        }
    )
    return PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "oblique": camera}})


def test_a_calibrated_camera_finds_the_sheet_and_a_check_sees_that_it_moved() -> None:
    profile = seeing_profile()
    view = view_from(PROFILE.store, height_mm=700.0, tilt_deg=12.0)
    truth = StoreProfile(corner_mm=(-246.0, 704.0), angle_deg=1.1)
    shots = [picture_of_sheet(LAYOUT, truth, view, seed=seed) for seed in range(3)]
    measured = play(store_place(site(profile)), {"way": "camera"}, pictures=shots)
    assert measured.grade is Grade.OK, measured.findings
    corner_mm = measured.values["store.corner_mm"]
    assert corner_mm == pytest.approx(list(truth.corner_mm), abs=0.3)
    record = recorded(measured)
    shots = [picture_of_sheet(LAYOUT, truth, view, seed=seed) for seed in range(3, 6)]
    still = play(check_store_place(site(profile), record), {"way": "camera"}, pictures=shots)
    assert still.grade is Grade.OK
    moved = truth.model_copy(update={"corner_mm": (-241.0, 704.0)})
    shots = [picture_of_sheet(LAYOUT, moved, view, seed=seed) for seed in range(3)]
    gone = play(check_store_place(site(profile), record), {"way": "camera"}, pictures=shots)
    assert codes(gone) == {"moved"}
    assert gone.grade is Grade.BAD


def test_a_picture_without_the_sheet_is_bad_and_sets_nothing() -> None:
    dark = np.zeros((960, 1280, 3), np.uint8)
    measured = play(
        store_place(site(seeing_profile())), {"way": "camera", "pictures": 1.0}, pictures=[dark]
    )
    assert codes(measured) == {"not-found"}
    assert measured.values == {}
