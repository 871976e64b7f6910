"""Twin cells whose light and camera are not as the profile says, and somebody who answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.errors import AnswerRefused
from calibration.hands import CellHands
from calibration.pictures import picture_of_frame
from calibration.player import play
from calibration.procedure import Procedure
from calibration.record import CalibrationRecord, Measurement, make_record
from calibration.requests import Answer, Ask, Capture, Picture, Point, ReadPicture, Request, Value
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile, load_profile
from cell.stop import StopToken
from cell.store import StorePlan, StoreSlot
from cell.twin.cameras import TwinCamera
from cell.twin_cell import TwinCell

PROFILE: Profile = load_profile("mash")
COLOURS = ("red", "green", "blue", "yellow", "natural")
KINDS = ("cube", "cylinder", "bridge")
PLAN = StorePlan(
    tuple(
        StoreSlot(
            number=1 + 3 * row + column,
            kind=KINDS[column],
            colour=COLOURS[row],
            x_mm=80.0 + 130.0 * column,
            y_mm=40.0 + 60.0 * row,
        )
        for row in range(5)
        for column in range(3)
    )
)
Pixels = NDArray[np.uint8]


@dataclass
class Answers:
    """Answers by key, defaults for the rest."""

    given: Mapping[str, Value]
    asked: list[str] = field(default_factory=list)

    def answer(self, ask: Ask) -> Answer:
        """Return what was given, else the default."""
        self.asked.append(ask.key)
        value = self.given.get(ask.key, ask.default)
        if value is None:
            raise AnswerRefused(ask.key, "is not answered")
        return value

    def point(self, point: Point) -> Answer:
        """Return nothing: nobody points here."""
        raise AnswerRefused(point.key, "nobody points")


@dataclass
class Bench:
    """A twin cell, its hands, and what they read as files."""

    profile: Profile = PROFILE
    truth: Profile | None = None
    files: dict[str, Pixels] = field(default_factory=dict)
    pictures: int = 0
    seen: dict[str, Pixels] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.cell: TwinCell = assemble_twin(
            self.profile, PLAN, seed=1, clock=SimulatedClock(), truth=self.truth
        )
        self.hands = CellHands(lambda: self.cell)

    def camera(self, name: str = "top") -> TwinCamera:
        """Return a camera of the cell."""
        camera = self.cell.cameras[name]
        assert isinstance(camera, TwinCamera)
        return camera

    def perform(self, request: Request) -> Answer:
        """Do what is asked; every picture is a new one."""
        if isinstance(request, ReadPicture):
            pixels = self.files[request.path]
            return Picture(camera=request.path, pixels=pixels, digest="0" * 64)
        if isinstance(request, Capture):
            self.pictures += 1
            self.cell.open()
            self.cell.grab(request.camera)
            frame = self.camera(request.camera).grab_fresh()
            self.seen[request.label] = frame.pixels
            return picture_of_frame(frame)
        return self.hands.perform(request)

    def look(self, name: str = "top", screen: str = "black") -> Pixels:
        """Return a picture with the arm out of view."""
        self.cell.open()
        self.cell.arm.rest()
        self.cell.show(screen)
        self.cell.grab(name)
        return self.camera(name).grab_fresh().pixels

    def run(self, procedure: Procedure, **given: Value) -> Measurement:
        """Play a procedure; camera settings by a reference unless another method is given."""
        answers = {"method": "reference", **given}
        return play(procedure, hands=self, asker=Answers(answers), stop=StopToken())

    def site(self, *records: CalibrationRecord) -> Site:
        """Return what procedures know beforehand."""
        return Site(profile=self.profile, plan=PLAN, current=records)


def lit(
    level: float = 1.0,
    red: float = 1.0,
    blue: float = 1.0,
    *,
    flicker: float = 0.0,
    profile: Profile = PROFILE,
) -> Profile:
    """Return a profile whose lamps are others."""
    light = profile.twin.light.model_copy(
        update={"level": level, "red": red, "blue": blue, "flicker": flicker}
    )
    return profile.model_copy(update={"twin": profile.twin.model_copy(update={"light": light})})


def recorded(measurement: Measurement) -> CalibrationRecord:
    """Return a measurement as a record."""
    return make_record(
        measurement,
        cell="mash",
        measured_at=datetime(2026, 1, 2, tzinfo=UTC),
        versions={},
        answers={},
    )


def codes(measurement: Measurement) -> set[str]:
    """Return the names of what was found."""
    return {finding.code for finding in measurement.findings}


def turn_at_random(camera: TwinCamera, random: np.random.Generator) -> None:
    """Put shutter, gain and white balance anywhere."""
    camera.set_absolute("shutter", float(np.exp(random.uniform(np.log(1.0), np.log(500.0)))))
    camera.set_absolute("gain", float(random.uniform(-6.0, 20.0)))
    camera.set_raw("white_balance_red", int(random.uniform(250, 1000)))
    camera.set_raw("white_balance_blue", int(random.uniform(350, 1000)))
