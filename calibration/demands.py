"""What is demanded of a cell's calibrations, and what does not meet it.

A demand is met by a calibration in force whose accuracy (the map's own, else held out, else
predicted) is in millimetres and not above the limit. Nothing measured is nothing known, and
meets no demand.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from calibration import catalogue
from calibration.applying import setters
from calibration.archive import Slot
from calibration.errors import QualityNotMet
from calibration.record import CalibrationRecord
from cell.profile import CellProfile

_NEVER_IN_MM: Final = frozenset({"camera-settings", "recognition", "lens"})
_CAMERA_VALUES = ("plane_map", "place")


def shortcoming(record: CalibrationRecord, limit_mm: float) -> str | None:
    """Return in what a calibration does not meet a demand, None if it does."""
    accuracy = record.accuracy
    name = f"the {record.kind} of {record.subject}"
    day = f"measured on {record.measured_at:%Y-%m-%d}"
    stated = accuracy.stated
    if stated is None:
        return f"{name} does not know its accuracy ({day})"
    if accuracy.unit != "mm":
        return f"{name} tells its accuracy in {accuracy.unit}, not in mm ({day})"
    if stated <= limit_mm:
        return None
    return f"{name} has {stated:.3g} mm ({accuracy.stated_how}), {day}"


def unmet_by_kind(demands: dict[str, float], records: Sequence[CalibrationRecord]) -> list[str]:
    """Return a sentence for each kind of calibration that is not as good as a cell demands.

    Args:
        demands: Greatest error in mm for each kind.
        records: The calibrations in force.
    """
    found = []
    for kind, limit_mm in demands.items():
        of_kind = [record for record in records if record.kind == kind]
        if not of_kind:
            found.append(_never(limit_mm, f"no {kind} is known: none is kept", _how(kind)))
        for record in of_kind:
            problem = shortcoming(record, limit_mm)
            if problem is not None:
                found.append(_refusal(limit_mm, problem))
    return found


def unmet_for_camera(
    camera: str, limit_mm: float, profile: CellProfile, records: Iterable[CalibrationRecord]
) -> str | None:
    """Return why it is not known to a limit where a camera's picture lies on the table.

    Args:
        camera: Name of the camera.
        limit_mm: Greatest error.
        profile: The profile; a camera that has no fixed place in it is not looked at.
        records: The calibrations in force.

    Returns:
        A sentence, or None if it is known or the camera's picture has no fixed place.
    """
    known = profile.cameras.get(camera)
    kept = list(records)
    paths = [f"cameras.{camera}.{value}" for value in _CAMERA_VALUES]
    was_measured = any(path in record.values for path in paths for record in kept)
    if known is None or (known.plane_map is None and known.place is None and not was_measured):
        return None
    return _unmet_for(paths, f"where camera {camera} looks", "homography", limit_mm, kept)


def unmet_for_lattice(limit_mm: float, records: Iterable[CalibrationRecord]) -> str | None:
    """Return why it is not known to a limit where the lattice lies, None if it is."""
    paths = ["lattice", "lattice.origin_mm", "lattice.step_mm", "lattice.angle_deg"]
    return _unmet_for(paths, "where the lattice lies", "world", limit_mm, records)


def require_quality(records: Iterable[CalibrationRecord], slot: Slot, limit_mm: float) -> None:
    """Return if a calibration is as good as a procedure that builds on it demands.

    Raises:
        QualityNotMet: It is not, or there is none; the text has the figure.
    """
    for record in records:
        if (record.kind, record.subject) == (slot.kind, slot.subject):
            problem = shortcoming(record, limit_mm)
            if problem is not None:
                raise QualityNotMet(_refusal(limit_mm, problem))
            return
    missing = f"no {slot.kind} of {slot.subject} is kept"
    raise QualityNotMet(_never(limit_mm, missing, _how(slot.kind)))


def _unmet_for(
    paths: Sequence[str],
    what: str,
    usual_kind: str,
    limit_mm: float,
    records: Iterable[CalibrationRecord],
) -> str | None:
    by = setters(records)
    setting = [by[path] for path in paths if path in by]
    if not setting:
        return _never(limit_mm, f"{what} is not known: no calibration is kept", _how(usual_kind))
    latest = max(setting, key=lambda record: record.measured_at)
    problem = shortcoming(latest, limit_mm)
    return None if problem is None else _refusal(limit_mm, problem)


def _refusal(limit_mm: float, problem: str) -> str:
    return f"{limit_mm:g} mm are demanded, but {problem}; calibrate again"


def _never(limit_mm: float, problem: str, how: str) -> str:
    return f"{limit_mm:g} mm are demanded, but {problem}; calibrate it: {how}"


def _how(kind: str) -> str:
    """Return the command that makes a calibration of a kind."""
    name = next((entry.name for entry in catalogue.CATALOGUE if entry.kind == kind), "")
    return f"`cell calibrate {name}`" if name else "`cell calibrate` lists what can be"


def unusable_demands(demands: Mapping[str, float]) -> dict[str, str]:
    """Return a sentence for each kind that is demanded and that no calibration can ever meet.

    Args:
        demands: Greatest error in mm for each kind.
    """
    kinds = sorted({entry.kind for entry in catalogue.CATALOGUE})
    in_mm = ", ".join(kind for kind in kinds if kind not in _NEVER_IN_MM)
    found = {}
    for kind in demands:
        if kind not in kinds:
            near = difflib.get_close_matches(kind, kinds, 1)
            meant = f"did you mean {near[0]}? " if near else ""
            found[kind] = f"there is no such calibration; {meant}there are {in_mm}"
        elif kind in _NEVER_IN_MM:
            found[kind] = (
                "its accuracy is never in mm, so that no task would ever begin; take it out "
                f"(in mm are {in_mm})"
            )
    return found
