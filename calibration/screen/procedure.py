"""The procedure `screen`: all cameras that stand still, and the screen's place, without paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from calibration.catalogue import Site
from calibration.drift.check import DotReference, measured_reference
from calibration.drift.dots import dots
from calibration.errors import CalibrationError
from calibration.procedure import (
    Procedure,
    Steps,
    ask_choice,
    ask_number,
    ask_text,
    capture,
    read_features,
    show,
    stand_aside,
    tell,
)
from calibration.record import Measurement
from calibration.requests import Picture
from calibration.screen import board, judge
from calibration.screen.camera_model import LensPrior, fit_alone
from calibration.screen.decode import (
    AxisReading,
    Correspondences,
    ScreenMap,
    both_axes,
    correspondences,
    read_axis,
)
from calibration.screen.joint_fit import (
    LEAST_DEVIATION_PX,
    Observations,
    ScreenFit,
    ScreenPlace,
    fit_screen,
)
from calibration.screen.patterns import AXES, RAMP, STEPS, Panel
from calibration.screen.response import read_response
from calibration.screen.result import KIND, METHOD, measurement
from calibration.screen.tying import (
    Ties,
    ask_block_count,
    no_ties,
    tied_by_blocks,
    tied_by_touch,
    ways,
)
from calibration.verdict import Finding, Grade, worst
from cell.geometry import CameraView
from cell.profile import Profile

Pixels = NDArray[np.uint8]

_TRUST_MM: Final = 5.0
_TRUST_DEG: Final = 0.5
"""How far the profile's place of the screen may be off where nothing ties it to the robot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seen:
    """What patterns told.

    Attributes:
        panel: The grey values used.
        maps: The screen's places in each camera's picture.
        found: The same as correspondences.
        findings: What is wrong.
        pictures: Digest of a picture of each camera.
    """

    panel: Panel
    maps: Mapping[str, ScreenMap]
    found: Mapping[str, Correspondences]
    findings: tuple[Finding, ...]
    pictures: Mapping[str, str]


def screen(site: Site) -> Procedure:
    """Calibrate lens and place of every camera that stands still, and the screen's place.

    Raises:
        CalibrationError: The cell has no screen or no such camera.
        FitFailed: A camera sees too little of the screen.
    """
    profile = site.profile
    if not isinstance(profile, Profile) or not profile.display.enabled:
        raise CalibrationError(f"the cell {profile.name} has no screen to calibrate with")
    cameras = yield from _which_cameras(profile)
    way = yield from ask_choice(
        "way",
        "How is the screen tied to the robot: by blocks that the arm places, by points of the "
        "screen that its tool touches, by typed ones, or not at all?",
        ways(site),
        default=ways(site)[0],
    )
    count = 0
    if way == "blocks":
        count = yield from ask_block_count()
    priors = yield from _known_of_lenses(cameras)
    findings: list[Finding] = []
    for camera in cameras:
        findings += judge.judge_features(camera, (yield from read_features(camera)))
    if profile.arm.enabled:
        yield from stand_aside()
    seen = yield from _patterns(profile, cameras)
    findings += seen.findings
    if worst(findings) is Grade.BAD:
        return _failed(findings)
    lone = _alone(profile, seen, priors)
    if way == "blocks":
        ties = yield from tied_by_blocks(site, profile, seen.panel, lone, count)
    elif way in ("touch", "type"):
        ties = yield from tied_by_touch(profile, seen.panel, is_typed=way == "type")
    else:
        ties = no_ties()
    given = _observations(profile, seen.found, ties, priors)
    findings += ties.findings
    findings += judge.judge_scale(given, lone)
    if worst(findings) is Grade.BAD:
        return _failed(findings)
    yield from tell("working out lenses and places")
    fit = fit_screen(given)
    references = yield from _dot_references(profile, seen.panel, fit)
    return measurement(
        fit,
        panel=seen.panel,
        dots=references,
        findings=findings,
        pictures={**seen.pictures, **ties.pictures},
    )


def _which_cameras(profile: Profile) -> Steps[tuple[str, ...]]:
    still = [name for name, camera in profile.cameras.items() if camera.stands_still]
    if not still:
        raise CalibrationError(f"the cell {profile.name} has no camera that stands still")
    answer = yield from ask_text(
        "cameras",
        "Which of the cameras that stand still shall be calibrated (names with commas between)?",
        default=", ".join(still),
    )
    chosen = tuple(name.strip() for name in answer.split(",") if name.strip())
    unknown = [name for name in chosen if name not in profile.cameras]
    if unknown or not chosen:
        raise CalibrationError(
            f"there is no camera {', '.join(unknown) or 'named'}; there are {', '.join(still)}"
        )
    return chosen


def _known_of_lenses(cameras: tuple[str, ...]) -> Steps[dict[str, LensPrior]]:
    priors = {}
    for camera in cameras:
        height_mm = yield from ask_number(
            f"{camera} height",
            f"How high is the lens of camera {camera} over the glass, by tape? 0 if nobody "
            "measured",
            unit="mm",
            default=0.0,
        )
        priors[camera] = LensPrior(height_mm=height_mm if height_mm > 0.0 else None)
    return priors


