"""Calibrations in force become values of the profile, which is all that the cell sees.

Some values belong together: where a camera stands was fitted with its lens. Two rules keep
them paired, whatever is calibrated again or undone:

- A record whose `stands_on` is not what the profile comes to is left out.
- Whoever replaces a lens takes away the place that was fitted with the lens before, whether
  the file has it or a record that set both.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from pydantic import JsonValue, ValidationError

from calibration.errors import CalibrationError
from calibration.record import CalibrationRecord, Support
from cell.profile import CellProfile

ProfileT = TypeVar("ProfileT", bound=CellProfile)

_FITTED_WITH_LENS: Final = ("place", "mount")
"""Fields of a camera that mean nothing without the lens they were fitted with."""


class Misfit(CalibrationError):
    """A calibration does not fit the profile any more.

    Attributes:
        record: The calibration.
        problem: Why, as a sentence.
    """

    def __init__(self, record: CalibrationRecord, problem: str, remedy: str = "") -> None:
        self.record = record
        self.problem = problem
        instead = remedy or (
            "calibrate again, or take it out of force with "
            f"`cell calibration undo {record.kind} {record.subject}`"
        )
        super().__init__(
            f"calibration {record.identity[:8]} ({record.kind} of {record.subject}) does not fit "
            f"the profile: {problem}; {instead}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StaleValue:
    """A value that was taken away because the lens it was fitted with was replaced.

    Attributes:
        path: Its path in the profile.
        record: The calibration that set it; None for the cell's file.
        replaced_by: The calibration that set another lens.
    """

    path: str
    record: CalibrationRecord | None
    replaced_by: CalibrationRecord

    def __str__(self) -> str:
        camera, field = self.path.split(".")[1:]
        other = self.replaced_by
        if self.record is None:
            whose, again = "of the cell's file", "`cell calibrate homography`"
        else:
            whose = f"of calibration {self.record.identity[:8]} ({self.record.kind})"
            again = f"`cell calibrate {self.record.kind}`"
        return (
            f"the {field} of camera {camera} {whose} was fitted with another lens than that of "
            f"calibration {other.identity[:8]} ({other.kind}), which is in force, and is left "
            f"out; run {again} again, or take the lens back with "
            f"`cell calibration undo {other.kind} {other.subject}`"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated(Generic[ProfileT]):
    """A profile with what is known of its cell.

    Attributes:
        profile: The profile, with the values of calibrations in the place of its own.
        records: The calibrations that it has, oldest first.
        misfits: Those that do not fit and were left out.
        stale: Single values that were left out because the lens they belong to was replaced.
    """

    profile: ProfileT
    records: tuple[CalibrationRecord, ...] = ()
    misfits: tuple[Misfit, ...] = ()
    stale: tuple[StaleValue, ...] = ()


def calibrated_profile(profile: ProfileT, records: Iterable[CalibrationRecord]) -> ProfileT:
    """Return a profile with the values of calibrations in the place of its own.

    Args:
        profile: What the cell's file says.
        records: Calibrations in force; of two that set the same value, the later one counts.

    Raises:
        Misfit: A record belongs to another cell or another camera, sets what the profile has
            not or cannot have, or was made with what is not in force any more.
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
    ordered = sorted(records, key=lambda one: one.measured_at)
    misfits: list[Misfit] = []
    while True:
        found = _all_applied(profile, ordered)
        misfits += found.misfits
        unsupported = _first_unsupported(found.profile, found.records)
        if unsupported is None:
            break
        # Another one may stand on what this one set: begin again without it.
        misfits.append(unsupported)
        ordered = [one for one in found.records if one is not unsupported.record]
    return Calibrated(
        profile=found.profile,
        records=found.records,
        misfits=tuple(sorted(misfits, key=lambda one: one.record.measured_at)),
        stale=found.stale,
    )


def setters(records: Iterable[CalibrationRecord]) -> dict[str, CalibrationRecord]:
    """Return by which calibration each calibrated value of the profile is in force.

    Args:
        records: Calibrations that fit, in any order.
    """
    found: dict[str, CalibrationRecord] = {}
    for record in sorted(records, key=lambda one: one.measured_at):
        for path in record.values:
            lens = found.get(path)
            if lens is None or lens.values[path] != record.values[path]:
                for tied in _tied_to(path):
                    found.pop(tied, None)
        found |= dict.fromkeys(record.values, record)
    return found


def _all_applied(profile: ProfileT, records: Sequence[CalibrationRecord]) -> Calibrated[ProfileT]:
    """Return a profile with the values of records, whether or not what they stand on is there."""
    used: list[CalibrationRecord] = []
    misfits: list[Misfit] = []
    stale: dict[str, StaleValue] = {}
    for record in records:
        try:
            after, lost = _with_values(profile, record)
        except Misfit as misfit:
            misfits.append(misfit)
            continue
        by = setters(used)
        stale = {path: one for path, one in stale.items() if path not in record.values}
        stale |= {
            path: StaleValue(path=path, record=by.get(path), replaced_by=record) for path in lost
        }
        profile = after
        used.append(record)
    return Calibrated(
        profile=profile, records=tuple(used), misfits=tuple(misfits), stale=tuple(stale.values())
    )


def _first_unsupported(profile: CellProfile, records: Sequence[CalibrationRecord]) -> Misfit | None:
    """Return the oldest record that counts and stands on what the profile has not."""
    if not any(record.stands_on for record in records):
        return None
    data = profile.model_dump(mode="json")
    by = setters(records)
    for record in records:
        for support in record.stands_on:
            own = [path for path in _tied_to(support.path) if path in record.values]
            # What a later calibration sets in its place does no harm.
            counts = any(by.get(path, record) is record for path in own or record.values)
            if counts and _value_at(data, support.path) != support.value:
                return _unsupported(record, support, by.get(support.path))
    return None


def _unsupported(
    record: CalibrationRecord, support: Support, now: CalibrationRecord | None
) -> Misfit:
    *_, subject, what = support.path.split(".")
    name = f"{what} {support.record[:8]}" if support.record else f"{what} of the cell's file"
    remedy = ""
    if now is not None:
        remedy = (
            f"calibrate it again, or take {now.identity[:8]} back with "
            f"`cell calibration undo {now.kind} {now.subject}`"
        )
    return Misfit(
        record, f"it was made with the {name} of {subject}, which is not in force any more", remedy
    )


def _with_values(profile: ProfileT, record: CalibrationRecord) -> tuple[ProfileT, tuple[str, ...]]:
    """Return a profile with a record's values, and which values its lens took away."""
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
        return profile, ()
    before = profile.model_dump(mode="json")
    data = profile.model_dump(mode="json")
    for path, value in record.values.items():
        _set(data, path, value, record)
    lost = []
    try:
        after = type(profile).model_validate(data)
        normal = after.model_dump(mode="json")
        for path in record.values:
            if _value_at(normal, path) == _value_at(before, path):
                continue
            for tied in _tied_to(path):
                if tied not in record.values and _value_at(before, tied) is not None:
                    lost.append(tied)
                    _set(data, tied, None, record)
        return (type(profile).model_validate(data) if lost else after), tuple(lost)
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


def _tied_to(path: str) -> tuple[str, ...]:
    """Return the values that mean nothing without the one at a path."""
    parents, _, last = path.rpartition(".")
    if last != "lens" or not parents.startswith("cameras."):
        return ()
    return tuple(f"{parents}.{field}" for field in _FITTED_WITH_LENS)


def _value_at(data: JsonValue, path: str) -> JsonValue:
    for name in path.split("."):
        data = data.get(name) if isinstance(data, dict) else None
    return data
