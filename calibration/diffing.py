"""What differs between two calibrations: values, millimetres at the playground, parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from pydantic import JsonValue

from calibration.applying import calibrate_where_it_fits
from calibration.playground import PLAYGROUND_MM
from calibration.record import CalibrationRecord
from cell.profile import Profile


@dataclass(frozen=True, slots=True)
class ParameterShift:
    """A fitted number in two calibrations.

    Attributes:
        name: Its name.
        unit: Its unit.
        first: In the first.
        second: In the second.
        sigmas: By how many standard deviations of the difference they differ; None where the
            deviations are not known.
    """

    name: str
    unit: str
    first: float
    second: float
    sigmas: float | None


@dataclass(frozen=True, slots=True)
class CornerShift:
    """How far apart two calibrations of a camera see a corner of the playground.

    Attributes:
        corner_mm: Robot x, y.
        shift_mm: Second less first, robot x and y.
    """

    corner_mm: tuple[float, float]
    shift_mm: tuple[float, float]

    @property
    def distance_mm(self) -> float:
        """Length of the shift."""
        return math.hypot(*self.shift_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """What differs between two calibrations.

    Attributes:
        values: What they set in the profile and differs, by path: first, second.
        parameters: The parameters that both have.
        corners: The playground's corners by camera, where both map that camera's picture.
    """

    values: dict[str, tuple[JsonValue, JsonValue]]
    parameters: tuple[ParameterShift, ...]
    corners: dict[str, tuple[CornerShift, ...]]


def difference(
    first: CalibrationRecord, second: CalibrationRecord, profile: Profile | None
) -> Difference:
    """Return what differs between two calibrations.

    Args:
        first: One calibration.
        second: The other.
        profile: What the cell's file says; None for a cell without a playground.
    """
    paths = sorted({*first.values, *second.values})
    return Difference(
        values={
            path: (first.values.get(path), second.values.get(path))
            for path in paths
            if first.values.get(path) != second.values.get(path)
        },
        parameters=_parameters(first, second),
        corners={} if profile is None else _corners(first, second, profile),
    )


def _parameters(first: CalibrationRecord, second: CalibrationRecord) -> tuple[ParameterShift, ...]:
    others = {parameter.name: parameter for parameter in second.parameters}
    shifts = []
    for one in first.parameters:
        other = others.get(one.name)
        if other is None or other.unit != one.unit:
            continue
        sigmas = None
        if one.deviation is not None and other.deviation is not None:
            spread = math.hypot(one.deviation, other.deviation)
            sigmas = abs(other.value - one.value) / spread if spread > 0 else None
        shifts.append(ParameterShift(one.name, one.unit, one.value, other.value, sigmas))
    return tuple(shifts)


def _corners(
    first: CalibrationRecord, second: CalibrationRecord, profile: Profile
) -> dict[str, tuple[CornerShift, ...]]:
    found: dict[str, tuple[CornerShift, ...]] = {}
    for camera in profile.cameras:
        if not (_maps(first, camera) and _maps(second, camera)):
            continue
        shifts = _camera_corners(first, second, profile, camera)
        if shifts:
            found[camera] = shifts
    return found


def _camera_corners(
    first: CalibrationRecord, second: CalibrationRecord, profile: Profile, camera: str
) -> tuple[CornerShift, ...]:
    height_mm = profile.block_top_mm
    views = []
    for record in (first, second):
        done = calibrate_where_it_fits(profile, [_with_supports(record)])
        view = None if done.misfits else done.profile.cameras[camera].view(height_mm)
        if view is None:
            return ()
        views.append(view)
    corners = np.array(PLAYGROUND_MM)
    try:
        seen = views[1].to_robot(views[0].to_picture(corners, height_mm), height_mm)
    except ValueError:
        return ()
    return tuple(
        CornerShift((float(x), float(y)), (float(u - x), float(v - y)))
        for (x, y), (u, v) in zip(corners, seen, strict=True)
    )


def _with_supports(record: CalibrationRecord) -> CalibrationRecord:
    """Return a record that brings along the values that its own were fitted with."""
    supports = {support.path: support.value for support in record.stands_on}
    return record.model_copy(update={"values": {**supports, **record.values}, "stands_on": ()})


def _maps(record: CalibrationRecord, camera: str) -> bool:
    return any(
        path.startswith(f"cameras.{camera}.") and path.rsplit(".", 1)[1] in _MAPPING
        for path in record.values
    )


_MAPPING: Final = frozenset({"plane_map", "place", "lens"})
