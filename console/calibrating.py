"""The calibrations of a command's cell: where they are kept, and the profile they make."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, TypeVar

from console.output import say
from console.places import calibrations_folder

if TYPE_CHECKING:
    from calibration.applying import Calibrated
    from calibration.archive import Archive
    from calibration.record import CalibrationRecord
    from cell.profile import CellProfile

    ProfileT = TypeVar("ProfileT", bound=CellProfile)


def archive_of(profile: CellProfile) -> Archive:
    """Return where the calibrations of a cell are kept."""
    from calibration.archive import Archive

    return Archive(calibrations_folder(profile.name))


def with_calibrations(profile: ProfileT, *, is_quiet: bool = False) -> Calibrated[ProfileT]:
    """Return a profile with the calibrations in force; what does not fit is told and left out.

    Args:
        profile: What the cell's file says.
        is_quiet: Whether nothing is told.

    Raises:
        ArchiveError: What is in force cannot be read at all.
    """
    from calibration.applying import Calibrated, calibrate_where_it_fits

    folder = calibrations_folder(profile.name)
    if not (folder / "current.json").exists():
        return Calibrated(profile=profile)
    records, problems = archive_of(profile).readable()
    found = calibrate_where_it_fits(profile, records)
    for problem in (
        () if is_quiet else (*problems, *map(str, found.misfits), *map(str, found.stale))
    ):
        say(f"warning: {problem}", "yellow")
    return found


def now() -> datetime:
    """Return the wall time."""
    return datetime.now(UTC)


def age_of(record: CalibrationRecord, at: datetime) -> str:
    """Return how long ago a calibration was measured, in words."""
    seconds = (at - record.measured_at).total_seconds()
    if seconds < -60:
        return "in the future"
    for unit, length_s in (("day", 86400), ("hour", 3600), ("minute", 60)):
        count = int(seconds // length_s)
        if count:
            return f"{count} {unit}{'' if count == 1 else 's'}"
    return "now"


def stated_accuracy(record: CalibrationRecord) -> str:
    """Return a calibration's accuracy with its unit and how it is known."""
    accuracy = record.accuracy
    if accuracy.stated is None:
        return "not known"
    return f"{accuracy.stated:.3g} {accuracy.unit} {accuracy.stated_how}"


def in_a_line(record: CalibrationRecord, at: datetime) -> str:
    """Return a calibration in force as one line."""
    return (
        f"{record.kind} of {record.subject}: {record.grade}, {stated_accuracy(record)}, "
        f"measured {record.measured_at:%Y-%m-%d} ({age_of(record, at)}), {record.identity[:8]}"
    )
