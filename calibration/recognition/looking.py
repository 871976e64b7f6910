"""Lays blocks out and looks at them: by the arm, or by a person who points at each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from calibration.catalogue import Site
from calibration.errors import CalibrationError
from calibration.procedure import (
    Steps,
    ask_done,
    capture,
    light,
    point_at,
    put_block,
    return_block,
    show,
    stand_aside,
    tell,
)
from calibration.recognition.samples import BlockSample, matched
from calibration.requests import Picture
from calibration.verdict import Finding, Grade
from cell.errors import VisionError
from cell.geometry import TableView
from cell.profile import Profile
from cell.store import StorePlan, StoreSlot, TablePlace
from cell.vision.blocks import find_blocks
from cell.vision.viewpoints import mapped_cameras

_SPOTS_MM = tuple(
    (x_mm, y_mm) for y_mm in (-280.0, -120.0, 40.0, 200.0) for x_mm in (360.0, 495.0, 630.0)
)
"""Places on the playground, far enough apart for fingers around any block at any angle."""

AT_ONCE = len(_SPOTS_MM)
_TURN_DEG = 37.0
_SHIFT = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """What is looked at and how.

    Attributes:
        profile: The cell's.
        plan: Its store.
        camera: Name of the camera.
        view: Where its picture lies.
        top_mm: Height of the block tops.
    """

    profile: Profile
    plan: StorePlan
    camera: str
    view: TableView
    top_mm: float


@dataclass(slots=True)
class Seen:
    """What the looks came to."""

    samples: list[BlockSample] = field(default_factory=list)
    missing: list[StoreSlot] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)


def seeing_cameras(site: Site) -> tuple[Profile, StorePlan, list[str]]:
    """Return the cameras whose picture is mapped to the playground, the best one first.

    Raises:
        CalibrationError: The cell has no playground, no store or no such camera.
    """
    if not isinstance(site.profile, Profile) or site.plan is None or not site.plan.slots:
        raise CalibrationError(
            f"the cell {site.profile.name} has no playground with a store of blocks to learn from"
        )
    names = list(mapped_cameras(site.profile))
    if not names:
        raise CalibrationError(
            "no camera's picture is mapped to the table; calibrate one first, such as by "
            "`cell calibrate homography`"
        )
    return site.profile, site.plan, names


def table_of(profile: Profile, plan: StorePlan, camera: str) -> Table:
    """Return what a camera looks at.

    Raises:
        CalibrationError: Its picture is not mapped to the table.
    """
    top_mm = profile.block_top_mm
    device = profile.cameras.get(camera)
    view = None if device is None else device.view(top_mm)
    if view is None:
        raise CalibrationError(f"camera {camera}: its picture is not mapped to the table")
    return Table(profile=profile, plan=plan, camera=camera, view=view, top_mm=top_mm)


def look_with_arm(table: Table, slots: Sequence[StoreSlot], rounds: int) -> Steps[Seen]:
    """Have the arm lay the blocks out at several places and angles, and look at each layout."""
    seen = Seen()
    batches = [slots[i : i + AT_ONCE] for i in range(0, len(slots), AT_ONCE)]
    for number in range(rounds):
        for part, batch in enumerate(batches):
            label = f"round {number + 1}" + (f", part {part + 1}" if len(batches) > 1 else "")
            yield from tell(label, number * len(batches) + part, rounds * len(batches))
            expected = []
            for index, slot in enumerate(batch):
                place = yield from put_block(slot.number, _place(index, number))
                expected.append((slot, _pixel(table, place)))
            yield from stand_aside()
            yield from _look(table, label, expected, seen)
            for slot in batch:
                yield from return_block(slot.number)
            if seen.findings:
                return seen
    yield from stand_aside()
    return seen


def look_by_hand(table: Table, slots: Sequence[StoreSlot], rounds: int) -> Steps[Seen]:
    """Have a person lay the blocks out and point at each."""
    seen = Seen()
    names = ", ".join(f"{s.number} ({s.colour} {s.kind})" for s in slots)
    for number in range(rounds):
        label = f"round {number + 1}"
        yield from ask_done(
            f"laid_{number + 1}",
            f"Lay the blocks of the slots {names} on the playground, at other places and angles "
            "than before, none touching another.",
        )
        yield from stand_aside()
        yield from light(is_on=True)
        yield from show("black")
        picture = yield from capture(table.camera, f"{label}, to point at")
        expected = []
        for slot in slots:
            at = yield from point_at(
                f"block_{slot.number}_{number + 1}",
                f"Where is the {slot.colour} {slot.kind} of slot {slot.number}?",
                picture,
            )
            expected.append((slot, at))
        yield from _look(table, label, expected, seen)
        if seen.findings:
            return seen
    return seen


def _look(
    table: Table,
    label: str,
    expected: Sequence[tuple[StoreSlot, tuple[float, float]]],
    seen: Seen,
) -> Steps[None]:
    yield from light(is_on=True)
    yield from show("white")
    white = yield from capture(table.camera, f"{label}, white")
    yield from show("black")
    black = yield from capture(table.camera, f"{label}, black")
    seen.pictures.append(black)
    try:
        blocks = find_blocks(white.pixels, black.pixels)
    except VisionError as error:
        are_off = "lights are off" in str(error)
        seen.findings.append(
            Finding(
                code="lights-off" if are_off else "screen-off",
                grade=Grade.BAD,
                text=str(error),
                hint="switch lights and television on, take the cap off the lens",
                samples=(label,),
            )
        )
        return
    samples, missing = matched(blocks, expected, label)
    seen.samples += samples
    seen.missing += missing


def _place(index: int, number: int) -> TablePlace:
    """Return the place of a block in a round: each block gets around."""
    spot = (index + _SHIFT * number) % AT_ONCE
    x_mm, y_mm = _SPOTS_MM[spot]
    # The last full turns differ by kind's symmetry; any angle may come.
    yaw_deg = math.fmod(_TURN_DEG * (index + 2 * number), 90.0) - 45.0
    return TablePlace(x_mm=x_mm, y_mm=y_mm, yaw_deg=yaw_deg)


def _pixel(table: Table, place: TablePlace) -> tuple[float, float]:
    u_px, v_px = table.view.to_picture(np.array([[place.x_mm, place.y_mm]]), table.top_mm)[0]
    return float(u_px), float(v_px)
