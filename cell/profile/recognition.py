"""What a camera of this cell has learned of the blocks: colours, and their size in the picture."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cell.profile.table import Colour, Kind, NotNegative, Table, Text

Triple = tuple[float, float, float]


class LearnedColourProfile(Table):
    """One colour: a normal distribution of (ln R/G, ln B/G, ln G) of a block's upper face."""

    mean: Triple
    """Its middle."""
    covariance: tuple[Triple, Triple, Triple]
    """Its covariance."""


class LearnedKindProfile(Table):
    """One kind of block: what regions of the white-minus-black method are."""

    area_px: tuple[NotNegative, NotNegative]
    """Least and greatest area in the picture of 1280 x 960 pixels."""
    circularity: tuple[NotNegative, NotNegative]
    """Least and greatest 4πA/P²."""


class RecognitionProfile(Table):
    """What was learned of the blocks; without it the reference's tables are taken."""

    camera: Text
    """Name of the camera that it holds for."""
    origin: Text
    """Where the figures come from."""
    most_distance: Annotated[float, Field(gt=0)] = 4.0
    """Faces farther than this many standard deviations from every colour have none."""
    colours: dict[Colour, LearnedColourProfile]
    """The colours by name."""
    kinds: dict[Kind, LearnedKindProfile] = {}
    """The kinds of blocks by name."""
