"""Every value of a profile, one by one, and where each came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cell.profile.cell import CellProfile
from cell.profile.checking import CheckedProfile
from cell.profile.findings import dotted
from cell.profile.schema import unit_of
from cell.profile.toml_places import KeyPath, TomlPlaces

Leaf = str | int | float | bool | list[object] | None


@dataclass(frozen=True, slots=True)
class ListedValue:
    """One value of a profile.

    Attributes:
        path: Its keys.
        value: The value, as TOML would hold it; None for a table that is left out.
        unit: Its unit, or an empty string.
        line: The line that it is written in; None for a default.
    """

    path: KeyPath
    value: Leaf
    unit: str
    line: int | None

    @property
    def field(self) -> str:
        """The path as people write it."""
        return dotted(self.path)


def listed_values(checked: CheckedProfile) -> tuple[ListedValue, ...]:
    """Return every value of a profile, defaults filled in.

    Raises:
        InvalidProfile: The profile has mistakes.
    """
    profile = checked.require()
    return tuple(
        ListedValue(path, value, field_unit(path), _line_of(path, checked.places))
        for path, value in leaves_of(profile)
    )


def leaves_of(profile: CellProfile) -> Iterator[tuple[KeyPath, Leaf]]:
    """Yield path and value of everything in a profile that is no table."""
    return _leaves((), profile.model_dump(mode="json"))


def field_unit(path: KeyPath) -> str:
    """Return the unit of the value at a path, or an empty string."""
    names = [part for part in path if isinstance(part, str)]
    return unit_of(names[-1]) if names else ""


def _leaves(path: KeyPath, value: object) -> Iterator[tuple[KeyPath, Leaf]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves((*path, key), inner)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for number, inner in enumerate(value):
            yield from _leaves((*path, number), inner)
    elif value is None or isinstance(value, (str, int, float, bool, list)):
        yield path, value


def _line_of(path: KeyPath, places: TomlPlaces) -> int | None:
    place = places.values.get(path)
    return None if place is None else place.line
