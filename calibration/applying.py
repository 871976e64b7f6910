"""Calibrations in force become values of the profile, which is all that the cell sees."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from pydantic import JsonValue, ValidationError

from calibration.errors import CalibrationError
from calibration.record import CalibrationRecord
from cell.profile import CellProfile

ProfileT = TypeVar("ProfileT", bound=CellProfile)


def calibrated_profile(profile: ProfileT, records: Iterable[CalibrationRecord]) -> ProfileT:
    """Return a profile with the values of calibrations in the place of its own.

    Args:
        profile: What the cell's file says.
        records: Calibrations in force; of two that set the same value, the later one counts.

    Raises:
        CalibrationError: A record belongs to another cell, or sets what the profile has not
            or cannot have.
    """
    data = profile.model_dump(mode="json")
    ordered = sorted(records, key=lambda record: record.measured_at)
    if not ordered:
        return profile
    for record in ordered:
        if record.cell != profile.name:
            raise CalibrationError(
                f"calibration {record.identity[:8]} was made for the cell {record.cell}, not for "
                f"{profile.name}"
            )
        for path, value in record.values.items():
            _set(data, path, value, record)
    try:
        return type(profile).model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise CalibrationError(
            f"a calibration in force does not fit the profile: {where}: {first['msg']}; "
            "undo it with `cell calibration undo`"
        ) from error


def _set(data: JsonValue, path: str, value: JsonValue, record: CalibrationRecord) -> None:
    *parents, last = path.split(".")
    table = data
    for name in parents:
        table = table.get(name) if isinstance(table, dict) else None
    if not isinstance(table, dict) or last not in table:
        raise CalibrationError(
            f"calibration {record.identity[:8]} sets {path}, which the profile of {record.cell} "
            "does not have; undo it, or bring the profile up to date"
        )
    table[last] = value
