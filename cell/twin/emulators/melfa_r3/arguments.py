"""Arguments of requests as the emulated controller reads them."""

from __future__ import annotations

from cell.drivers.melfa_r3 import tables
from cell.twin.emulators.melfa_r3.refusal import Refusal


def number_of(text: str) -> int:
    """Return a number without a sign.

    Raises:
        Refusal: It is none.
    """
    if not (text.isascii() and text.isdigit() and len(text) <= 9):
        raise Refusal(tables.ARGUMENT_TYPE)
    return int(text)
