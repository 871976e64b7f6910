"""Whether a cell is known as well as its profile and a task demand."""

from __future__ import annotations

from collections.abc import Sequence

from calibration.demands import unmet_by_kind, unmet_for_camera, unmet_for_lattice
from calibration.record import CalibrationRecord
from cell.profile import CellProfile
from sessions.binding import camera_of
from sessions.script import TaskSpec


def shortcomings(
    profile: CellProfile, records: Sequence[CalibrationRecord], spec: TaskSpec | None = None
) -> list[str]:
    """Return in what a cell is not known as well as is demanded, a sentence each.

    A task demands it of where the lattice lies, and of where each of its views that has a
    fixed place shows the table.

    Args:
        profile: The cell's profile, with the calibrations in force.
        records: The calibrations in force.
        spec: The task; None for what the cell's profile alone demands.
    """
    found = [f"the cell {profile.name}: {one}" for one in unmet_by_kind(profile.demands, records)]
    if spec is None or spec.accuracy_mm is None:
        return found
    told = [unmet_for_lattice(spec.accuracy_mm, records)]
    for view in spec.views:
        camera = camera_of(view.name)
        told.append(unmet_for_camera(camera, spec.accuracy_mm, profile, records))
    return found + [f"{spec.goal} in {spec.environment}: {one}" for one in told if one]


def refusal(problems: Sequence[str]) -> str:
    """Return shortcomings as one short sentence for a client."""
    more = len(problems) - 1
    return problems[0] + (f" (and {more} more)" if more else "")
