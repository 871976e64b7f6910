"""Numbers as they are typed: what is no number, or no whole one where one is meant, is refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

from cyclopts import Parameter, Token


def _finite(kind: object, tokens: Sequence[Token]) -> float:
    """Return a number; `nan` and `inf` are none that a device could take."""
    value = float(tokens[0].value)
    if not math.isfinite(value):
        raise ValueError(f"{tokens[0].value!r} is no number that can be reached")
    return value


def _whole(kind: object, tokens: Sequence[Token]) -> int:
    """Return a whole number; others are not rounded."""
    return int(tokens[0].value)


Figure = Annotated[float, Parameter(converter=_finite, n_tokens=1, allow_leading_hyphen=True)]
Whole = Annotated[int, Parameter(converter=_whole, n_tokens=1, allow_leading_hyphen=True)]
