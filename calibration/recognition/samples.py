"""One block seen at one place: what it is known to be, and what the camera measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.store import StoreSlot
from cell.vision.blocks import SeenBlock
from cell.vision.colour_model import normalised
from cell.vision.tables import colour_of, kind_of

_NEAR_PX = 45.0
_CLIPPED_LEVEL = 250.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockSample:
    """A block that was seen.

    Attributes:
        slot: Number of the slot it belongs to.
        kind: Its kind, as the store knows it.
        colour: Its colour, as the store knows it.
        label: Of the look it was seen in.
        u_px: Where, column.
        v_px: Where, row.
        mean_rgb: Means of the channels of its face.
        area_px: Area of its region.
        circularity: 4πA/P² of its region.
    """

    slot: int
    kind: str
    colour: str
    label: str
    u_px: float
    v_px: float
    mean_rgb: tuple[float, float, float]
    area_px: int
    circularity: float

    @property
    def is_clipped(self) -> bool:
        """Whether a channel is at its end, so that the colour is not known."""
        return max(self.mean_rgb) >= _CLIPPED_LEVEL

    @property
    def features(self) -> tuple[float, float, float]:
        """(ln R/G, ln B/G, ln G)."""
        red, blue, green = normalised(np.array([self.mean_rgb]))[0]
        return float(red), float(blue), float(green)

    @property
    def is_right_by_tables(self) -> tuple[bool, bool]:
        """Whether the reference's tables tell kind and colour."""
        known = kind_of(self.area_px, self.circularity)
        return (
            known is not None and known.kind == self.kind,
            colour_of(self.mean_rgb) == self.colour,
        )


def matched(
    seen: Sequence[SeenBlock],
    expected: Sequence[tuple[StoreSlot, tuple[float, float]]],
    label: str,
) -> tuple[list[BlockSample], list[StoreSlot]]:
    """Return what was seen of blocks at known pixels, and which were not.

    Args:
        seen: What stands on the screen.
        expected: Blocks and where in the picture (u, v) their faces should be.
        label: Of the look.
    """
    samples, missing = [], []
    free = list(seen)
    for slot, (u_px, v_px) in expected:
        near = min(free, key=lambda b: math.hypot(b.u_px - u_px, b.v_px - v_px), default=None)
        if near is None or math.hypot(near.u_px - u_px, near.v_px - v_px) > _NEAR_PX:
            missing.append(slot)
            continue
        free.remove(near)
        samples.append(
            BlockSample(
                slot=slot.number,
                kind=slot.kind,
                colour=slot.colour,
                label=label,
                u_px=near.u_px,
                v_px=near.v_px,
                mean_rgb=near.mean_rgb,
                area_px=near.area_px,
                circularity=near.circularity,
            )
        )
    return samples, missing


def features_of(samples: Sequence[BlockSample]) -> NDArray[np.float64]:
    """Return (ln R/G, ln B/G, ln G) of samples, (n, 3)."""
    return np.array([sample.features for sample in samples]).reshape(-1, 3)