def _patterns(profile: Profile, cameras: tuple[str, ...]) -> Steps[_Seen]:
    """Show all patterns; return what cameras see of them."""
    display = profile.display
    panel = Panel(width_px=display.width_px, height_px=display.height_px)
    fields: dict[int, dict[str, Pixels]] = {}
    for value in RAMP:
        fields[value] = yield from _look(f"grey {value}", panel.field(value), cameras)
    responses = [read_response(c, {v: fields[v][c] for v in RAMP}) for c in cameras]
    findings = [f for response in responses for f in response.findings]
    panel = replace(
        panel,
        bright=min(response.bright for response in responses),
        gamma=float(np.median([response.gamma for response in responses])),
    )
    first = yield from _pictures("board", panel.board(), cameras)
    boards = {c: board.find_board(first[c].pixels, panel) for c in cameras}
    for camera in cameras:
        findings += board.judge_board(camera, first[camera].pixels, boards[camera], panel)
    pictures = {camera: first[camera].digest for camera in cameras}
    if worst(findings) is Grade.BAD:
        return _Seen(panel=panel, maps={}, found={}, findings=tuple(findings), pictures=pictures)
    readings: dict[str, list[AxisReading]] = {camera: [] for camera in cameras}
    total = sum(STEPS + panel.bits(axis) for axis in AXES)
    done = 0
    for axis in AXES:
        shots: dict[str, list[Pixels]] = {camera: [] for camera in cameras}
        shown = [(f"{axis} sine {k}", panel.sine(axis, k)) for k in range(STEPS)]
        shown += [(f"{axis} code {k}", panel.code(axis, k)) for k in range(panel.bits(axis))]
        for name, pixels in shown:
            yield from tell(f"pattern: {name}", done, total)
            done += 1
            for camera, picture in (yield from _look(name, pixels, cameras)).items():
                shots[camera].append(picture)
        for camera in cameras:
            readings[camera].append(read_axis(shots[camera][:STEPS], shots[camera][STEPS:]))
    last = yield from _look("board", panel.board(), cameras)
    maps = {
        c: both_axes(readings[c][0], readings[c][1], panel.width_px, panel.height_px)
        for c in cameras
    }
    found = {camera: correspondences(maps[camera]) for camera in cameras}
    for camera in cameras:
        findings += board.judge_rest(camera, boards[camera], board.find_board(last[camera], panel))
        findings += judge.judge_map(camera, maps[camera], found[camera])
    return _Seen(panel=panel, maps=maps, found=found, findings=tuple(findings), pictures=pictures)


def _look(name: str, pixels: Pixels, cameras: tuple[str, ...]) -> Steps[dict[str, Pixels]]:
    pictures = yield from _pictures(name, pixels, cameras)
    return {camera: picture.pixels for camera, picture in pictures.items()}


def _pictures(name: str, pixels: Pixels, cameras: tuple[str, ...]) -> Steps[dict[str, Picture]]:
    yield from show(name, pixels)
    pictures = {}
    for camera in cameras:
        pictures[camera] = yield from capture(camera, name)
    return pictures


def _alone(profile: Profile, seen: _Seen, priors: Mapping[str, LensPrior]) -> dict[str, CameraView]:
    """Return each camera in the screen's frame, from what it sees of the screen alone."""
    given = Observations(seen=seen.found, screen=_known_place(profile), priors=priors)
    start = np.zeros(3)
    cameras = [
        fit_alone(found, profile.display.pixel_mm, priors[camera], LEAST_DEVIATION_PX).parameters
        for camera, found in seen.found.items()
    ]
    return judge.screen_views(given, np.concatenate([start, *cameras]))


def _known_place(profile: Profile, *, is_trusted: bool = False) -> ScreenPlace:
    display = profile.display
    place = ScreenPlace(
        corner_mm=(display.corner_x_mm, display.corner_y_mm),
        angle_deg=display.angle_deg,
        height_mm=profile.heights.surface_mm,
        pixel_mm=display.pixel_mm,
    )
    if not is_trusted:
        return place
    return replace(place, deviation_mm=_TRUST_MM, deviation_deg=_TRUST_DEG)


def _observations(
    profile: Profile,
    found: Mapping[str, Correspondences],
    ties: Ties,
    priors: Mapping[str, LensPrior],
) -> Observations:
    is_tied = bool(ties.touches or ties.blocks)
    return Observations(
        seen=found,
        screen=_known_place(profile, is_trusted=not is_tied),
        touches=ties.touches,
        blocks=ties.blocks,
        priors=priors,
        top_mm=max(block.height_mm for block in profile.blocks.values()),
    )


def _dot_references(
    profile: Profile, panel: Panel, fit: ScreenFit
) -> Steps[tuple[DotReference, ...]]:
    """Show the dots of the check for drift, to know where they are seen now."""
    cameras = fit.given.cameras
    lit = yield from _look("drift dots", dots(panel), cameras)
    dark = yield from _look("drift black", panel.field(0), cameras)
    place = fit.place()
    display = profile.display.model_copy(
        update={
            "corner_x_mm": place.corner_mm[0],
            "corner_y_mm": place.corner_mm[1],
            "angle_deg": place.angle_deg,
        }
    )
    known = profile.model_copy(update={"display": display})
    return tuple(
        measured_reference(camera, fit.view(camera), lit[camera], dark[camera], known)
        for camera in cameras
    )


def _failed(findings: list[Finding]) -> Measurement:
    return Measurement(kind=KIND, subject="cell", method=METHOD, findings=tuple(findings))
