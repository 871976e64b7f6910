"""Camera settings by a reference picture from random starts.

Each run has other lamps (level 50 to 150 %, red and blue 80 to 125 % against green), other
blocks on the table, and shutter, gain and white balance anywhere. The reference is a picture
from a cell where all was right. Errors are means over all bright patches of the picture and
the channels, arm aside, with the reference's blocks on the table again.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Result
from calibration.camera_settings.procedure import camera_settings
from calibration.catalogue import Site
from calibration.hands import CellHands
from calibration.pictures import picture_of_frame
from calibration.player import play
from calibration.requests import Answer, Ask, Capture, Picture, Point, ReadPicture, Request
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile, load_profile
from cell.stop import StopToken
from cell.store import StorePlan, StoreSlot
from cell.twin_cell import TwinCell
from cell.vision.picture_measures import patches

STARTS = 100
_COLOURS = ("red", "green", "blue", "yellow", "natural")
_PLACES = ((360.0, -250.0), (470.0, -90.0), (590.0, 60.0), (400.0, 200.0), (640.0, -280.0))
_PLAN = StorePlan(
    tuple(
        StoreSlot(number=i + 1, kind="cube", colour=c, x_mm=165.0, y_mm=50.0 + 60.0 * i)
        for i, c in enumerate(_COLOURS)
    )
)

Pixels = NDArray[np.uint8]


class _Player:
    """Hands and answers of one run."""

    def __init__(self, cell: TwinCell, reference: Pixels) -> None:
        self._cell = cell
        self._reference = reference
        self._hands = CellHands(lambda: cell)
        self.pictures = 0

    def perform(self, request: Request) -> Answer:
        if isinstance(request, ReadPicture):
            return Picture(camera=request.path, pixels=self._reference, digest="0" * 64)
        if isinstance(request, Capture):
            self.pictures += request.label.startswith("settings")
            return picture_of_frame(self._cell.grab(request.camera))
        return self._hands.perform(request)

    def answer(self, ask: Ask) -> Answer:
        return "right.png" if ask.key == "reference" else ask.default

    def point(self, point: Point) -> Answer:
        raise ValueError(f"nobody points at {point.key}")


def run(starts: int = STARTS, first_seed: int = 0) -> list[Result]:
    """Return errors and pictures over random starts."""
    profile = load_profile("mash")
    right = _cell(profile, profile)
    wanted = _look(right, _PLACES)
    seeds = range(first_seed, first_seed + starts)
    outcomes = [_one(profile, wanted, seed) for seed in seeds]
    errors, pictures, failed = (np.array(column) for column in zip(*outcomes, strict=True))
    worst = first_seed + int(errors.argmax())
    print(f"camera_settings: worst seed {worst}, {errors.max():.2f} levels", file=sys.stderr)
    return [
        Result(
            name=f"mean colour error, worst of {starts} starts",
            value=float(errors.max()),
            unit="levels",
            target=3.0,
            target_is="at most",
        ),
        Result(name="median of them", value=float(np.median(errors)), unit="levels"),
        Result(
            name="pictures, most of a start",
            value=float(pictures.max()),
            unit="",
            target=20.0,
            target_is="at most",
        ),
        Result(name="pictures, median", value=float(np.median(pictures)), unit=""),
        Result(name="starts with a bad verdict", value=float(failed.sum()), unit=""),
    ]


def _one(profile: Profile, wanted: Pixels, seed: int) -> tuple[float, float, float]:
    random = np.random.default_rng(seed)
    light = profile.twin.light.model_copy(
        update={
            "level": float(random.uniform(0.5, 1.5)),
            "red": float(random.uniform(0.8, 1.25)),
            "blue": float(random.uniform(0.8, 1.25)),
        }
    )
    truth = profile.model_copy(update={"twin": profile.twin.model_copy(update={"light": light})})
    cell = _cell(profile, truth)
    camera = cell.cameras["top"]
    camera.set_absolute("shutter", float(np.exp(random.uniform(0.0, np.log(500.0)))))
    camera.set_absolute("gain", float(random.uniform(-6.0, 20.0)))
    camera.set_raw("white_balance_red", int(random.uniform(250, 1000)))
    camera.set_raw("white_balance_blue", int(random.uniform(350, 1000)))
    _lay(cell, random.permutation(_PLACES) + random.uniform(-20.0, 20.0, (5, 2)))
    player = _Player(cell, wanted)
    site = Site(profile=profile, plan=_PLAN, current=())
    found = play(camera_settings(site), hands=player, asker=player, stop=StopToken())
    seen, right = (patches(p).means for p in (_look(cell, _PLACES), wanted))
    error = np.abs(seen - right)[right.max(axis=2) > 30.0].mean()
    cell.dispose()
    return float(error), float(player.pictures), float(found.grade.severity == 2)


def _cell(profile: Profile, truth: Profile) -> TwinCell:
    cell = assemble_twin(profile, _PLAN, seed=1, clock=SimulatedClock(), truth=truth)
    cell.open()
    return cell


def _lay(cell: TwinCell, places: NDArray[np.float64]) -> None:
    """Lay the blocks out as a person would, who is faster than the arm."""
    surface_mm = cell.profile.heights.surface_mm
    known = {block.block: block for block in cell.world.whereabouts()}
    for slot, (x_mm, y_mm) in zip(_PLAN.slots, places, strict=True):
        moved = replace(
            known[slot.block], x_mm=float(x_mm), y_mm=float(y_mm), z_mm=surface_mm, yaw_deg=0.0
        )
        cell.world.blocks.put(moved)


def _look(cell: TwinCell, places: tuple[tuple[float, float], ...]) -> Pixels:
    _lay(cell, np.array(places))
    cell.arm.rest()
    cell.show("black")
    return cell.grab("top").pixels
