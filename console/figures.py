"""Numbers as they are typed: what is no number, or no whole one where one is meant, is refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from cyclopts import Parameter, Token

_MOST_WHOLE = 10**15
"""Above, not every whole number has a float of its own."""
_SHOWN = 40


def _finite(kind: object, tokens: Sequence[Token]) -> float:
    """Return a number; `nan` and `inf` are none that a device could take."""
    text = tokens[0].value
    try:
        value = float(text)
    except ValueError as error:
        comma = "; write a decimal point instead of the comma" if "," in text else ""
        raise ValueError(
            f"{_short(text)} is no number; a number with a decimal point is "
            f"expected, such as 12.5{comma}"
        ) from error
    if not math.isfinite(value):
        raise ValueError(f"{_short(text)} is no number that can be reached")
    return value


def _whole(kind: object, tokens: Sequence[Token]) -> int:
    """Return a whole number; others are not rounded."""
    text = tokens[0].value
    try:
        value = int(text)
    except ValueError as error:
        raise ValueError(
            f"{_short(text)} is no whole number; one without a decimal point "
            "is expected, such as 12"
        ) from error
    if abs(value) > _MOST_WHOLE:
        raise ValueError(f"{_short(text)} is no number that can be reached")
    return value


def _short(text: str) -> str:
    """Return what was typed in quotes, cut where it is endless."""
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}...")


Figure = Annotated[float, Parameter(converter=_finite, n_tokens=1, allow_leading_hyphen=True)]
Whole = Annotated[int, Parameter(converter=_whole, n_tokens=1, allow_leading_hyphen=True)]
