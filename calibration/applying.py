"""Calibrations in force become values of the profile, which is all that the cell sees."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from pydantic import JsonValue, ValidationError

from calibration.errors import CalibrationError
from calibration.record import CalibrationRecord
from cell.profile import CellProfile

ProfileT = TypeVar("ProfileT", bound=CellProfile)


class Misfit(CalibrationError):
    """A calibration does not fit the profile any more.

    Attributes:
        record: The calibration.
        problem: Why, as a sentence.
    """

    def __init__(self, record: CalibrationRecord, problem: str) -> None:
        self.record = record
        self.problem = problem
        super().__init__(
            f"calibration {record.identity[:8]} ({record.kind} of {record.subject}) does not fit "
            f"the profile: {problem}; calibrate again, or take it out of force with "
            f"`cell calibration undo {record.kind} {record.subject}`"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated(Generic[ProfileT]):
    """A profile with what is known of its cell.

    Attributes:
        profile: The profile, with the values of calibrations in the place of its own.
        records: The calibrations that it has, oldest first.
        misfits: Those that do not fit and were left out.
    """

    profile: ProfileT
    records: tuple[CalibrationRecord, ...] = ()
    misfits: tuple[Misfit, ...] = ()


def calibrated_profile(profile: ProfileT, records: Iterable[CalibrationRecord]) -> ProfileT:
    """Return a profile with the values of calibrations in the place of its own.

    Args:
        profile: What the cell's file says.
        records: Calibrations in force; of two that set the same value, the later one counts.

    Raises:
        Misfit: A record belongs to another cell or another camera, or sets what the profile
            has not or cannot have.
    """
    found = calibrate_where_it_fits(profile, records)
    if found.misfits:
        raise found.misfits[0]
    return found.profile


def calibrate_where_it_fits(
    profile: ProfileT, records: Iterable[CalibrationRecord]
) -> Calibrated[ProfileT]:
    """Return a profile with the values of all calibrations that fit it, and which do not.

    Args:
        profile: What the cell's file says.
        records: Calibrations in force; of two that set the same value, the later one counts.
    """
    used: list[CalibrationRecord] = []
    misfits: list[Misfit] = []
    for record in sorted(records, key=lambda one: one.measured_at):
        try:
            profile = _with_values(profile, record)
        except Misfit as misfit:
            misfits.append(misfit)
        else:
            used.append(record)
    return Calibrated(profile=profile, records=tuple(used), misfits=tuple(misfits))


def _with_values(profile: ProfileT, record: CalibrationRecord) -> ProfileT:
    if record.cell != profile.name:
        raise Misfit(record, f"it was made for the cell {record.cell}, not for {profile.name}")
    for camera, guid in record.cameras.items():
        there = profile.cameras.get(camera)
        if there is None:
            raise Misfit(record, f"the cell has no camera {camera} any more")
        if there.guid != guid:
            raise Misfit(
                record,
                f"it was measured with the camera {guid}, but {camera} is now {there.guid}",
            )
    if not record.values:
        return profile
    data = profile.model_dump(mode="json")
    for path, value in record.values.items():
        _set(data, path, value, record)
    try:
        return type(profile).model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise Misfit(record, f"{where}: {first['msg']}") from error


def _set(data: JsonValue, path: str, value: JsonValue, record: CalibrationRecord) -> None:
    *parents, last = path.split(".")
    table = data
    for name in parents:
        table = table.get(name) if isinstance(table, dict) else None
    if not isinstance(table, dict) or last not in table:
        raise Misfit(record, f"it sets {path}, which the profile does not have")
    table[last] = value
