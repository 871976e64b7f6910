"""The hand of the twin: what closing fingers meet, how a block hangs in them, what they push.

The tool points down; everything is seen from above. The fingers close along the tool's
y axis, turn the nearest face of a box flat, and centre it along that axis only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cell.contact import Jaw, aligned_yaw_deg
from cell.geometry import Pose
from cell.profile import Profile
from cell.twin.blocks import BlockField, Shove, TwinBlock

_FINGER_LENGTH_MM = 50.0
_LEAST_CONTACT_MM = 3.0
_FIT_MM = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """A block between the fingers, relative to the tool point."""

    block: str
    along_mm: float
    across_mm: float
    below_mm: float
    turn_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """How closing fingers end.

    Attributes:
        end_mm: The opening at which they stand still.
        takes: The block that they then hold, turned flat to them, or None.
        is_blocked: Whether something stopped them before their target.
        pinched: Blocks that were pressed together between them, where there were several.
    """

    end_mm: float
    takes: TwinBlock | None
    is_blocked: bool
    pinched: tuple[str, ...] = ()


class Hand:
    """The fingers' geometry."""

    def __init__(self, profile: Profile) -> None:
        self._gripper = profile.gripper
        self._surface_mm = profile.heights.surface_mm

    def tip_mm(self, tool: Pose) -> float:
        """Return the height of the fingertips."""
        return tool.z_mm - self._gripper.tip_below_tool_mm

    def reach_below_mm(self, held: Held | None) -> float:
        """Return how far the lowest part of hand and held block lies below the tool point."""
        tip_mm = self._gripper.tip_below_tool_mm
        return tip_mm if held is None else max(tip_mm, held.below_mm)

    def meet(self, blocks: BlockField, tool: Pose, start_mm: float, target_mm: float) -> Meeting:
        """Return how fingers end that close from one opening towards another.

        They hold a block when exactly one is between them; several stop them as well.
        """
        jaw = self._jaw(tool)
        low_mm = self.tip_mm(tool)
        met: list[tuple[float, TwinBlock]] = []
        for block in blocks.all():
            common_mm = min(blocks.top_mm(block), low_mm + _FINGER_LENGTH_MM) - max(
                block.z_mm, low_mm
            )
            if common_mm < _LEAST_CONTACT_MM:
                continue
            aligned = block
            if blocks.kind(block).shape != "cylinder":
                aligned = replace(block, yaw_deg=aligned_yaw_deg(block.yaw_deg, jaw.axis_deg))
            span = jaw.span(blocks.footprint(aligned))
            if span is not None and max(-span[0], span[1]) <= 0.5 * start_mm + _FIT_MM:
                met.append((span[1] - span[0], aligned))
        width_mm = sum(width for width, _ in met)
        if width_mm <= target_mm:
            return Meeting(end_mm=target_mm, takes=None, is_blocked=False)
        takes = met[0][1] if len(met) == 1 and width_mm > _LEAST_CONTACT_MM else None
        pinched = tuple(block.block for _, block in met) if len(met) > 1 else ()
        return Meeting(end_mm=width_mm, takes=takes, is_blocked=True, pinched=pinched)

    def take(self, blocks: BlockField, block: TwinBlock, tool: Pose) -> Held | None:
        """Push a block to the fingers' middle and return how it hangs in them."""
        jaw = self._jaw(tool)
        span = jaw.span(blocks.footprint(block))
        if span is None:
            return None
        ax, ay = jaw.axis
        shift = 0.5 * (span[0] + span[1])
        block = replace(block, x_mm=block.x_mm - shift * ax, y_mm=block.y_mm - shift * ay)
        blocks.put(block)
        blocks.make_room(block.block)
        dx, dy = block.x_mm - jaw.x_mm, block.y_mm - jaw.y_mm
        return Held(
            block=block.block,
            along_mm=ax * dx + ay * dy,
            across_mm=-ay * dx + ax * dy,
            below_mm=tool.z_mm - block.z_mm,
            turn_deg=block.yaw_deg - jaw.axis_deg,
        )

    def carried(self, block: TwinBlock, held: Held, tool: Pose) -> TwinBlock:
        """Return where a held block hangs; it slips up rather than sink into the surface."""
        jaw = self._jaw(tool)
        ax, ay = jaw.axis
        return replace(
            block,
            x_mm=tool.x_mm + ax * held.along_mm - ay * held.across_mm,
            y_mm=tool.y_mm + ay * held.along_mm + ax * held.across_mm,
            z_mm=max(tool.z_mm - held.below_mm, self._surface_mm),
            yaw_deg=jaw.axis_deg + held.turn_deg,
        )

    def push_aside(
        self, blocks: BlockField, tool: Pose, opening_mm: float, held: Held | None
    ) -> list[Shove]:
        """Push what the fingers, or a block in them, run into; return what was pushed."""
        shoved: list[Shove] = []
        spare = None if held is None else held.block
        for finger in self._jaw(tool).fingers(opening_mm):
            shoved += blocks.push(finger, self.tip_mm(tool), spare=spare)
        if held is not None:
            carried = self.carried(blocks.get(held.block), held, tool)
            shoved += blocks.push(blocks.footprint(carried), carried.z_mm, spare=spare)
        return shoved

    def _jaw(self, tool: Pose) -> Jaw:
        a, b, c = (math.radians(v) for v in (tool.a_deg, tool.b_deg, tool.c_deg))
        sa, ca, sb = math.sin(a), math.cos(a), math.sin(b)
        ax = math.cos(c) * sb * sa - math.sin(c) * ca
        ay = math.sin(c) * sb * sa + math.cos(c) * ca
        length = math.hypot(ax, ay) or 1.0
        return Jaw(
            x_mm=tool.x_mm,
            y_mm=tool.y_mm,
            axis=(ax / length, ay / length),
            finger_width_mm=self._gripper.finger_width_mm,
            finger_thickness_mm=self._gripper.finger_thickness_mm,
        )
