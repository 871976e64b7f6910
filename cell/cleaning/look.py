"""One look at the playground: pictures on a white and a black screen, and what they tell.

The only place that knows how blocks are recognised.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cell.cleaning.pushes import Field
from cell.cleaning.sight import LyingBlock, Playground, StrangeThing, body_of
from cell.contact import Outline
from cell.devices.camera import Frame
from cell.errors import VisionError
from cell.profile import Profile
from cell.vision.learned import recognition_model
from cell.vision.recognition import Recognition, TwoPictures, UnknownThing, recognise
from cell.vision.sight import TableSight
from cell.vision.viewpoints import mapped_cameras

_LEAST_DEVIATION_MM = 0.4
"""Lens, calibration and placement leave this, however well one picture is fitted (assumed)."""
_LEAST_DEVIATION_DEG = 0.5
_LEAST_INSIDE_MM = 10.0
_PIECE_MM = 8.0


class Eyes(Protocol):
    """What finding blocks by camera needs."""

    def switch_lights(self, *, is_on: bool) -> None:
        """Switch the lights."""

    def shown(self) -> str:
        """Return the name of the picture under the playground."""

    def show(self, picture: str) -> None:
        """Show a picture under the playground."""

    def grab(self, camera: str) -> Frame:
        """Return a picture of a camera."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """A look at the playground.

    Attributes:
        playground: What lies there.
        black: The picture on the black screen, R G B (960, 1280, 3), uint8.
        recognition: What the vision found in it.
    """

    playground: Playground
    black: NDArray[np.uint8]
    recognition: Recognition


def seeing_camera(profile: Profile) -> str:
    """Return the camera that sees the playground best of those mapped to it.

    Raises:
        VisionError: No camera of the profile is.
    """
    mapped = mapped_cameras(profile)
    if mapped:
        return mapped[0]
    raise VisionError(
        "no camera of the profile is mapped to the table (plane_map, or lens and place); "
        "calibrate the top camera first"
    )


def look(profile: Profile, eyes: Eyes) -> Look:
    """Look at the playground; the arm stands aside.

    Raises:
        VisionError: No camera is mapped to the table, or screen or lights are off.
        DeviceError: Screen, lights or camera fail.
    """
    camera = seeing_camera(profile)
    eyes.switch_lights(is_on=True)
    eyes.show("white")
    white = eyes.grab(camera).pixels
    eyes.show("black")
    black = eyes.grab(camera).pixels
    sight = TableSight.of_profile(profile, camera)
    model = recognition_model(profile, camera)
    found = recognise(TwoPictures(white, black), sight, model)
    blocks = tuple(
        LyingBlock(
            kind=block.kind,
            colour=block.colour,
            body=body_of(profile.blocks, block.kind, block.x_mm, block.y_mm, block.angle_deg),
            deviation_mm=max(block.deviation_mm, _LEAST_DEVIATION_MM),
            deviation_deg=max(block.deviation_deg, _LEAST_DEVIATION_DEG),
        )
        for block in found.blocks
    )
    strange = [_strange(thing, sight) for thing in found.unknown]
    playground = Playground(blocks=blocks, strange=tuple(one for one in strange if one))
    return Look(playground=playground, black=black, recognition=found)


def _strange(thing: UnknownThing, sight: TableSight) -> StrangeThing | None:
    """Return something unknown, None when all of it is beyond the screen, such as its frame."""
    corners = sight.view.to_robot(thing.outline_px, sight.top_mm)
    screen = Field(corners=tuple(sight.panel_mm[::-1]))
    if min(screen.outside_mm(float(x), float(y)) for x, y in corners) > -_LEAST_INSIDE_MM:
        return None
    return StrangeThing(
        reason=thing.reason,
        x_mm=thing.x_mm,
        y_mm=thing.y_mm,
        edge=tuple(_edge(corners)),
        corners=tuple((float(x), float(y)) for x, y in corners),
    )


def _edge(corners: NDArray[np.float64]) -> Iterator[Outline]:
    """Yield squares that cover a closed line."""
    half = 0.75 * _PIECE_MM
    for start, end in zip(np.roll(corners, 1, axis=0), corners, strict=True):
        count = max(1, math.ceil(float(np.linalg.norm(end - start)) / _PIECE_MM))
        for step in range(count):
            x, y = (start + (end - start) * step / count).tolist()
            yield Outline(
                ((x + half, y + half), (x - half, y + half), (x - half, y - half),
                 (x + half, y - half))
            )  # fmt: skip
