"""How blocks are looked for in the pictures of the top camera."""

from __future__ import annotations

from dataclasses import dataclass

PICTURE_WIDTH_PX = 1280
PICTURE_HEIGHT_PX = 960
"""Size of the pictures that the tables of areas speak of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecognitionSettings:
    """Figures of the white-minus-black method.

    The defaults are those of Dubec 2011, section 5.6, except where said.

    Attributes:
        first_row: First picture row that is looked at.
        end_row: Row after the last one that is looked at.
        threshold_share: A pixel is lit by the screen when white minus black exceeds this
            share of the screen's level. Ours: low, so that the light which the optics
            spread over a block's edge gives away about one pixel of it; the areas of the
            recognition table have that loss in them.
        least_area_px: Smaller regions are dropped unseen.
        edge_px: How far from its edge a region's colour is measured. Ours.
        least_screen_level: Grey levels by which a lit screen must at least differ from a
            black one. Ours.
        least_screen_px: A connected part of the lit screen has at least this area; holes
            in smaller lit spots, such as a mirror image, are no blocks. Ours.
        least_lit_level: Block-shaped regions whose brightest channel stays below this in
            the black picture are unlit; half of the darkest colour's bound. Ours.
    """

    first_row: int = 60
    end_row: int = 870
    threshold_share: float = 0.15
    least_area_px: int = 200
    edge_px: int = 2
    least_screen_level: float = 60.0
    least_screen_px: int = 20_000
    least_lit_level: float = 42.0

    def __post_init__(self) -> None:
        if not 0 <= self.first_row < self.end_row <= PICTURE_HEIGHT_PX:
            raise ValueError(
                f"rows {self.first_row} to {self.end_row} do not lie in a picture of "
                f"{PICTURE_HEIGHT_PX} rows"
            )
        if not 0.0 < self.threshold_share < 1.0:
            raise ValueError(f"the threshold share must lie in 0..1, not {self.threshold_share}")
        if self.least_area_px < 1 or self.edge_px < 0:
            raise ValueError("the least area is at least 1 px and the edge at least 0 px")
