"""The blocks of the twin: where each lies, and what happens when one is pushed or dropped."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from cell.contact import Footprint, Polygon, push_out
from cell.profile import BlockProfile

_CASCADE_ROUNDS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class TwinBlock:
    """One block of the twin.

    Attributes:
        block: Identity, such as `slot 7`.
        kind: Kind in the profile's table.
        colour: Its paint.
        x_mm: Robot x of its centre.
        y_mm: Robot y of its centre.
        z_mm: Height of its bottom face.
        yaw_deg: Turn of its length from robot x.
    """

    block: str
    kind: str
    colour: str
    x_mm: float
    y_mm: float
    z_mm: float
    yaw_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Shove:
    """A block that something pushed.

    Attributes:
        block: Its identity.
        top_mm: Height of its top face.
        low_mm: Height of the lower end of what pushed it.
        overlap_mm: How far the two were in each other.
        is_jammed: Whether blocks were left in each other for want of room.
    """

    block: str
    top_mm: float
    low_mm: float
    overlap_mm: float
    is_jammed: bool


class BlockField:
    """All blocks, and the physics between them.

    Blocks stay upright: a pushed one slides until it is free, a dropped one comes
    to rest on whatever its centre is over, and slides off what it merely touches.
    """

    def __init__(
        self,
        blocks: Iterable[TwinBlock],
        kinds: Mapping[str, BlockProfile],
        surface_mm: float,
    ) -> None:
        self._blocks = {block.block: block for block in blocks}
        self._kinds = kinds
        self._radii_mm = {
            name: 0.5 * math.hypot(kind.length_mm, kind.width_mm) for name, kind in kinds.items()
        }
        self._surface_mm = surface_mm
        self._highest_mm: float | None = None
        self.revision = 0

    def all(self) -> tuple[TwinBlock, ...]:
        """Return every block."""
        return tuple(self._blocks.values())

    def get(self, name: str) -> TwinBlock:
        """Return one block by its identity."""
        return self._blocks[name]

    def put(self, block: TwinBlock) -> None:
        """Set where a block is, without any physics."""
        self._blocks[block.block] = block
        self._highest_mm = None
        self.revision += 1

    def kind(self, block: TwinBlock) -> BlockProfile:
        """Return the sizes of a block."""
        return self._kinds[block.kind]

    def top_mm(self, block: TwinBlock) -> float:
        """Return the height of a block's top face."""
        return block.z_mm + self._kinds[block.kind].height_mm

    def highest_mm(self) -> float:
        """Return the height of the highest top face, or of the surface."""
        if self._highest_mm is None:
            tops = (self.top_mm(b) for b in self._blocks.values())
            self._highest_mm = max(tops, default=self._surface_mm)
        return self._highest_mm

    def footprint(self, block: TwinBlock) -> Footprint:
        """Return a block's outline seen from above."""
        kind = self._kinds[block.kind]
        return Footprint(
            x_mm=block.x_mm,
            y_mm=block.y_mm,
            yaw_deg=block.yaw_deg,
            length_mm=kind.length_mm,
            width_mm=kind.width_mm,
            is_round=kind.shape == "cylinder",
        )

    def push(self, tool: Footprint, low_mm: float, *, spare: str | None = None) -> list[Shove]:
        """Push every block out of a tool's footprint that reaches down to `low_mm`.

        Args:
            tool: Footprint of what pushes.
            low_mm: Height of its lower end.
            spare: A block that hangs between the fingers and is not pushed.

        Returns:
            What was pushed, where the blocks are free by now.
        """
        shoved: list[Shove] = []
        # The hand asks this all along its way, and nearly all blocks are far from it: they
        # are passed over by the sizes of their kind, before anything is made of them.
        outline: Polygon | None = None
        x_mm, y_mm, radius_mm = tool.x_mm, tool.y_mm, tool.radius_mm
        for name in list(self._blocks):
            block = self._blocks[name]
            reach_mm = radius_mm + self._radii_mm[block.kind]
            dx_mm = block.x_mm - x_mm
            if abs(dx_mm) > reach_mm or math.hypot(dx_mm, block.y_mm - y_mm) > reach_mm:
                continue
            if name == spare or low_mm >= self.top_mm(block) - 1.0:
                continue
            outline = outline or tool.polygon()
            shift = push_out(self.footprint(block).polygon(), outline)
            if shift is not None:
                self._slide(name, shift)
                shoved.append(
                    Shove(
                        block=name,
                        top_mm=self.top_mm(block),
                        low_mm=low_mm,
                        overlap_mm=math.hypot(*shift),
                        is_jammed=not self._spread(name, spare),
                    )
                )
        return shoved

    def make_room(self, name: str) -> None:
        """Push aside what a block was turned or drawn into."""
        self._spread(name, None)

    def drop(
        self, name: str, generator: random.Random, scatter_mm: float, scatter_deg: float
    ) -> None:
        """Let a block fall from where it is until it rests.

        A higher fall scatters more: by a tenth of its height beyond 2 mm (ours).
        """
        block = self._blocks[name]
        fall_mm = max(0.0, block.z_mm - self._support_mm(block) - 2.0)
        spread_mm = scatter_mm + 0.1 * fall_mm if scatter_mm > 0 else 0.0
        spread_deg = scatter_deg + 0.1 * fall_mm if scatter_deg > 0 else 0.0
        fallen = replace(
            block,
            x_mm=block.x_mm + generator.gauss(0.0, spread_mm),
            y_mm=block.y_mm + generator.gauss(0.0, spread_mm),
            yaw_deg=block.yaw_deg + generator.gauss(0.0, spread_deg),
        )
        self.put(replace(fallen, z_mm=self._support_mm(fallen)))
        self._spread(name, None)

    def _support_mm(self, block: TwinBlock) -> float:
        """Return the height on which a block at this place comes to rest."""
        return max(
            (
                self.top_mm(other)
                for other in self._blocks.values()
                if other.block != block.block
                and self.top_mm(other) <= block.z_mm + 2.0
                and self.footprint(other).contains(block.x_mm, block.y_mm)
            ),
            default=self._surface_mm,
        )

    def _slide(self, name: str, shift: tuple[float, float]) -> None:
        block = self._blocks[name]
        self.put(replace(block, x_mm=block.x_mm + shift[0], y_mm=block.y_mm + shift[1]))

    def _spread(self, first: str, spare: str | None) -> bool:
        """Push on what a moved block has run into; return whether nothing overlaps then."""
        pushers = [first]
        for _ in range(_CASCADE_ROUNDS):
            if not pushers:
                return True
            pusher = self._blocks[pushers.pop()]
            own = self.footprint(pusher)
            outline = own.polygon()
            for name, other in list(self._blocks.items()):
                if name in (pusher.block, spare) or not self._share_height(pusher, other):
                    continue
                footprint = self.footprint(other)
                distance_mm = math.hypot(other.x_mm - pusher.x_mm, other.y_mm - pusher.y_mm)
                if distance_mm > own.radius_mm + footprint.radius_mm:
                    continue
                shift = push_out(footprint.polygon(), outline)
                if shift is not None:
                    self._slide(name, shift)
                    pushers.append(name)
        return not pushers

    def _share_height(self, one: TwinBlock, other: TwinBlock) -> bool:
        return one.z_mm < self.top_mm(other) - 1.0 and other.z_mm < self.top_mm(one) - 1.0
