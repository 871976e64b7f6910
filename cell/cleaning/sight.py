"""What a look at the playground came to, in the robot frame: blocks, and what is no block."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cell.contact import Footprint, Outline, Point
from cell.profile import BlockProfile
from cell.store import TablePlace


@dataclass(frozen=True, slots=True, kw_only=True)
class LyingBlock:
    """A block that lies on the playground.

    Attributes:
        kind: Its kind.
        colour: Its colour.
        body: Its outline from above, in the robot frame.
        deviation_mm: Standard deviation of its middle.
        deviation_deg: Standard deviation of its yaw.
    """

    kind: str
    colour: str
    body: Footprint
    deviation_mm: float = 0.5
    deviation_deg: float = 0.7

    @property
    def place(self) -> TablePlace:
        """Where its middle is and how it is turned."""
        return TablePlace(x_mm=self.body.x_mm, y_mm=self.body.y_mm, yaw_deg=self.body.yaw_deg)

    @property
    def where(self) -> str:
        """Its middle, for people."""
        return f"({round(self.body.x_mm)}, {round(self.body.y_mm)}) mm"

    @property
    def name(self) -> str:
        """Its colour and kind, for people."""
        return f"{self.colour} {self.kind}"

    def moved(self, shift: Point) -> LyingBlock:
        """Return it as it lies after a shift."""
        body = self.body
        return replace(
            self, body=replace(body, x_mm=body.x_mm + shift[0], y_mm=body.y_mm + shift[1])
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StrangeThing:
    """Something on the playground that is no block one could tell; it is never gripped.

    Attributes:
        reason: Why it was not recognised.
        x_mm: Robot x of its middle.
        y_mm: Robot y of its middle.
        edge: Small pieces that cover its outline; it need not be convex.
        corners: Its outline.
    """

    reason: str
    x_mm: float
    y_mm: float
    edge: tuple[Outline, ...] = ()
    corners: tuple[Point, ...] = ()

    @property
    def where(self) -> str:
        """Its middle, for people."""
        return f"({round(self.x_mm)}, {round(self.y_mm)}) mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class Playground:
    """What lies on the playground.

    Attributes:
        blocks: The blocks.
        strange: What was not recognised.
    """

    blocks: tuple[LyingBlock, ...]
    strange: tuple[StrangeThing, ...] = ()

    @property
    def obstacles(self) -> tuple[Outline, ...]:
        """What covers the outlines of everything that is no block."""
        return tuple(piece for thing in self.strange for piece in thing.edge)


def body_of(
    kinds: Mapping[str, BlockProfile], kind: str, x_mm: float, y_mm: float, yaw_deg: float
) -> Footprint:
    """Return the outline of a block of a kind at a place."""
    sizes = kinds[kind]
    return Footprint(
        x_mm=x_mm,
        y_mm=y_mm,
        yaw_deg=yaw_deg,
        length_mm=sizes.length_mm,
        width_mm=sizes.width_mm,
        is_round=sizes.shape == "cylinder",
    )
