"""Mistakes that people make while they calibrate, each named by its own code.

A case seeds the mistake into a sound calibration and returns what was found; the same case
without the mistake must not be called by that name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
import pytest

from calibration.homography.checking import check_homography
from calibration.homography.finding import Expected, ObjectNotFound, against_empty, find_object
from calibration.homography.knowledge import knowledge_of
from calibration.homography.noise import PairNoise
from calibration.homography.procedure import calibrate_homography
from calibration.homography.result import judged
from calibration.homography.sampling import Pair
from calibration.lens.fit import BoardView, LensPrior
from calibration.lens.judging import other_board, without_board
from calibration.lens.result import judged as lens_judged
from calibration.record import Measurement, make_record
from calibration.requests import Request, Show, StandAside
from calibration.verdict import Finding
from cell.geometry import LensModel
from cell.profile import load_profile
from cell.twin_cell import TwinCell
from cell.vision.boards import Board
from tests.calibration.hidden_truth import PLAYGROUND_CORNERS_MM, hidden, true_view, with_true_lens
from tests.calibration.lens.boards import board_views
from tests.calibration.moment import MOMENT
from tests.calibration.playing import played, site_of, twin_of

PROFILE = load_profile("mash")
TOP = 71.5
WIDE = LensModel(
    width_px=1280, height_px=960, focal_u_px=950.0, focal_v_px=950.0, centre_u_px=645.0,
    centre_v_px=470.0, k1=-0.08,
)  # fmt: skip


# Pairs of picture and robot points


def pairs(
    order: tuple[int, ...] = (0, 1, 2, 3), scale: float = 1.0, more: int = 0, off_px: float = 0.0
) -> Measurement:
    """Judge clicked pairs of a hidden cell; `more` points between, the last clicked wrong."""
    view = true_view(hidden(PROFILE, 9))
    places = list(PLAYGROUND_CORNERS_MM) + [(640.0, 60.0), (360.0, 120.0), (520.0, -260.0)][:more]
    points = np.array(places)
    noise = np.random.default_rng(3).normal(0.0, 0.4, points.shape)
    pixels = view.to_picture(points, TOP) + noise
    index = list(order) + list(range(4, 4 + more))
    pixels = pixels[index]
    pixels[-1] += off_px
    return taken(points * scale, pixels)


def taken(points: np.ndarray, pixels: np.ndarray) -> Measurement:
    found = [
        Pair(label=f"pair {i + 1}", point_mm=(float(x), float(y)), pixel=(float(u), float(v)),
             seen=None, picture="", levels=None)
        for i, ((x, y), (u, v)) in enumerate(zip(points, pixels, strict=True))
    ]  # fmt: skip
    known = knowledge_of(site_of(PROFILE), "top")
    noise = PairNoise(pixel_px=1.0, placement_mm=1.0)
    return judged(known, found, (), noise, quality_mm=5.0, by_arm=False)


def in_line(*, wrong: bool) -> Measurement:
    view = true_view(hidden(PROFILE, 9))
    middle = (500.0, 1.0) if wrong else (700.0, 300.0)
    points = np.array([(300.0, 0.0), (700.0, -10.0), middle, (350.0, 250.0)])
    if wrong:
        points[1] = (700.0, 0.0)
    return taken(points, view.to_picture(points, TOP))


# Views of a board


def boards(*, count: int = 12, same: bool = False, distance_mm: float = 0.0, square: float = 30.0
           ) -> Measurement:  # fmt: skip
    _, views = board_views(WIDE, count, np.random.default_rng(6), noise_px=0.2)
    if same:
        again = views[2].pixels + np.random.default_rng(1).normal(0.0, 0.2, views[2].pixels.shape)
        views.append(BoardView(label="view 13", ids=views[2].ids, pixels=again))
    board = Board(
        kind="charuco", columns=11, rows=8, square_mm=square, marker_mm=0.7 * square,
        dictionary="DICT_5X5_100",
    )  # fmt: skip
    return lens_judged(
        "top", "GUID", board, views, (1280, 960), LensPrior(), quality_px=1.0,
        distance_mm=distance_mm,
    )  # fmt: skip


def chessboard() -> np.ndarray:
    drawn = Board(kind="chessboard", columns=8, rows=6, square_mm=25.0).draw(2.0)
    page = cv2.copyMakeBorder(drawn, 60, 60, 60, 60, cv2.BORDER_CONSTANT, value=255)
    return np.ascontiguousarray(np.repeat(page[..., None], 3, axis=2))


def holding(*found: Finding | None) -> Measurement:
    named = tuple(finding for finding in found if finding is not None)
    return Measurement(kind="lens", subject="top", method="views alone", findings=named)


def wrong_board(*, wrong: bool) -> Measurement:
    asked = Board(
        kind="chessboard", columns=7 if wrong else 8, rows=5 if wrong else 6, square_mm=25.0
    )
    return holding(other_board(chessboard(), asked) if wrong else None)


def blurred(*, wrong: bool) -> Measurement:
    page = chessboard()
    if wrong:
        page = np.asarray(cv2.GaussianBlur(page, (0, 0), 8.0), np.uint8)
    return holding(without_board("view 1", page))


def unlit(*, level: int) -> Measurement:
    empty = np.full((960, 1280, 3), level, np.uint8)
    with_object = empty.copy()
    cv2.circle(with_object, (600, 400), 28, (180, 150, 110), -1)
    try:
        find_object(against_empty(with_object if level > 20 else empty, empty), Expected())
    except ObjectNotFound as error:
        return holding(error.finding)
    return holding()


# The wizard on the twin


def wizard(meddle: Callable[[TwinCell, Request], None] | None, **answers: float) -> Measurement:
    with twin_of(PROFILE, hidden(PROFILE, 9), 9) as cell:
        after = None if meddle is None else lambda request: meddle(cell, request)
        return played(calibrate_homography(site_of(PROFILE)), {"fresh": 0.0, **answers}, cell,
                      after=after)  # fmt: skip


def arm_returns(cell: TwinCell, request: Request) -> None:
    if isinstance(request, StandAside):
        cell.move_to(500.0, 0.0, 200.0)


def touched(cell: TwinCell, request: Request) -> None:
    """Push the object away from the third corner once the arm stands aside.

    Along the fingers' way: when they grip it again, they put it right.
    """
    if not isinstance(request, StandAside):
        return
    (block,) = cell.world.blocks.all()
    if block.x_mm > 600.0 and block.y_mm > 200.0:
        cell.world.blocks.put(replace(block, y_mm=block.y_mm - 9.0))


def screen_dark(cell: TwinCell, request: Request) -> None:
    if isinstance(request, Show):
        cell.world.set_picture("black")


@dataclass(frozen=True)
class Mistake:
    code: str
    wrong: Callable[[], Measurement]
    right: Callable[[], Measurement]


def sound() -> Measurement:
    return wizard(None)


MISTAKES = {
    "two picture points exchanged": Mistake("swapped-pairs", lambda: pairs((1, 0, 2, 3)), pairs),
    "corners the wrong way round": Mistake("mirrored-order", lambda: pairs((1, 0, 3, 2)), pairs),
    "corners begun half a round later": Mistake("turned-order", lambda: pairs((2, 3, 0, 1)), pairs),
    "centimetres for millimetres": Mistake("cm-for-mm", lambda: pairs(scale=0.1), pairs),
    "three points on a line": Mistake(
        "collinear-points", lambda: in_line(wrong=True), lambda: in_line(wrong=False)
    ),
    "one wrong click": Mistake(
        "misplaced-pair", lambda: pairs(more=3, off_px=18.0), lambda: pairs(more=3)
    ),
    "one careless click": Mistake(
        "outlier-pair", lambda: pairs(more=3, off_px=9.0), lambda: pairs(more=3)
    ),
    "lights off": Mistake("lights-off", lambda: unlit(level=4), lambda: unlit(level=90)),
    "too few views": Mistake("too-few-views", lambda: boards(count=2), boards),
    "a view taken twice": Mistake("duplicate-views", lambda: boards(same=True), boards),
    "square given in centimetres": Mistake(
        "cm-for-mm",
        lambda: boards(square=3.0, distance_mm=360.0),
        lambda: boards(distance_mm=360.0),
    ),
    "inner corners for squares": Mistake(
        "wrong-board", lambda: wrong_board(wrong=True), lambda: wrong_board(wrong=False)
    ),
    "blurred view": Mistake("blurred", lambda: blurred(wrong=True), lambda: blurred(wrong=False)),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named(name: str) -> None:
    mistake = MISTAKES[name]
    found = [finding.code for finding in mistake.wrong().findings]
    assert mistake.code in found, found
    assert mistake.code not in [finding.code for finding in mistake.right().findings]


def test_mistakes_at_the_twin_are_named() -> None:
    assert [f.code for f in sound().findings if f.grade.value == "BAD"] == []
    for meddle, code in (
        (arm_returns, "arm-in-picture"),
        (screen_dark, "screen-off"),
    ):
        found = wizard(meddle)
        assert code in [finding.code for finding in found.findings], code
        assert found.values == {}


def test_an_object_that_was_touched_after_placing_is_named() -> None:
    truth = hidden(PROFILE, 9)
    profile = with_true_lens(PROFILE, truth)
    with twin_of(profile, truth, 9) as cell:
        found = played(
            calibrate_homography(site_of(profile)), {"fresh": 3.0}, cell,
            after=lambda request: touched(cell, request),
        )  # fmt: skip
    (finding,) = (f for f in found.findings if f.code == "object-moved")
    # Gripped as it lies, it is put down as far off once more.
    assert finding.samples == ("pair 3", "pair 4")
    assert found.values == {}


def test_automatic_exposure_is_warned_of() -> None:
    with twin_of(PROFILE) as cell:
        cell.behind.cameras["top"].leave_auto("shutter")
        found = played(calibrate_homography(site_of(PROFILE)), {"fresh": 0.0}, cell)
    (finding,) = (f for f in found.findings if f.code == "auto-on")
    assert "shutter" in finding.text


def test_the_camera_of_another_cable_is_named_by_the_check() -> None:
    found = sound()
    record = make_record(found, cell="mash", measured_at=MOMENT, versions={}, answers={})
    other = PROFILE.cameras["top"].model_copy(update={"guid": "00B09D01009A7C99"})
    swapped = PROFILE.model_copy(update={"cameras": {**PROFILE.cameras, "top": other}})
    with twin_of(swapped) as cell:
        checked = played(check_homography(site_of(swapped), record), {"fresh": 1.0}, cell)
    assert "wrong-camera" in [finding.code for finding in checked.findings]
