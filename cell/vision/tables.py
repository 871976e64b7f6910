"""What the blocks look like from above: kinds by area and circularity, colours by channels.

Source: Dubec 2011, section 5.6, tables 5.2 (kinds) and 5.3 (colours), for the
top camera's picture of 1280 x 960 pixels (0.58 mm a pixel at the block tops). The
bounds belong to their ranges. Ranges of two kinds, or of two colours, never overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Range:
    """A closed range of numbers."""

    low: float
    high: float

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


@dataclass(frozen=True, slots=True, kw_only=True)
class KindRange:
    """What makes a region one kind of block.

    Attributes:
        kind: Kind in the profile's table of blocks.
        area_px: Area of the region.
        circularity: 4πA/P² of the region.
        symmetry_deg: Turn after which the top face looks the same; 0 when every turn does.
    """

    kind: str
    area_px: Range
    circularity: Range
    symmetry_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourRange:
    """What makes a region one colour: the mean of each channel in grey levels."""

    colour: str
    red: Range
    green: Range
    blue: Range


KINDS = (
    KindRange(
        kind="cube", area_px=Range(2800, 3200), circularity=Range(0.65, 0.85), symmetry_deg=90
    ),
    KindRange(
        kind="cylinder", area_px=Range(2100, 2600), circularity=Range(0.85, 1.0), symmetry_deg=0
    ),
    KindRange(
        kind="bridge", area_px=Range(9200, 9600), circularity=Range(0.4, 0.65), symmetry_deg=180
    ),
)
"""Table 5.2; the symmetries follow from the shapes."""

COLOURS = (
    ColourRange(colour="blue", red=Range(20, 55), green=Range(40, 75), blue=Range(85, 135)),
    ColourRange(colour="natural", red=Range(145, 190), green=Range(125, 170), blue=Range(100, 140)),
    ColourRange(colour="yellow", red=Range(175, 230), green=Range(150, 200), blue=Range(40, 80)),
    ColourRange(colour="green", red=Range(55, 120), green=Range(110, 160), blue=Range(40, 80)),
    ColourRange(colour="red", red=Range(155, 220), green=Range(45, 75), blue=Range(35, 60)),
)
"""Table 5.3."""

UNKNOWN_SYMMETRY_DEG = 180.0
"""Symmetry taken for a region of no known kind: its major axis has two directions."""


def kind_of(
    area_px: float, circularity: float, kinds: Sequence[KindRange] = KINDS
) -> KindRange | None:
    """Return the kind with this area and circularity, None outside the table."""
    for kind in kinds:
        if area_px in kind.area_px and circularity in kind.circularity:
            return kind
    return None


def colour_of(
    mean_rgb: tuple[float, float, float], colours: Sequence[ColourRange] = COLOURS
) -> str | None:
    """Return the colour with these channel means, None outside the table."""
    red, green, blue = mean_rgb
    for colour in colours:
        if red in colour.red and green in colour.green and blue in colour.blue:
            return colour.colour
    return None


def symmetry_deg(kind: str | None, kinds: Sequence[KindRange] = KINDS) -> float:
    """Return the turn after which a kind's top face looks the same, 0 for every turn."""
    for known in kinds:
        if known.kind == kind:
            return known.symmetry_deg
    return UNKNOWN_SYMMETRY_DEG


def fold_deg(angle_deg: float, symmetry: float) -> float:
    """Return the angle that looks the same and lies in [-symmetry/2, symmetry/2)."""
    if symmetry == 0.0:
        return 0.0
    half = symmetry / 2.0
    # Rounding can carry a tiny negative remainder up to the full period.
    folded = (angle_deg + half) % symmetry - half
    return folded if folded < half else -half
