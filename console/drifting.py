"""The check for drift that the watchdog makes: what a command hands in, and what it told last."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from console.calibrating import now
from console.output import say
from console.places import calibrations_folder

if TYPE_CHECKING:
    from calibration.checks import LastCheck
    from calibration.record import CalibrationRecord
    from cell.profile import CellProfile, Profile
    from cell.watchdog import CalibrationCheck


def drift_check(profile: Profile, records: Sequence[CalibrationRecord]) -> CalibrationCheck:
    """Return what checks the calibrations of a cell between sessions.

    Args:
        profile: The cell's profile, with the calibrations in force.
        records: The calibrations in force.
    """
    from calibration.checks import Checks
    from calibration.drift.between_sessions import DriftCheck

    return DriftCheck(profile, records, Checks(calibrations_folder(profile.name)), now)


def last_check_of(profile: CellProfile) -> LastCheck | None:
    """Return the last check of a cell, None if there was none; one that cannot be read is told."""
    from calibration.checks import Checks
    from calibration.errors import ArchiveError

    try:
        return Checks(calibrations_folder(profile.name)).read().last
    except ArchiveError as error:
        say(f"warning: {error}", "yellow")
        return None


def tell_last_check(profile: Profile) -> None:
    """Tell in a line each which calibrations the last check found to hold no more."""
    from calibration.checks import moved_cameras

    last = last_check_of(profile)
    for camera, why in moved_cameras(profile, last).items():
        hint = "" if last is None else last.cameras[camera].hint
        say(f"warning: {why}; {hint}", "yellow")
