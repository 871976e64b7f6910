"""The markers that tell where a sheet lies and which sheet it is.

Each sheet has up to twelve ArUco markers of the dictionary 4X4_1000. A marker's id says
which of the sheet's markers it is and holds one digit, 0 to 74, of the plan's checksum:

    id = 100 + 75 · index + digit

Ids below 100 are left to others. Two markers in view tell a print of another plan from
this one but for one case in 5,625, three but for one in 420,000.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Final

import cv2
import numpy as np

from cell.profile import BlockProfile
from cell.store import StoreSlot

DICTIONARY: Final = cv2.aruco.DICT_4X4_1000
MODULES: Final = 6
"""Modules along a marker's side, its black border included."""
MOST: Final = 12
"""Most markers on a sheet."""
_FORMAT: Final = "store sheet 1"
"""Changes whenever the same plan is drawn with its markers elsewhere."""
_FIRST_ID: Final = 100
_DIGITS: Final = 75


@dataclass(frozen=True, slots=True, kw_only=True)
class Fiducial:
    """One marker of a sheet.

    Attributes:
        index: Which of the sheet's markers it is, from 0.
        marker_id: Its id in the dictionary.
        x_mm: Plan x of its middle.
        y_mm: Plan y of its middle.
        size_mm: Its side, the black border included.
    """

    index: int
    marker_id: int
    x_mm: float
    y_mm: float
    size_mm: float

    @property
    def corners_mm(self) -> tuple[tuple[float, float], ...]:
        """Its corners in plan x, y: upper left, upper right, lower right, lower left."""
        half = self.size_mm / 2
        left, right = self.x_mm - half, self.x_mm + half
        top, low = self.y_mm - half, self.y_mm + half
        return ((left, top), (right, top), (right, low), (left, low))


def identity_of(slots: Sequence[StoreSlot], blocks: Mapping[str, BlockProfile]) -> str:
    """Return the checksum of a plan: what is drawn where, and in which size.

    Args:
        slots: The places of the plan.
        blocks: Sizes of the kinds of blocks.
    """
    lines = [_FORMAT]
    for slot in sorted(slots, key=lambda one: one.number):
        size = blocks[slot.kind]
        lines.append(
            f"{slot.number} {slot.kind} {slot.colour} {slot.x_mm:.2f} {slot.y_mm:.2f} "
            f"{size.shape} {size.length_mm:.2f} {size.width_mm:.2f}"
        )
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


def marker_id(identity: str, index: int) -> int:
    """Return the id of a sheet's marker."""
    digest = hashlib.sha256(f"{identity} {index}".encode()).digest()
    return _FIRST_ID + _DIGITS * index + int.from_bytes(digest[:4], "big") % _DIGITS


def index_of(found_id: int) -> int | None:
    """Return which of a sheet's markers has an id, None if no sheet has such a marker."""
    index = (found_id - _FIRST_ID) // _DIGITS
    return index if found_id >= _FIRST_ID and index < MOST else None


@lru_cache(maxsize=64)
def marker_rows(found_id: int) -> tuple[tuple[bool, ...], ...]:
    """Return the modules of a marker, True for black, its border included."""
    image = cv2.aruco.generateImageMarker(marker_dictionary(), found_id, MODULES)
    return tuple(tuple(bool(value == 0) for value in row) for row in np.asarray(image))


@cache
def marker_dictionary() -> cv2.aruco.Dictionary:
    """Return the dictionary of the sheets' markers; made once."""
    return cv2.aruco.getPredefinedDictionary(DICTIONARY)
