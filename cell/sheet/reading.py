"""Reads a sheet back from pictures: which print it is, where it lies, how it was printed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cell.geometry import TableView
from cell.profile import StoreProfile
from cell.sheet.errors import SheetError
from cell.sheet.fiducials import index_of
from cell.sheet.finding import FoundMarker, Pixels, find_markers, find_mirrored
from cell.sheet.layout import RULER_MM, SheetLayout
from cell.sheet.occupancy import SlotReading, merged, read_slots
from cell.sheet.placing import Points, SheetPlace, Sighting, fit_place, miss_mm
from cell.store import place_of_slot

_SCALE_TOLERANCE = 0.002
_SIGMAS = 4.0
_MOVED_MM = 1.0
_UNEVEN_MM = 2.0
_FAULTY_PX = 2.0
_RIM_PX = 40.0
_MANY = 4
"""As many markers of another plan are no chance finds."""
_RULER_RANGE = (0.5, 2.0)

Weight = Literal["note", "warning", "failure"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """A picture, and where it lies in the robot frame.

    Attributes:
        pixels: The picture, (960, 1280, 3), R G B.
        view: Of the camera at the moment of the picture; None if its calibration is missing:
            then the picture tells which print it shows, and nothing of places.
        hidden: Above 0 where the arm or its fingers may hide the table, (960, 1280); None
            where nothing is known to.
    """

    pixels: Pixels
    view: TableView | None
    hidden: Pixels | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SheetFinding:
    """One thing that is not as it should be.

    Attributes:
        code: Its name.
        weight: How much it weighs.
        text: What is wrong, with figures.
        hint: What to do.
    """

    code: str
    weight: Weight
    text: str
    hint: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MarkerReading:
    """How well a marker lies where the fit has it.

    Attributes:
        index: Which of the sheet's markers it is.
        corners_px: Where it was seen, (4, 2).
        residual_mm: Root mean square of its corners' distances from the fit.
        held_out_mm: The same from a fit without it; None where too few are left.
    """

    index: int
    corners_px: Points
    residual_mm: float
    held_out_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SheetReading:
    """What pictures tell of a sheet.

    Attributes:
        identity: Checksum of the plan that was looked for.
        place: Where it lies; None if it was not found, or no view tells.
        seen: Indices of the markers that were seen.
        markers: How well they lie where the fit has them, each sighting.
        total: How many markers the sheet has.
        slots: What is known of each slot; empty without a place.
        findings: What is not as it should be.
    """

    identity: str
    place: SheetPlace | None
    seen: tuple[int, ...]
    markers: tuple[MarkerReading, ...]
    total: int
    slots: tuple[SlotReading, ...]
    findings: tuple[SheetFinding, ...]

    @property
    def held_out_rms_mm(self) -> float | None:
        """Root mean square at markers that were not fitted on; None where there are none."""
        held = [one.held_out_mm for one in self.markers if one.held_out_mm is not None]
        return math.sqrt(sum(v * v for v in held) / len(held)) if held else None

    @property
    def is_good(self) -> bool:
        """Whether nothing fails."""
        return bool(self.seen) and all(f.weight != "failure" for f in self.findings)


_MIRRORED = SheetFinding(
    code="mirrored",
    weight="failure",
    text="the sheet is seen mirrored: it is printed mirrored, lies upside down and shines "
    "through, or the picture is flipped",
    hint="switch mirroring off in the printer and in the camera, and print it again",
)
_NO_VIEW = SheetFinding(
    code="no-view",
    weight="warning",
    text="the camera's lens and place are not calibrated, so neither the sheet's place nor its "
    "scale is known",
    hint="calibrate the camera's lens and place, or measure the ruler and touch two corners: "
    "`cell calibrate store-place`",
)


def read_sheet(
    looks: Sequence[Look],
    layout: SheetLayout,
    *,
    surface_mm: float,
    expected: StoreProfile | None = None,
    ruler_mm: float | None = None,
) -> SheetReading:
    """Read a sheet back from one or more pictures.

    Args:
        looks: The pictures.
        layout: The sheet that should lie there.
        surface_mm: Height of the sheet above the robot's base plane.
        expected: Where it should lie; None if nobody knows.
        ruler_mm: What the 100 mm ruler on the sheet really measures; None finds the print's
            scale from the markers.

    Raises:
        SheetError: A view does not know the sheet's height, or the ruler's figure is none.
    """
    if ruler_mm is not None and not _RULER_RANGE[0] <= ruler_mm / RULER_MM <= _RULER_RANGE[1]:
        raise SheetError(
            f"a ruler of {RULER_MM:g} mm that measures {ruler_mm:g} mm cannot be; "
            "give millimetres, such as 97.0"
        )
    found = [find_markers(look.pixels) for look in looks]
    findings = _identity_findings(found, looks, layout)
    own = {one.marker_id: one for one in layout.fiducials}
    seen = sorted({own[one.marker_id].index for f in found for one in f if one.marker_id in own})
    known = [(look, look.view, of_one) for look, of_one in zip(looks, found, strict=True)
             if look.view is not None]  # fmt: skip
    sightings = [_sightings(of_one, view, layout) for _, view, of_one in known]
    if seen and not any(sightings):
        findings.append(_NO_VIEW)
    if not any(sightings):
        return SheetReading(
            identity=layout.identity,
            place=None,
            seen=tuple(seen),
            markers=(),
            total=len(layout.fiducials),
            slots=(),
            findings=tuple(findings),
        )
    flat = [one for of_one in sightings for one in of_one]
    place, scale_findings = _place(flat, surface_mm, ruler_mm)
    markers = tuple(_judged(i, flat, place, surface_mm) for i in range(len(flat)))
    slots = [
        read_slots(
            look.pixels,
            view,
            place,
            layout,
            surface_mm=surface_mm,
            seen=[one.index for one in of_one],
            hidden=look.hidden,
        )
        for (look, view, _), of_one in zip(known, sightings, strict=True)
    ]
    return SheetReading(
        identity=layout.identity,
        place=place,
        seen=tuple(seen),
        markers=markers,
        total=len(layout.fiducials),
        slots=merged(slots),
        findings=(
            *findings,
            *scale_findings,
            *_place_findings(place, markers, layout, expected),
            *_covered(looks, seen, place, layout, surface_mm),
        ),
    )


def _covered(
    looks: Sequence[Look],
    seen: Sequence[int],
    place: SheetPlace,
    layout: SheetLayout,
    surface_mm: float,
) -> list[SheetFinding]:
    """Return how many markers are wholly in a picture, clear of arm and fingers, and not seen."""
    missing = [one for one in layout.fiducials if one.index not in seen]
    covered = [
        one.index
        for one in missing
        if any(_is_in_picture(look, place.to_robot(np.array(one.corners_mm)), surface_mm)
               for look in looks)
    ]  # fmt: skip
    if not covered:
        return []
    numbers = ", ".join(str(index) for index in covered)
    return [
        SheetFinding(
            code="covered",
            weight="note",
            text=f"{len(covered)} of {len(layout.fiducials)} markers should be in view and are "
            f"not seen: {numbers}",
            hint="blocks, shadow or dirt cover them; the place is known by the others",
        )
    ]


def _is_in_picture(look: Look, corners_mm: Points, surface_mm: float) -> bool:
    if look.view is None:
        return False
    height, width = look.pixels.shape[:2]
    try:
        pixels = look.view.to_picture(corners_mm, surface_mm)
    except ValueError:
        return False
    inside = (pixels >= _RIM_PX) & (pixels <= np.array([width, height]) - 1.0 - _RIM_PX)
    # A lens folds what is far outside back into the picture; only what maps back is there.
    if not inside.all() or _rms(look.view.to_robot(pixels, surface_mm) - corners_mm) > _MOVED_MM:
        return False
    if look.hidden is None:
        return True
    column, row = np.rint(pixels).astype(int).T
    return not bool((look.hidden[row, column] > 0).any())


def _sightings(
    found: Sequence[FoundMarker], view: TableView, layout: SheetLayout
) -> list[Sighting]:
    own = {one.marker_id: one for one in layout.fiducials}
    return [
        Sighting(
            index=own[one.marker_id].index,
            view=view,
            plan_mm=np.array(own[one.marker_id].corners_mm),
            pixels=one.corners_px,
        )
        for one in found
        if one.marker_id in own
    ]


def _place(
    sightings: Sequence[Sighting], surface_mm: float, ruler_mm: float | None
) -> tuple[SheetPlace, list[SheetFinding]]:
    """Return the place, its scale fitted only where it is not that of a true print."""
    if ruler_mm is not None:
        scale = ruler_mm / RULER_MM
        place = fit_place(sightings, surface_mm, scale=scale)
        wrong = abs(scale - 1.0) > _SCALE_TOLERANCE
        return place, [_scale_finding(scale, "by its ruler")] if wrong else []
    true = fit_place(sightings, surface_mm)
    if len({one.index for one in sightings}) < 2:
        return true, []
    free = fit_place(sightings, surface_mm, scale=None)
    deviation = math.sqrt(float(free.covariance[3, 3]))
    if abs(free.scale - 1.0) <= max(_SCALE_TOLERANCE, _SIGMAS * deviation):
        return true, []
    return free, [_scale_finding(free.scale, "by its markers")]


def _scale_finding(scale: float, how: str) -> SheetFinding:
    return SheetFinding(
        code="printed-scale",
        weight="failure",
        text=f"the sheet is printed at {100 * scale:.1f} % ({how}); the slots are off by up to "
        f"{500 * abs(scale - 1):.1f} mm for each 500 mm",
        hint="print it again at 100 %, not fitted to the page; if its ruler measures 100.0 mm, "
        "the camera's calibration is wrong",
    )


def _judged(
    position: int, sightings: Sequence[Sighting], place: SheetPlace, surface_mm: float
) -> MarkerReading:
    one = sightings[position]
    others = [other for other in sightings if other.index != one.index]
    held_out = None
    if len({other.index for other in others}) >= 2:
        without = fit_place(others, surface_mm, scale=place.scale, start=place)
        held_out = _rms(miss_mm(without, one, surface_mm))
    return MarkerReading(
        index=one.index,
        corners_px=one.pixels,
        residual_mm=_rms(miss_mm(place, one, surface_mm)),
        held_out_mm=held_out,
    )


def _rms(values: Points) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _identity_findings(
    found: Sequence[Sequence[FoundMarker]], looks: Sequence[Look], layout: SheetLayout
) -> list[SheetFinding]:
    """Return findings on prints of other plans, mirrored ones, and none at all."""
    own = {one.marker_id for one in layout.fiducials}
    seen = {one.marker_id for of_one in found for one in of_one}
    foreign = sorted(seen - own)
    if not seen & own:
        # A mirrored marker is often some other one of the dictionary, so this comes first.
        mirrored = {number for look in looks for number in find_mirrored(look.pixels)}
        if len(mirrored & own) >= 2:
            return [_MIRRORED]
    if len(foreign) >= max(2, min(len(seen & own) + 1, _MANY)):
        indices = ", ".join(str(index_of(number)) for number in foreign)
        where = "too" if seen & own else "in its place"
        return [
            SheetFinding(
                code="other-print",
                weight="failure",
                text=f"a print of another plan lies there, {where}: markers {indices} are not of "
                f"print {layout.identity[:8]}",
                hint="lay the sheet of this plan: print it with `cell store plan --out plan.pdf`",
            )
        ]
    if seen & own:
        return []
    return [
        SheetFinding(
            code="not-found",
            weight="failure",
            text=f"none of the sheet's {len(layout.fiducials)} markers is in view",
            hint="switch the lights on, take away what hides it, or look from nearer",
        )
    ]


def _place_findings(
    place: SheetPlace,
    markers: Sequence[MarkerReading],
    layout: SheetLayout,
    expected: StoreProfile | None,
) -> list[SheetFinding]:
    findings = []
    count = len({one.index for one in markers})
    if count < 2:
        findings.append(
            SheetFinding(
                code="one-marker",
                weight="warning",
                text="only one marker of the sheet is seen, so neither the print's scale nor "
                "its flatness is known",
                hint="look from where more of it is in view",
            )
        )
    worst = max(markers, key=lambda one: one.held_out_mm or 0.0)
    if (worst.held_out_mm or 0.0) > _UNEVEN_MM and place.sigma_px > _FAULTY_PX:
        findings.append(
            SheetFinding(
                code="uneven",
                weight="failure",
                text=f"marker {worst.index} lies {worst.held_out_mm:.1f} mm from where the others "
                "have it",
                hint="see that the sheet lies flat and its pages are joined at the marks; if it "
                "does, the camera has moved",
            )
        )
    if expected is not None:
        findings += _expected_findings(place, layout, expected)
    return findings


def _expected_findings(
    place: SheetPlace, layout: SheetLayout, expected: StoreProfile
) -> list[SheetFinding]:
    turned = math.degrees(
        math.remainder(math.radians(place.angle_deg - expected.angle_deg), math.tau)
    )
    if abs(turned) > 45.0:
        return [
            SheetFinding(
                code="wrong-way",
                weight="failure",
                text=f"the sheet is turned by {turned:.0f} deg from how it should lie",
                hint="turn it: its arrow runs along robot x as the profile's store.angle_deg says",
            )
        ]
    if not layout.slots:
        return []
    plan = np.array([(one.slot.x_mm, one.slot.y_mm) for one in layout.slots])
    places = [place_of_slot(one.slot, expected) for one in layout.slots]
    wanted = np.array([(one.x_mm, one.y_mm) for one in places])
    off = np.linalg.norm(place.to_robot(plan) - wanted, axis=1)
    worst = int(np.argmax(off))
    noise = float(place.deviation_mm(plan)[worst])
    if off[worst] <= max(_MOVED_MM, _SIGMAS * noise):
        return []
    return [
        SheetFinding(
            code="moved",
            weight="warning",
            text=f"slot {layout.slots[worst].slot.number} lies {off[worst]:.1f} mm from where the "
            f"profile has it (sheet turned by {turned:.2f} deg)",
            hint="push the sheet back, or calibrate its place: `cell calibrate store-place`",
        )
    ]
