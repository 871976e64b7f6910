"""The last check whether calibrations still hold, kept beside them.

    checks.json    the last check, and where cameras saw the dots of the first one

A check counts as long as what it checked is in force: as long as a camera's values, and the
screen's, are those that it was made with. Calibrating again or undoing ends that.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError

from calibration.errors import ArchiveError
from calibration.files import replace
from calibration.record import CalibrationRecord
from calibration.verdict import Grade
from cell.profile import CellProfile, Profile

CHECKS_FILE: Final = "checks.json"
_PLACING: Final = ("place", "plane_map")


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class CameraChecked(_Part):
    """What the last check told of a camera."""

    grade: Grade | None
    """Its verdict; None where it could not tell."""
    text: str
    """What was seen, with figures."""
    hint: str = ""
    """What to do."""
    knowledge: str
    """Digest of the values that were checked."""


class LastCheck(_Part):
    """The last check of a cell."""

    at: datetime
    """When, with the time zone."""
    cameras: dict[str, CameraChecked]
    """By name."""

    @property
    def grade(self) -> Grade | None:
        """The worst of all cameras; None where no camera could tell."""
        grades = [camera.grade for camera in self.cameras.values() if camera.grade is not None]
        return max(grades, key=lambda grade: grade.severity) if grades else None


class Baseline(_Part):
    """Where a camera saw the dots in its first check, for calibrations that never saw them."""

    at: datetime
    """When, with the time zone."""
    knowledge: str
    """Digest of the values that were in force."""
    rows: list[JsonValue]
    """Index, u, v and area of each dot."""


class Kept(_Part):
    """Everything that is kept of checks."""

    last: LastCheck | None = None
    baselines: dict[str, Baseline] = Field(default_factory=dict)


class Checks:
    """What is kept of the checks of a cell.

    Args:
        folder: The folder of its calibrations.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / CHECKS_FILE

    def read(self) -> Kept:
        """Return what is kept, nothing if there is no file.

        Raises:
            ArchiveError: The file cannot be read.
        """
        try:
            return Kept.model_validate_json(self._path.read_bytes())
        except FileNotFoundError:
            return Kept()
        except (OSError, ValidationError) as error:
            raise ArchiveError(
                f"{self._path} cannot be read; move it away, and check the calibrations again "
                "with `cell watchdog run --only calibrations`"
            ) from error

    def keep(self, kept: Kept) -> None:
        """Keep a check in the place of the one before.

        Raises:
            ArchiveError: The file cannot be written.
        """
        try:
            replace(self._path, kept.model_dump_json(indent=1).encode())
        except OSError as error:
            raise ArchiveError(
                f"{self._path} cannot be written: {error.strerror or error}"
            ) from error


def knowledge_of(profile: Profile, camera: str) -> str:
    """Return the digest of what is known of where a camera's picture and the screen lie."""
    known, display = profile.cameras[camera], profile.display
    values = known.model_dump(mode="json", include={"guid", "lens", "place", "plane_map"})
    screen = [display.corner_x_mm, display.corner_y_mm, display.angle_deg, display.pixel_mm]
    text = json.dumps([values, screen, profile.heights.surface_mm], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def grade_in(last: LastCheck | None, profile: CellProfile, record: CalibrationRecord) -> str:
    """Return what the last check said of the cameras that a calibration speaks of.

    Args:
        last: The last check; None if there was none.
        profile: The cell's profile, with the calibrations in force.
        record: One that is in force.

    Returns:
        A grade, `cannot tell`, or nothing if it was not checked since it counts.
    """
    if last is None or not isinstance(profile, Profile):
        return ""
    told = [
        checked.grade
        for name, checked in last.cameras.items()
        if name in profile.cameras
        and checked.knowledge == knowledge_of(profile, name)
        and {f"cameras.{name}.{value}" for value in _PLACING} & set(record.values)
    ]
    grades = [grade for grade in told if grade is not None]
    if grades:
        return max(grades, key=lambda grade: grade.severity).value
    return "cannot tell" if told else ""


def moved_cameras(profile: CellProfile, last: LastCheck | None) -> Mapping[str, str]:
    """Return why cameras are not where their calibrations in force have them, by name.

    Args:
        profile: The cell's profile, with the calibrations in force.
        last: The last check; None if there was none.
    """
    if last is None or not isinstance(profile, Profile):
        return {}
    return {
        name: f"the check of {last.at:%Y-%m-%d %H:%M} found: {checked.text}"
        for name, checked in last.cameras.items()
        if checked.grade is Grade.BAD
        and name in profile.cameras
        and checked.knowledge == knowledge_of(profile, name)
    }
