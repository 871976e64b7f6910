"""Procedures: generators that yield requests, receive answers and return a `Measurement`.

The functions here ask one thing each and give the answer in its own type, so that a
procedure reads like a recipe:

    width_mm = yield from ask_number("width", "How wide is the board?", unit="mm")
    picture = yield from capture("top", "the board")

A procedure's requests depend on nothing but the answers: played again with the same answers
it asks the same, which is how one that was interrupted goes on.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from calibration.errors import AnswerRefused, CalibrationError
from calibration.record import Measurement
from calibration.requests import (
    Answer,
    Ask,
    Capture,
    Light,
    MoveTool,
    Picture,
    Point,
    PutBlock,
    ReadFeatures,
    ReadPicture,
    ReadTool,
    Request,
    ReturnBlock,
    SetFeature,
    Show,
    StandAside,
    Tell,
    ToolReading,
)
from cell.devices.camera_features import CameraFeature, FeatureName
from cell.geometry import Pose
from cell.store import TablePlace

T = TypeVar("T")
Steps: TypeAlias = Generator[Request, Answer, T]
"""A part of a procedure that comes to a T."""
Procedure: TypeAlias = Steps[Measurement]


def ask_number(
    key: str, question: str, *, unit: str = "", default: float | None = None
) -> Steps[float]:
    """Ask for a number."""
    answer = yield Ask(key=key, question=question, kind="number", unit=unit, default=default)
    if isinstance(answer, bool) or not isinstance(answer, int | float):
        raise AnswerRefused(key, f"a number is expected, not {answer!r}")
    return float(answer)


def ask_whole(
    key: str, question: str, *, low: int, high: int, default: int | None = None
) -> Steps[int]:
    """Ask for a whole number from `low` to `high`."""
    standard = None if default is None else float(default)
    number = yield from ask_number(key, question, default=standard)
    if not number.is_integer() or not low <= number <= high:
        raise AnswerRefused(key, f"a whole number from {low} to {high} is expected, not {number:g}")
    return int(number)


def ask_within(
    key: str, question: str, *, low: float, high: float, unit: str = "", default: float
) -> Steps[float]:
    """Ask for a number above `low` (not `low` itself) and up to `high`."""
    number = yield from ask_number(key, question, unit=unit, default=default)
    if not low < number <= high:
        wanted = f"a number above {low:g} and up to {high:g} {unit}".rstrip()
        raise AnswerRefused(key, f"{wanted} is expected, not {number:g}")
    return number


def ask_numbers(
    key: str,
    question: str,
    *,
    count: int = 0,
    unit: str = "",
    default: Sequence[float] | None = None,
) -> Steps[tuple[float, ...]]:
    """Ask for several numbers, `count` of them unless it is 0."""
    standard = None if default is None else tuple(default)
    answer = yield Ask(
        key=key, question=question, kind="numbers", unit=unit, count=count, default=standard
    )
    if not isinstance(answer, tuple) or (count and len(answer) != count):
        wanted = f"{count} numbers are" if count else "numbers are"
        raise AnswerRefused(key, f"{wanted} expected, not {answer!r}")
    return tuple(float(value) for value in answer if isinstance(value, int | float))


def ask_yes(key: str, question: str, *, default: bool | None = None) -> Steps[bool]:
    """Ask a question that is answered with yes or no."""
    answer = yield Ask(key=key, question=question, kind="yes", default=default)
    if not isinstance(answer, bool):
        raise AnswerRefused(key, f"yes or no is expected, not {answer!r}")
    return answer


def ask_text(key: str, question: str, *, default: str | None = None) -> Steps[str]:
    """Ask for a text."""
    answer = yield Ask(key=key, question=question, kind="text", default=default)
    if not isinstance(answer, str):
        raise AnswerRefused(key, f"a text is expected, not {answer!r}")
    return answer


def ask_choice(
    key: str, question: str, choices: Sequence[str], *, default: str | None = None
) -> Steps[str]:
    """Ask which of several it shall be."""
    answer = yield Ask(
        key=key, question=question, kind="choice", choices=tuple(choices), default=default
    )
    if not isinstance(answer, str) or answer not in choices:
        raise AnswerRefused(key, f"one of {', '.join(choices)} is expected, not {answer!r}")
    return answer


def ask_done(key: str, what: str) -> Steps[None]:
    """Ask a person to do something, and go on when it is done."""
    yield Ask(key=key, question=what, kind="done")


def point_at(
    key: str, question: str, picture: Picture, guess_px: tuple[float, float] | None = None
) -> Steps[tuple[float, float]]:
    """Ask a person to point at something in a picture; return its u, v in px."""
    answer = yield Point(key=key, question=question, picture=picture, guess_px=guess_px)
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise AnswerRefused(key, f"u and v in px are expected, not {answer!r}")
    u_px, v_px = (float(value) for value in answer if isinstance(value, int | float))
    return u_px, v_px


def tell(text: str, done: int = 0, total: int = 0) -> Steps[None]:
    """Say something, and how far the procedure is."""
    yield Tell(text=text, done=done, total=total)


def show(name: str, pixels: NDArray[np.uint8] | None = None) -> Steps[None]:
    """Show a picture on the screen under the playground."""
    yield Show(name=name, pixels=pixels)


def light(*, is_on: bool) -> Steps[None]:
    """Switch the cell's lights."""
    yield Light(is_on=is_on)


def capture(camera: str, label: str) -> Steps[Picture]:
    """Take a new picture of 1280 x 960 pixels."""
    return _of(Picture, (yield Capture(camera=camera, label=label)))


def read_picture(path: str) -> Steps[Picture]:
    """Read a picture from a file."""
    return _of(Picture, (yield ReadPicture(path=path)))


def put_block(slot: int, place: TablePlace) -> Steps[TablePlace]:
    """Have the arm bring a block of the store to a place."""
    return _of(TablePlace, (yield PutBlock(slot=slot, place=place)))


def return_block(slot: int) -> Steps[None]:
    """Have the arm bring a block home."""
    yield ReturnBlock(slot=slot)


def stand_aside() -> Steps[None]:
    """Have the arm go where it hides nothing."""
    yield StandAside()


def move_tool(pose: Pose, *, by_joints: bool = False) -> Steps[ToolReading]:
    """Have the arm move its tool point, through the guard; see `MoveTool`."""
    return _of(ToolReading, (yield MoveTool(pose=pose, by_joints=by_joints)))


def read_tool() -> Steps[ToolReading]:
    """Read where the tool point is."""
    return _of(ToolReading, (yield ReadTool()))


def read_features(camera: str) -> Steps[tuple[CameraFeature, ...]]:
    """Read all features of a camera."""
    answer = yield ReadFeatures(camera=camera)
    return tuple(_of(CameraFeature, one) for one in _of(tuple, answer))


def set_absolute(camera: str, feature: FeatureName, value: float) -> Steps[CameraFeature]:
    """Set a feature's absolute value; return the feature as read back."""
    answer = yield SetFeature(camera=camera, feature=feature, absolute=value)
    return _of(CameraFeature, answer)


def set_raw(camera: str, feature: FeatureName, value: int) -> Steps[CameraFeature]:
    """Set a feature's raw value; return the feature as read back."""
    answer = yield SetFeature(camera=camera, feature=feature, raw=value)
    return _of(CameraFeature, answer)


def _of(kind: type[T], answer: object) -> T:
    if not isinstance(answer, kind):
        raise CalibrationError(
            f"a request that needs {kind.__name__} was answered with {type(answer).__name__}"
        )
    return answer
