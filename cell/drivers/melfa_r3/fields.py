"""Single fields of replies; what is wrong raises ValueError for the record's parser."""

from __future__ import annotations

import math


def finite_field(field: str) -> float:
    """Return a finite number."""
    number = float(field)
    if not math.isfinite(number):
        raise ValueError(field)
    return number


def whole_field(field: str) -> int:
    """Return a whole number without a sign."""
    if not (field.isascii() and field.isdigit() and len(field) <= 9):
        raise ValueError(field)
    return int(field)


def flags_field(field: str) -> tuple[int, int] | None:
    """Return FL1 and FL2, None where the controller prints stars or nothing."""
    if field in {"****,****", ""}:
        return None
    first, second = field.split(",")
    return int(first), int(second)
