"""How two profiles differ: field by field, by meaning and not by their text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from cell.profile.cell import CellProfile
from cell.profile.findings import dotted
from cell.profile.listing import Leaf, field_unit, leaves_of
from cell.profile.toml_places import KeyPath


class Absent:
    """Stands for a field that a profile does not have."""


ABSENT: Final = Absent()


@dataclass(frozen=True, slots=True)
class Difference:
    """A field in which two profiles differ.

    Attributes:
        path: Its keys; boxes go by their names.
        first: Its value in the first profile.
        second: Its value in the second.
        unit: Its unit, or an empty string.
    """

    path: KeyPath
    first: Leaf | Absent
    second: Leaf | Absent
    unit: str

    @property
    def field(self) -> str:
        """The path as people write it."""
        return dotted(self.path)


def differences(first: CellProfile, second: CellProfile) -> tuple[Difference, ...]:
    """Return in which fields two profiles differ, defaults filled in.

    Order and form of the text do not matter, nor the order of boxes, nor whether a default
    is written out. A table that only one of them has is one difference a field.
    """
    before, after = _by_meaning(first), _by_meaning(second)
    paths = [*before, *(path for path in after if path not in before)]
    found = []
    for path in paths:
        one, other = before.get(path, ABSENT), after.get(path, ABSENT)
        if one == other or _is_left_out(one, path, after) or _is_left_out(other, path, before):
            continue
        found.append(Difference(path, one, other, field_unit(path)))
    return tuple(found)


def _by_meaning(profile: CellProfile) -> dict[KeyPath, Leaf]:
    """Return all values; a box goes by its name instead of its number."""
    named: dict[KeyPath, Leaf] = {}
    for path, value in leaves_of(profile):
        if path[0] == "boxes" and len(path) > 1 and isinstance(path[1], int):
            path = ("boxes", profile.boxes[path[1]].name, *path[2:])
        if path != ("boxes",):
            named[path] = value
    return named


def _is_left_out(value: Leaf | Absent, path: KeyPath, other: dict[KeyPath, Leaf]) -> bool:
    """Return whether a table that is not there here is told field by field there."""
    return value is None and any(p[: len(path)] == path and p != path for p in other)
