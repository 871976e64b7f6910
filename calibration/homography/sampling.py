"""Takes one pair: the object at a robot point, its centre in a picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.homography.finding import Seen, against_empty, dark_room, find_object, on_screen
from calibration.homography.knowledge import CameraKnowledge, TableFit, expected_of, view_of
from calibration.procedure import (
    Steps,
    ask_done,
    capture,
    light,
    put_block,
    show,
    stand_aside,
)
from calibration.requests import Picture
from calibration.verdict import Finding
from cell.store import TablePlace

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """A robot point and where it was seen.

    Attributes:
        label: Its name.
        point_mm: Robot x, y.
        pixel: Picture u, v.
        seen: How its centre was found; None if a person pointed at it.
        picture: Digest of the picture it was found in.
        levels: What it was found in, to look again when more is known.
        still: The picture in grey at half its size, to see whether the camera stands still.
        still_scale: How many px of the picture one of `still` is.
        findings: What is wrong with the picture.
    """

    label: str
    point_mm: tuple[float, float]
    pixel: tuple[float, float]
    seen: Seen | None
    picture: str
    levels: NDArray[np.float32] | None
    still: NDArray[np.float32] | None = None
    still_scale: float = 2.0
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampler:
    """How pairs are taken in this run.

    Attributes:
        known: The camera.
        radius_mm: Radius of the object's upper face.
        slot: Number of the object's slot, for the arm; None where a person places it.
        with_screen: Whether the screen can be lit; else pictures are held against the one of
            the empty table.
        empty: That picture.
    """

    known: CameraKnowledge
    radius_mm: float
    slot: int | None
    with_screen: bool
    empty: Picture | None = None

    def take(self, label: str, at_mm: tuple[float, float]) -> Steps[Pair]:
        """Have the object put at a point and find it.

        Raises:
            ObjectNotFound: It cannot be measured.
        """
        place = at_mm
        if self.slot is None:
            yield from ask_done(
                f"place {label}",
                f"Put the calibration object at robot x {at_mm[0]:g} mm, y {at_mm[1]:g} mm, and "
                "step aside",
            )
        else:
            wanted = TablePlace(x_mm=at_mm[0], y_mm=at_mm[1], yaw_deg=0.0)
            there = yield from put_block(self.slot, wanted)
            place = (there.x_mm, there.y_mm)
            yield from stand_aside()
        return (yield from self.look(label, place))

    def look(self, label: str, at_mm: tuple[float, float]) -> Steps[Pair]:
        """Find the object, which stands at a point.

        Raises:
            ObjectNotFound: It cannot be measured.
        """
        camera = self.known.camera
        if self.with_screen:
            yield from show("white")
            white = yield from capture(camera, f"{label}, screen white")
            yield from show("black")
            picture = yield from capture(camera, f"{label}, screen black")
            levels = on_screen(white.pixels, picture.pixels)
            findings, scene = dark_room(picture.pixels), white
        else:
            picture = yield from capture(camera, label)
            empty = self.empty.pixels if self.empty is not None else picture.pixels
            levels = against_empty(picture.pixels, empty)
            findings, scene = (), picture
        expected = expected_of(self.known.before, at_mm, self.known.height_mm, self.radius_mm)
        seen = find_object(levels, expected)
        return Pair(
            label=label,
            point_mm=at_mm,
            pixel=(seen.u_px, seen.v_px),
            seen=seen,
            picture=picture.digest,
            levels=levels,
            still=_halved(scene.pixels),
            findings=findings,
        )

    def again(self, pair: Pair, fit: TableFit) -> Pair:
        """Return a pair measured once more, now that the view is known better.

        Raises:
            ObjectNotFound: It cannot be measured.
        """
        view = view_of(fit, self.known.height_mm)
        if pair.levels is None or view is None:
            return pair
        expected = expected_of(view, pair.point_mm, self.known.height_mm, self.radius_mm)
        seen = find_object(pair.levels, expected)
        return replace(pair, pixel=(seen.u_px, seen.v_px), seen=seen)


def prepared(sampler: Sampler) -> Steps[Sampler]:
    """Switch the light on; without a screen, take the picture of the empty table."""
    yield from light(is_on=True)
    if sampler.with_screen:
        return sampler
    if sampler.slot is not None:
        yield from stand_aside()
    else:
        yield from ask_done("empty", "Clear the playground, and step aside")
    empty = yield from capture(sampler.known.camera, "the empty table")
    return Sampler(
        known=sampler.known,
        radius_mm=sampler.radius_mm,
        slot=sampler.slot,
        with_screen=False,
        empty=empty,
    )


def _halved(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    return np.asarray(cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA),
                      np.float32)  # fmt: skip
