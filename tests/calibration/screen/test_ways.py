"""The screen is tied to the robot by touched or typed points, through the whole procedure."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.pictures import picture_of
from calibration.player import play
from calibration.procedure import Procedure
from calibration.record import Measurement
from calibration.requests import (
    Answer,
    Capture,
    PutBlock,
    ReadFeatures,
    ReadTool,
    Request,
    Show,
    StandAside,
    ToolReading,
    Value,
)
from calibration.screen.patterns import Panel
from calibration.screen.procedure import screen
from calibration.screen.tying import CROSS_PX, tied_by_blocks
from calibration.verdict import Grade
from cell.geometry import CameraView, JointPositions, Pose
from cell.stop import StopToken
from cell.store import StorePlan
from tests.calibration.hidden_truth import hidden, true_view
from tests.calibration.playing import Answers, codes
from tests.calibration.screen.cell_on_stage import Watched, true_places_mm
from tests.calibration.screen.synthetic import screen_place
from tests.cell.twin.cameras.stage import PROFILE
from tests.cell.twin.cameras.test_patterns import PatternStage

SEED = 6
TRUTH = hidden(PROFILE, SEED)
SITE = Site(profile=PROFILE, plan=StorePlan(()), current=())
CROSSES_MM = true_places_mm(TRUTH, np.array(CROSS_PX, np.float64))


class Hands:
    """Shows and looks on a stage; the arm is a person's, who brings it onto each cross.

    What was looked at once is not rendered again.
    """

    def __init__(self) -> None:
        stage = PatternStage()
        self._watched = Watched(stage, stage.camera("top", profile=TRUTH, seed=SEED))
        self._seen: dict[str, NDArray[np.uint8]] = {}
        self._shown, self._pixels = "", np.empty(0, np.uint8)

    def perform(self, request: Request) -> Answer:
        match request:
            case Show(name=name, pixels=pixels) if pixels is not None:
                self._shown, self._pixels = name, pixels
            case Capture():
                if self._shown not in self._seen:
                    self._seen[self._shown] = self._watched.shot(self._pixels)
                return picture_of("top", self._seen[self._shown])
            case ReadFeatures():
                return self._watched.camera.features()
            case ReadTool():
                x, y = CROSSES_MM[int(self._shown.removeprefix("cross ")) - 1].tolist()
                pose = Pose(x, y, PROFILE.heights.surface_mm, 180.0, 0.0, 180.0)
                return ToolReading(pose=pose, joints=JointPositions((0.0,) * 6))
            case StandAside():
                pass
            case _:
                raise AssertionError(f"asked for {type(request).__name__}")
        return None


@pytest.fixture(scope="module")
def hands() -> Hands:
    return Hands()


def calibrated(hands: Hands, answers: dict[str, Value | tuple[float, float]]) -> Measurement:
    asker = Answers({"cameras": "top", "touch deviation": 0.1, **answers})
    return play(screen(SITE), hands=hands, asker=asker, stop=StopToken())


def in_screen_frame(view: CameraView) -> CameraView:
    from_robot = screen_place(TRUTH).robot_from_screen().inverse()
    return CameraView(view.lens, from_robot @ view.robot_from_camera)


def corner_error_mm(found: Measurement) -> float:
    corner = (found.values["display.corner_x_mm"], found.values["display.corner_y_mm"])
    true = (TRUTH.display.corner_x_mm, TRUTH.display.corner_y_mm)
    return float(np.hypot(*(np.array(corner, np.float64) - true)))


def test_touched_crosses_tell_where_the_screen_lies(hands: Hands) -> None:
    found = calibrated(hands, {"way": "touch"})
    assert corner_error_mm(found) < 0.1
    assert found.accuracy.held_out_count == len(CROSS_PX)
    assert "not-tied-to-robot" not in codes(found)


def test_typed_crosses_tell_where_the_screen_lies_and_a_mistyped_one_is_named(
    hands: Hands,
) -> None:
    typed: dict[str, Value | tuple[float, float]] = {
        f"cross {index}": (float(x), float(y)) for index, (x, y) in enumerate(CROSSES_MM, 1)
    }
    assert corner_error_mm(calibrated(hands, {"way": "type", **typed})) < 0.1
    x, y = CROSSES_MM[1].tolist()
    wrong = calibrated(hands, {"way": "type", **typed, "cross 2": (x + 5.0, y)})
    named = [finding for finding in wrong.findings if finding.code == "misplaced-point"]
    assert [finding.samples for finding in named] == [("cross 2",)]


def test_blocks_that_no_camera_finds_are_told() -> None:
    class NothingThere:
        def perform(self, request: Request) -> Answer:
            if isinstance(request, Capture):
                return picture_of("top", np.full((960, 1280, 3), 20, np.uint8))
            return request.place if isinstance(request, PutBlock) else None

    def only_blocks() -> Procedure:
        panel = Panel(width_px=1920, height_px=1080)
        alone = {"top": in_screen_frame(true_view(TRUTH))}
        ties = yield from tied_by_blocks(SITE, PROFILE, panel, alone, 6)
        return Measurement(kind="screen", subject="cell", method="", findings=ties.findings)

    found = play(only_blocks(), hands=NothingThere(), asker=Answers({}), stop=StopToken())
    assert found.grade is Grade.BAD
    assert found.findings[-1].code == "blocks-not-found"
    assert "0 of 6" in found.findings[-1].text
