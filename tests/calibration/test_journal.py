"""A run that was interrupted anywhere goes on to the same end."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from calibration.answers import Given, GivenAnswers
from calibration.errors import AnswerRefused, JournalError
from calibration.journal import RunJournal, request_digest
from calibration.pictures import picture_of
from calibration.player import play
from calibration.procedure import (
    Procedure,
    ask_number,
    capture,
    light,
    move_tool,
    put_block,
    read_features,
    read_tool,
    return_block,
    set_absolute,
    show,
    stand_aside,
    tell,
)
from calibration.record import Measurement, Sample
from calibration.requests import (
    Answer,
    Ask,
    Capture,
    Light,
    MoveTool,
    PutBlock,
    ReadFeatures,
    ReadTool,
    Request,
    SetFeature,
    Show,
    ToolReading,
)
from calibration.standing import Standing
from cell.devices.camera import CameraSettings
from cell.devices.camera_features import CameraFeature
from cell.geometry import JointPositions, Pose
from cell.stop import StopToken
from cell.store import TablePlace

SETTINGS = CameraSettings(shutter_ms=16.02, gain_db=-4.0, white_balance_red=1, white_balance_blue=2)
SHUTTER = CameraFeature(
    name="shutter", unit="ms", raw_range=None, absolute_range=(0.1, 200.0), absolute=16.02
)
ORIGIN = {"the procedure": "everything", "the profile": "a"}


class Killed(BaseException):
    """Ends the program, as SIGKILL would."""


class FakeHands:
    """Answers everything; ends the program at the nth request."""

    def __init__(self, killed_at: int | None = None) -> None:
        self.done: list[Request] = []
        self._killed_at = killed_at

    def perform(self, request: Request) -> Answer:
        if len(self.done) == self._killed_at:
            raise Killed
        self.done.append(request)
        match request:
            case Capture():
                generator = np.random.default_rng(sum(request.label.encode()))
                pixels = generator.integers(0, 255, (6, 8, 3)).astype(np.uint8)
                return picture_of(request.camera, pixels, SETTINGS)
            case PutBlock():
                return request.place
            case ReadTool():
                return ToolReading(
                    pose=Pose(1.5, 2.0, 3.0), joints=JointPositions((1.0, 0.1 + 0.2))
                )
            case MoveTool():
                return ToolReading(pose=request.pose, joints=JointPositions((4.0,)))
            case ReadFeatures():
                return (SHUTTER,)
            case SetFeature():
                return SHUTTER
            case _:
                return None


def everything() -> Procedure:
    """Ask for everything once, and remember all of it in the result."""
    seen: list[str] = []
    width = yield from ask_number("width", "How wide?")
    seen.append(repr(width))
    yield from light(is_on=True)
    yield from show("white")
    for step in range(3):
        yield from tell("a step", step, 3)
        place = TablePlace(x_mm=400.0 + 0.1 * step, y_mm=0.0, yaw_deg=5.0)
        seen.append(repr((yield from put_block(7, place))))
        yield from stand_aside()
        picture = yield from capture("top", f"step {step}")
        seen.append(picture.digest)
        seen.append(repr((picture.settings, float(picture.pixels.mean()))))
    yield from show("stripes", np.full((1080, 1920, 3), 7, np.uint8))
    seen.append(repr((yield from read_features("top"))))
    seen.append(repr((yield from set_absolute("top", "shutter", 16.02))))
    seen.append(repr((yield from read_tool())))
    seen.append(repr((yield from move_tool(Pose(400.0, 0.0, 200.0)))))
    yield from return_block(7)
    height = yield from ask_number("height", "How high?")
    return Measurement(
        kind="x",
        subject="x",
        method="everything",
        samples=tuple(Sample(label=one) for one in seen),
        details={"height": height},
    )


def run(
    folder: Path,
    *,
    killed_at: int | None = None,
    resume: bool = False,
    restore: Callable[[Standing], None] = lambda standing: None,
    origin: dict[str, str] | None = None,
) -> tuple[Measurement, FakeHands]:
    journal = RunJournal(folder, origin or ORIGIN)
    if resume:
        journal.go_on()
    else:
        journal.begin()
    hands = FakeHands(killed_at)
    asker = GivenAnswers({"width": Given(0.1, "x"), "height": Given(3, "x")})
    measured = play(
        everything(), hands=hands, asker=asker, stop=StopToken(), journal=journal,
        restore=restore,
    )  # fmt: skip
    return measured, hands


def uninterrupted(tmp_path: Path) -> tuple[Measurement, int]:
    measured, hands = run(tmp_path / "whole")
    return measured, len(hands.done)


def test_killed_before_any_request_a_run_goes_on_to_the_same_end(tmp_path: Path) -> None:
    whole, requests = uninterrupted(tmp_path)
    assert requests > 15
    for nth in range(requests):
        folder = tmp_path / str(nth)
        with pytest.raises(Killed):
            run(folder, killed_at=nth)
        again, hands = run(folder, resume=True)
        assert again == whole
        assert len(hands.done) == requests - nth


@pytest.mark.parametrize("seed", range(5))
def test_killed_again_and_again_it_still_comes_to_the_same_end(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    whole, _ = uninterrupted(tmp_path)
    resume = False
    for _ in range(100):
        try:
            again, _ = run(tmp_path / "run", killed_at=chance.randint(0, 4), resume=resume)
        except Killed:
            resume = True
            continue
        break
    assert resume
    assert again == whole


def cut_short(folder: Path) -> Iterator[bytes]:
    """Yield every beginning of the notes, as a program that dies while it writes leaves them."""
    data = (folder / "answers.jsonl").read_bytes()
    for length in range(0, len(data), 97):
        yield data[:length]


def test_notes_that_were_cut_short_anywhere_are_gone_on_with(tmp_path: Path) -> None:
    whole, requests = uninterrupted(tmp_path)
    folder = tmp_path / "run"
    with pytest.raises(Killed):
        run(folder, killed_at=requests - 1)
    beginnings = list(cut_short(folder))
    assert len(beginnings) > 12
    for data in beginnings:
        (folder / "answers.jsonl").write_bytes(data)
        again, hands = run(folder, resume=True)
        assert again == whole
        # The notes are whole again, so that they could be gone on with once more.
        assert RunJournal(folder, ORIGIN).exists


def test_what_the_screen_showed_and_where_the_block_lay_is_brought_about_again(
    tmp_path: Path,
) -> None:
    with pytest.raises(Killed):
        run(tmp_path / "run", killed_at=7)
    restored: list[object] = []

    def restore(standing: Standing) -> None:
        restored.extend(put.place.x_mm for put in standing.blocks)
        restored.extend(type(request).__name__ for request in standing.others())

    run(tmp_path / "run", resume=True, restore=restore)
    # Seven were answered: light, picture, block, aside, capture, block, aside.
    assert restored == [400.1, "Light", "Show", "StandAside"]


def test_a_run_that_was_not_interrupted_restores_nothing(tmp_path: Path) -> None:
    restored: list[Standing] = []
    run(tmp_path / "run", restore=restored.append)
    assert restored == []


@pytest.mark.parametrize("name", ["the procedure", "the profile", "the store"])
def test_a_run_does_not_go_on_where_what_it_depends_on_changed(tmp_path: Path, name: str) -> None:
    with pytest.raises(Killed):
        run(tmp_path / "run", killed_at=5)
    with pytest.raises(JournalError, match=f"{name} changed since"):
        run(tmp_path / "run", resume=True, origin={**ORIGIN, name: "b"})


def test_a_procedure_that_asks_something_else_now_does_not_go_on(tmp_path: Path) -> None:
    with pytest.raises(Killed):
        run(tmp_path / "run", killed_at=5)
    journal = RunJournal(tmp_path / "run", ORIGIN)
    journal.go_on()
    with pytest.raises(JournalError, match="step 1 asks for something else"):
        journal.recall(Ask(key="other", question="?", kind="number"))


def test_there_is_nothing_to_go_on_with_before_the_first_run(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match="no interrupted run"):
        run(tmp_path / "run", resume=True)


@pytest.mark.parametrize("line", [b"nonsense\n", b"3\n", b'["x", {"picture": 4}]\n'])
def test_damaged_notes_are_told(tmp_path: Path, line: bytes) -> None:
    with pytest.raises(Killed):
        run(tmp_path / "run", killed_at=5)
    (tmp_path / "run" / "answers.jsonl").write_bytes(line)
    with pytest.raises(JournalError, match="start the run anew|start it anew"):
        run(tmp_path / "run", resume=True)


def test_a_damaged_picture_is_told(tmp_path: Path) -> None:
    with pytest.raises(Killed):
        run(tmp_path / "run", killed_at=9)
    for png in (tmp_path / "run").glob("*.png"):
        png.write_bytes(b"no picture")
    with pytest.raises(JournalError, match="damaged"):
        run(tmp_path / "run", resume=True)


def test_a_finished_run_leaves_nothing_when_its_notes_are_thrown_away(tmp_path: Path) -> None:
    run(tmp_path / "run")
    journal = RunJournal(tmp_path / "run", ORIGIN)
    assert journal.exists
    journal.remove()
    assert not (tmp_path / "run").exists()
    journal.remove()


def test_requests_differ_by_what_they_ask() -> None:
    stripes = np.zeros((2, 2, 3), np.uint8)
    asked: list[Request] = [
        Light(is_on=True), Light(is_on=False), Show(name="white"),
        Show(name="x", pixels=stripes), Show(name="x", pixels=stripes + np.uint8(1)),
        Capture(camera="top", label="a"), Capture(camera="top", label="b"),
    ]  # fmt: skip
    assert len({request_digest(one) for one in asked}) == len(asked)
    one, other = MoveTool(pose=Pose(400, 0, 200)), MoveTool(pose=Pose(400.0, 0.0, 200.0))
    assert request_digest(one) == request_digest(other)
    assert request_digest(asked[3]) == request_digest(Show(name="x", pixels=stripes.copy()))


def test_an_answer_of_the_wrong_kind_is_refused_by_name(tmp_path: Path) -> None:
    class Wrong:
        def answer(self, ask: Ask) -> Answer:
            return "wide"

        def point(self, point: object) -> Answer:
            return None

    with pytest.raises(AnswerRefused, match="^width: a number is expected"):
        play(everything(), hands=FakeHands(), asker=Wrong(), stop=StopToken())
