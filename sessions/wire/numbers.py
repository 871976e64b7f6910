"""Numbers in a line."""

from __future__ import annotations

import re
from decimal import Decimal
from functools import lru_cache

from sessions.errors import LocalProtocolError, RemoteProtocolError

MAX_SEED = 2**32 - 1
"""The largest seed that `USE_GLOBAL_SEED` takes (an unsigned 32-bit number)."""

_COUNT = re.compile(r"[0-9]{1,10}")
_DECIMAL = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")


@lru_cache(maxsize=1024)
def format_reward(reward: float) -> str:
    """Return the shortest decimal that reads back to the same float.

    Integers come without a point, and nothing comes with an exponent: `0`, `-10`,
    `0.25`.

    Raises:
        LocalProtocolError: The reward is infinite or not a number.
    """
    value = Decimal(repr(float(reward)))
    if not value.is_finite():
        raise LocalProtocolError(f"a reward must be a finite number, not {reward!r}")
    if value == 0:
        return "0"
    text = format(value, "f")
    return text.rstrip("0").rstrip(".") if "." in text else text


def parse_reward(word: str) -> float:
    """Return the float that a reward's decimal stands for.

    Raises:
        RemoteProtocolError: The word is not a decimal number.
    """
    if _DECIMAL.fullmatch(word) is None:
        raise RemoteProtocolError(f"a reward must be a decimal number, not {word!r}")
    return float(word)


def parse_count(word: str, largest: int = MAX_SEED) -> int:
    """Return an unsigned decimal number, up to `largest`.

    Raises:
        RemoteProtocolError: The word is not such a number.
    """
    if _COUNT.fullmatch(word) is None or int(word) > largest:
        raise RemoteProtocolError(f"a whole number from 0 to {largest} is wanted, not {word!r}")
    return int(word)
