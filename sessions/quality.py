"""Whether a cell is known as well as its profile and a task demand."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

from calibration.checks import Checks, moved_cameras
from calibration.demands import unmet_by_kind, unmet_for_camera, unmet_for_lattice
from calibration.errors import ArchiveError
from calibration.record import CalibrationRecord
from cell.profile import CellProfile
from sessions.binding import camera_of
from sessions.script import TaskSpec

_log = logging.getLogger(__name__)


def shortcomings(
    profile: CellProfile,
    records: Sequence[CalibrationRecord],
    spec: TaskSpec | None = None,
    checks: Checks | None = None,
) -> list[str]:
    """Return in what a cell is not known as well as is demanded, a sentence each.

    A task demands it of where the lattice lies, and of where each of its views that has a
    fixed place shows the table. A calibration that the last check found to hold no more meets
    no demand.

    Args:
        profile: The cell's profile, with the calibrations in force.
        records: The calibrations in force.
        spec: The task; None for what the cell's profile alone demands.
        checks: What is kept of the checks; None where none are kept.
    """
    moved = _moved(profile, checks)
    told = unmet_by_kind(profile.demands, records)
    for kind, limit_mm in profile.demands.items():
        told += [
            f"{limit_mm:g} mm are demanded of {kind}, but {why}; calibrate again"
            for camera, why in moved.items()
            if any(r.kind == kind and _speaks_of(r, camera) for r in records)
        ]
    found = [f"the cell {profile.name}: {one}" for one in told]
    if spec is None or spec.accuracy_mm is None:
        return found
    unmet = [unmet_for_lattice(spec.accuracy_mm, records)]
    for view in spec.views:
        camera = camera_of(view.name)
        unmet.append(unmet_for_camera(camera, spec.accuracy_mm, profile, records))
        if camera in moved:
            unmet.append(
                f"{spec.accuracy_mm:g} mm are demanded, but {moved[camera]}; calibrate again"
            )
    return found + [f"{spec.goal} in {spec.environment}: {one}" for one in unmet if one]


def _moved(profile: CellProfile, checks: Checks | None) -> Mapping[str, str]:
    """Return which cameras moved; a check that cannot be read says nothing of any."""
    if checks is None:
        return {}
    try:
        return moved_cameras(profile, checks.read().last)
    except ArchiveError as error:
        _log.warning("%s", error)
        return {}


def _speaks_of(record: CalibrationRecord, camera: str) -> bool:
    return any(path.startswith(f"cameras.{camera}.") for path in record.values)


def refusal(problems: Sequence[str]) -> str:
    """Return shortcomings as one short sentence for a client."""
    more = len(problems) - 1
    return problems[0] + (f" (and {more} more)" if more else "")
