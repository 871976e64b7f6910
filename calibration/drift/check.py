"""Whether cameras and screen still stand where they stood when they were calibrated.

Dots are shown, then black: two pictures of each camera. Where the dots appear is compared
with where they appeared at the calibration. What is said is by how many millimetres the
camera's word about the playground is off now; with too few dots in view, that nobody can say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from calibration.drift.dots import RADIUS_PX, dot_places, find_dots
from calibration.drift.motion import Motion, are_all_one, find_motion
from calibration.drift.plane_camera import camera_like
from calibration.playground import playground_grid
from calibration.record import CalibrationRecord
from calibration.screen.joint_fit import ScreenPlace, place_in_robot
from calibration.screen.patterns import Panel
from calibration.verdict import Finding, Grade
from cell.geometry import CameraView, PlaneView
from cell.profile import PlaceProfile, Profile
from cell.profile.cameras import CameraProfile

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

LEAST_MOTION_MM: Final = 0.15
"""A motion below this is not spoken of, however exactly it is known."""

TELLING_MM: Final = 0.35
"""A check that could miss a motion of this size cannot tell: a turn of 0.1 deg about the view
of a camera straight above moves the playground by 0.41 mm."""

BAD_MM: Final = 0.4
"""From here on a calibration is not what it says, unless its own figure is larger."""

_SURE = 4.0
_FEWEST = 12
_LEAST_SPREAD = 0.15
_RECKONED_MM = 1.0
"""Dots that were never seen are reckoned from lens and place, and no better than this."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DotReference:
    """Where a camera saw the dots, or should.

    Attributes:
        camera: Its name.
        view: Its lens and place.
        pixels: Where each dot of `dot_places` appeared, (n, 2); not finite where it was not
            seen.
        area_px: How many pixels each covered, (n,).
        is_measured: Whether the dots were seen, or reckoned from the calibration.
    """

    camera: str
    view: CameraView
    pixels: Points
    area_px: Points
    is_measured: bool

    @property
    def allowance_mm(self) -> float:
        """What the reference itself may be off at the playground."""
        return 0.0 if self.is_measured else _RECKONED_MM

    def known(self) -> NDArray[np.bool_]:
        """Return which dots it speaks of, (n,)."""
        return np.asarray(np.isfinite(self.area_px) & np.isfinite(self.pixels).all(axis=1))

    def rows(self) -> list[JsonValue]:
        """Return index, u, v and area of each dot, for a record."""
        return [
            [int(i), *(round(float(k), 3) for k in self.pixels[i]), float(self.area_px[i])]
            for i in np.flatnonzero(self.known())
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Blind:
    """A camera that cannot tell.

    Attributes:
        camera: Its name.
        reason: Why.
    """

    camera: str
    reason: str


def panel_of(profile: Profile, record: CalibrationRecord | None = None) -> Panel:
    """Return the cell's panel with the grey values that a calibration found."""
    panel = Panel(width_px=profile.display.width_px, height_px=profile.display.height_px)
    if record is None:
        return panel
    bright, gamma = record.details.get("bright"), record.details.get("gamma")
    if not isinstance(bright, int) or not isinstance(gamma, int | float):
        return panel
    return Panel(
        width_px=panel.width_px, height_px=panel.height_px, bright=bright, gamma=float(gamma)
    )


def references(
    profile: Profile,
    record: CalibrationRecord | None,
    baselines: Mapping[str, Sequence[JsonValue]] | None = None,
) -> tuple[tuple[DotReference, ...], tuple[Blind, ...]]:
    """Return what every camera that stands still saw of the dots, and which cannot tell.

    Args:
        profile: The cell's profile with its calibrations.
        record: The calibration by the screen that is in force; without it, where the dots
            should be is reckoned from lens and place of the cameras.
        baselines: Where cameras that the record does not speak of saw the dots in an earlier
            check: index, u, v and area of each.
    """
    found: list[DotReference] = []
    blind: list[Blind] = []
    for name, camera in profile.cameras.items():
        if not camera.stands_still:
            continue
        rows = _rows_of(record, name, camera) or list((baselines or {}).get(name, ())) or None
        view = camera.view(profile.block_top_mm)
        if isinstance(view, PlaneView):
            view = None if rows is None else camera_like(view, profile.block_top_mm)
        if isinstance(view, CameraView):
            found.append(dot_reference(name, view, profile, rows))
        else:
            blind.append(Blind(camera=name, reason="neither its lens nor its place is calibrated"))
    return tuple(found), tuple(blind)


def areas_in_picture(
    view: CameraView, points_mm: Points, glass_mm: float, pixel_mm: float
) -> Points:
    """Return how many pixels dots at robot points (n, 2) cover, (n,)."""
    step = 1.0
    u = view.to_picture(points_mm + (step, 0.0), glass_mm)
    u = (u - view.to_picture(points_mm - (step, 0.0), glass_mm)) / (2.0 * step)
    v = view.to_picture(points_mm + (0.0, step), glass_mm)
    v = (v - view.to_picture(points_mm - (0.0, step), glass_mm)) / (2.0 * step)
    scale = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return np.asarray(scale * np.pi * (RADIUS_PX * pixel_mm) ** 2)


def measured_reference(
    camera: str, view: CameraView, lit: Pixels, dark: Pixels, profile: Profile
) -> DotReference:
    """Return where a camera that was just calibrated sees the dots."""
    modelled = dot_reference(camera, view, profile, None)
    known = np.flatnonzero(modelled.known())
    seen = find_dots(lit, dark, modelled.pixels[known], modelled.area_px[known])
    pixels = np.full_like(modelled.pixels, np.nan)
    areas = np.full_like(modelled.area_px, np.nan)
    pixels[known[seen.index]], areas[known[seen.index]] = seen.pixels, seen.area_px
    return DotReference(camera=camera, view=view, pixels=pixels, area_px=areas, is_measured=True)


def motion_seen(was: DotReference, lit: Pixels, dark: Pixels, profile: Profile) -> Motion | Blind:
    """Return how a camera's picture moved since its reference.

    Args:
        was: What it saw then.
        lit: Picture (960, 1280, 3) with the dots on the screen.
        dark: The same with a black screen.
        profile: The cell's profile.
    """
    known = was.known()
    seen = find_dots(lit, dark, was.pixels[known], was.area_px[known])
    before = was.pixels[known][seen.index]
    if len(seen) < _FEWEST:
        return Blind(
            camera=was.camera,
            reason=f"only {len(seen)} of {int(known.sum())} dots are seen, {_FEWEST} are needed",
        )
    spread = before.std(axis=0) / was.pixels[known].std(axis=0)
    if float(spread.min()) < _LEAST_SPREAD:
        return Blind(camera=was.camera, reason=f"the {len(seen)} dots that are seen lie together")
    motion = find_motion(
        was.camera,
        was.view,
        before,
        seen.pixels,
        glass_mm=profile.heights.surface_mm,
        top_mm=profile.block_top_mm,
        playground_mm=playground_grid(),
        allowance_mm=was.allowance_mm,
    )
    if _SURE * motion.deviation_mm > TELLING_MM:
        return Blind(
            camera=was.camera,
            reason=f"the {len(seen)} dots that are seen tell a motion to "
            f"{motion.deviation_mm:.2f} mm only",
        )
    return motion


def has_moved(motion: Motion) -> bool:
    """Tell whether a motion is larger than chance makes it."""
    return motion.rms_mm > motion.allowance_mm + max(LEAST_MOTION_MM, _SURE * motion.deviation_mm)


def judge(seen: Sequence[Motion | Blind], *, stated_mm: float | None = None) -> tuple[Finding, ...]:
    """Return what cameras' dots say. Where none can tell, that is BAD: nothing was learned.

    Args:
        seen: One for each camera.
        stated_mm: The accuracy that the calibration stated; motions beyond it are BAD.
    """
    motions = [one for one in seen if isinstance(one, Motion)]
    findings = [
        Finding(
            code="cannot-tell",
            grade=Grade.DEGRADED if motions else Grade.BAD,
            text=f"camera {one.camera} cannot tell whether it moved: {one.reason}",
            hint="clear the screen and check again"
            if "dots" in one.reason
            else "calibrate it by the screen",
        )
        for one in seen
        if isinstance(one, Blind)
    ]
    moved = [motion for motion in motions if has_moved(motion)]
    if not moved:
        return tuple(findings)
    grade = max((grade_of(motion, stated_mm) for motion in moved), key=lambda g: g.severity)
    return (_moved(moved, motions, grade), *findings)


def grade_of(motion: Motion, stated_mm: float | None = None) -> Grade:
    """Return how much a motion weighs.

    Args:
        motion: The motion.
        stated_mm: The accuracy that the calibration stated; motions beyond it are BAD.
    """
    if not has_moved(motion):
        return Grade.OK
    limit_mm = max(stated_mm or BAD_MM, LEAST_MOTION_MM)
    return Grade.BAD if motion.rms_mm > motion.allowance_mm + limit_mm else Grade.DEGRADED


def _moved(moved: Sequence[Motion], motions: Sequence[Motion], grade: Grade) -> Finding:
    listed = "; ".join(
        f"what {m.camera} tells of the playground is {m.rms_mm:.2f} ± {m.deviation_mm:.2f} mm "
        f"off, {m.max_mm:.2f} mm at most"
        for m in moved
    )
    names = ", ".join(m.camera for m in moved)
    again = "fasten it and calibrate by the screen again"
    if len(motions) == 1:
        return Finding(
            code="camera-or-screen-moved",
            grade=grade,
            text=f"{listed}. One camera alone cannot tell whether it moved or the screen",
            hint=again,
        )
    if len(moved) == len(motions) and are_all_one(moved, LEAST_MOTION_MM):
        x, y, turn = (float(np.mean(k)) for k in zip(*(m.screen_mm for m in moved), strict=True))
        return Finding(
            code="screen-moved",
            grade=grade,
            text=f"{listed}. All cameras see the same: the screen moved by ({x:+.2f}, {y:+.2f}) "
            f"mm and {turn:+.3f} deg",
            hint="push it back, or calibrate by the screen again",
        )
    return Finding(
        code="camera-moved", grade=grade, text=f"camera {names} moved: {listed}", hint=again
    )


def dot_reference(
    name: str, view: CameraView, profile: Profile, rows: JsonValue | None
) -> DotReference:
    """Return where a camera saw the dots by `rows` of a record, else where it should see them."""
    display = profile.display
    places = dot_places(display.width_px, display.height_px)
    screen = ScreenPlace(
        corner_mm=(display.corner_x_mm, display.corner_y_mm),
        angle_deg=display.angle_deg,
        height_mm=profile.heights.surface_mm,
        pixel_mm=display.pixel_mm,
    )
    robot_mm = place_in_robot(screen, places)
    if isinstance(rows, list):
        pixels, areas = np.full((len(places), 2), np.nan), np.full(len(places), np.nan)
        for row in rows:
            if isinstance(row, list) and len(row) == 4:
                index, u, v, area = (float(k) for k in row if isinstance(k, int | float))
                pixels[int(index)], areas[int(index)] = (u, v), area
        return DotReference(camera=name, view=view, pixels=pixels, area_px=areas, is_measured=True)
    height_mm = profile.heights.surface_mm
    pixels = view.to_picture(robot_mm, height_mm)
    areas = areas_in_picture(view, robot_mm, height_mm, display.pixel_mm)
    margin = np.sqrt(areas / np.pi)[:, None] + 1.0
    is_inside = ((pixels > margin) & (pixels < np.array([1279.0, 959.0]) - margin)).all(axis=1)
    areas = np.where(is_inside, areas, np.nan)
    return DotReference(camera=name, view=view, pixels=pixels, area_px=areas, is_measured=False)


def _rows_of(
    record: CalibrationRecord | None, name: str, camera: CameraProfile
) -> JsonValue | None:
    """Return where a camera saw the dots, if the record's place of it is the one in force."""
    if record is None or camera.place is None:
        return None
    kept = record.details.get("dots")
    place = record.values.get(f"cameras.{name}.place")
    if not isinstance(kept, dict) or not isinstance(place, dict):
        return None
    return kept.get(name) if PlaceProfile.model_validate(place) == camera.place else None


def as_details(seen: Sequence[Motion | Blind]) -> Mapping[str, JsonValue]:
    """Return the figures for a record."""
    return {
        one.camera: (
            {"reason": one.reason}
            if isinstance(one, Blind)
            else {
                "dots": one.dots,
                "noise_px": round(one.noise_px, 4),
                "rms_mm": round(one.rms_mm, 4),
                "max_mm": round(one.max_mm, 4),
                "deviation_mm": round(one.deviation_mm, 4),
            }
        )
        for one in seen
    }
