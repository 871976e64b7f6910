"""How good a calibration is: a grade, and what was found, each thing by its name."""

from __future__ import annotations

import enum
from collections.abc import Iterable

from pydantic import BaseModel, ConfigDict


class Grade(enum.StrEnum):
    """What may be relied on."""

    OK = "OK"
    """As good as it should be."""
    DEGRADED = "DEGRADED"
    """Usable; something should be looked at."""
    BAD = "BAD"
    """Not to be used."""

    @property
    def severity(self) -> int:
        """0 for OK, 1 for DEGRADED, 2 for BAD."""
        return (Grade.OK, Grade.DEGRADED, Grade.BAD).index(self)


class Finding(BaseModel):
    """One thing that was found."""

    model_config = ConfigDict(frozen=True)

    code: str
    """Its name, such as `swapped-pair`; the same words in every version."""
    grade: Grade
    """How much it weighs."""
    text: str
    """What is wrong, where, with figures."""
    hint: str = ""
    """What to do."""
    samples: tuple[str, ...] = ()
    """Labels of the samples that it is about."""

    def __str__(self) -> str:
        return f"{self.grade}: {self.text}" + (f"; {self.hint}" if self.hint else "")


def worst(findings: Iterable[Finding]) -> Grade:
    """Return the worst grade, OK if nothing was found."""
    return max((f.grade for f in findings), key=lambda g: g.severity, default=Grade.OK)
