"""What breaks a rule, and what a rule is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cell.profile.cell import CellProfile, Profile
from cell.profile.findings import Severity
from cell.profile.toml_places import KeyPath


@dataclass(frozen=True, slots=True)
class Problem:
    """What does not go together.

    Attributes:
        path: The field that is to be changed.
        message: What is wrong and what is allowed.
        hint: What to do, or an empty string.
        other: The field that it does not go together with.
        severity: Whether it keeps the profile from being used.
    """

    path: KeyPath
    message: str
    hint: str = ""
    other: KeyPath | None = None
    severity: Severity = "error"


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule.

    Attributes:
        needs: The tables it looks at.
        check: Finds what breaks it, on a profile in which at least these tables are there.
    """

    needs: tuple[str, ...]
    check: Callable[[CellProfile], Iterator[Problem]]


@dataclass(frozen=True, slots=True)
class PlaygroundRule:
    """One rule of cells with a playground."""

    needs: tuple[str, ...]
    check: Callable[[Profile], Iterator[Problem]]
