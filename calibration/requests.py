"""What a procedure may ask for. Whoever plays it answers each request before it goes on.

A procedure knows no device and nobody at a keyboard: console, tests and a replay answer
alike.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cell.devices.camera import CameraSettings
from cell.devices.camera_features import CameraFeature, FeatureName
from cell.geometry import JointPositions, Pose
from cell.store import TablePlace

Value: TypeAlias = bool | float | str | tuple[float, ...]
"""What may be answered to a question."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ask:
    """A question to a person, an answers file or a test; answered with a `Value`.

    Attributes:
        key: Its name in an answers file; no two questions of a run have the same.
        question: What is asked, a sentence.
        kind: `number` (float), `text`, `yes` (bool), `choice` (one of `choices`), `numbers`
            (floats), or `done` (True as soon as a person has done what the question says).
        unit: Unit of numbers.
        choices: What may be chosen.
        count: How many numbers `numbers` needs; 0 for any.
        default: Taken where nothing is answered; None if an answer is needed.
    """

    key: str
    question: str
    kind: Literal["number", "text", "yes", "choice", "numbers", "done"]
    unit: str = ""
    choices: tuple[str, ...] = ()
    count: int = 0
    default: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """Asks a person to point at something in a picture; answered with (u_px, v_px).

    Attributes:
        key: Its name in an answers file.
        question: What to point at.
        picture: The picture.
        guess_px: Where it probably is, None if nobody knows.
    """

    key: str
    question: str
    picture: Picture
    guess_px: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Tell:
    """Says something; answered with None.

    Attributes:
        text: What to say.
        done: How far the procedure is; 0 of 0 where nobody knows.
        total: How far it goes.
    """

    text: str
    done: int = 0
    total: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Show:
    """Shows a picture on the screen under the playground; answered with None when it is on.

    Attributes:
        name: A picture of `cell.pictures`, or what `pixels` are called.
        pixels: A picture (1080, 1920, 3), uint8, R G B; None for one known by its name.
    """

    name: str
    pixels: NDArray[np.uint8] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """Switches the cell's lights; answered with None."""

    is_on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """Takes a new picture (1280 x 960); answered with a `Picture`.

    Attributes:
        camera: Name of the camera.
        label: What the picture is of, for people.
    """

    camera: str
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PutBlock:
    """Has the arm bring a block of the store to a place; answered with the `TablePlace`.

    The first time it is fetched from its slot, later from where it lies; the arm stays over
    it.

    Attributes:
        slot: Number of its slot.
        place: Where to put it down.
    """

    slot: int
    place: TablePlace


@dataclass(frozen=True, slots=True, kw_only=True)
class ReturnBlock:
    """Has the arm bring a block home to its slot; answered with None."""

    slot: int


@dataclass(frozen=True, slots=True)
class StandAside:
    """Has the arm go where it hides nothing; answered with None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveTool:
    """Has the arm move its tool point, through the guard; answered with a `ToolReading`.

    Attributes:
        pose: Where to.
        by_joints: Whether every joint goes straight to its end, which turns the hand far
            without running into a joint's end on the way; else in a line where that can be.
    """

    pose: Pose
    by_joints: bool = False


@dataclass(frozen=True, slots=True)
class ReadTool:
    """Reads where the tool point is, perhaps brought there by a person; `ToolReading`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadFeatures:
    """Reads all features of a camera; answered with a tuple of `CameraFeature`."""

    camera: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SetFeature:
    """Sets a feature of a camera by hand; answered with the `CameraFeature` read back.

    Exactly one of `absolute` and `raw` is given.
    """

    camera: str
    feature: FeatureName
    absolute: float | None = None
    raw: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadPicture:
    """Reads a picture from a file; answered with a `Picture`."""

    path: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """A picture that was taken.

    Attributes:
        camera: Name of the camera, or the file it was read from.
        pixels: Shape (height, width, 3), uint8, R G B.
        digest: SHA-256 of shape and pixels: its name among the kept pictures.
        settings: The settings it was taken with; None from a file.
    """

    camera: str
    pixels: NDArray[np.uint8] = field(repr=False)
    digest: str
    settings: CameraSettings | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolReading:
    """Where the arm is.

    Attributes:
        pose: Of the tool point, robot frame.
        joints: Of the arm.
    """

    pose: Pose
    joints: JointPositions


Request: TypeAlias = (
    Ask | Point | Tell | Show | Light | Capture | PutBlock | ReturnBlock | StandAside | MoveTool
    | ReadTool | ReadFeatures | SetFeature | ReadPicture
)  # fmt: skip
Answer: TypeAlias = (
    Value | Picture | TablePlace | ToolReading | CameraFeature | tuple[CameraFeature, ...] | None
)
