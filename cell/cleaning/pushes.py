"""Pushes that make room: closed fingers, low and slow, straight against one block.

Where the fingers fit beside no block, one that can be reached from outside is pushed along
or away. What that does is calculated: a pushed body slides until it is free of what pushes
it and pushes on what it meets. Turning is left out, so after every push the cell looks again.
Only pushes are taken that keep every block within the area in which it can be gripped, and of
those the one that leaves the most blocks with room for the fingers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from cell.cleaning.grips import GripPlanner
from cell.cleaning.sight import LyingBlock
from cell.contact import Body, Footprint, Point, Polygon, push_out
from cell.profile import GripperProfile
from cell.store import TablePlace

PUSH_OPENING_MM = 1.0
"""Opening of fingers that push: closed, yet not pressed on each other."""
PUSH_SPEED_MM_S = 40.0
"""Speed of the tool while it pushes; see docs/explanation/twin.md for what harms a block."""
_ROOM_MM = 4.0
_STEP_MM = 3.0
_WAYS_MM = (12.0, 24.0, 36.0, 51.0, 66.0)
_CASCADE = 40
_APART_MM = 22.0
_TURNS = 12
_LEAST_GAIN_MM = 1.0
_FREED = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Push:
    """A straight way of closed fingers against a block.

    Attributes:
        block: The block that is met first.
        start: Where the fingers come down; the yaw is that of the tool's place.
        end: Where they stop.
        frees: How many of the blocks then have room for the fingers.
    """

    block: LyingBlock
    start: TablePlace
    end: TablePlace
    frees: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """The area in which blocks may be pushed: a convex outline, counter-clockwise, in mm."""

    corners: Polygon

    def outside_mm(self, x_mm: float, y_mm: float) -> float:
        """Return how far a point is outside, below 0 inside."""
        worst = -math.inf
        for index, (x1, y1) in enumerate(self.corners):
            x0, y0 = self.corners[index - 1]
            length = math.hypot(x1 - x0, y1 - y0)
            worst = max(worst, ((y1 - y0) * (x_mm - x0) - (x1 - x0) * (y_mm - y0)) / length)
        return worst


class PushPlanner:
    """Finds the push that makes the most room.

    Args:
        gripper: Sizes of the fingers.
        grips: Judges what room there is afterwards.
        field: Where blocks may be pushed to.
        may_go: Whether the arm may go straight from one place to another, low.
        may_lie: Whether the arm reaches a block that lies at a place.
    """

    def __init__(
        self,
        gripper: GripperProfile,
        grips: GripPlanner,
        field: Field,
        may_go: Callable[[TablePlace, TablePlace], bool] = lambda start, end: True,
        may_lie: Callable[[TablePlace], bool] = lambda place: True,
    ) -> None:
        self._gripper = gripper
        self._grips = grips
        self._field = field
        self._may_go = may_go
        self._may_lie = may_lie

    def best(
        self,
        blocks: Sequence[LyingBlock],
        obstacles: Sequence[Body],
        avoid: Sequence[tuple[Point, Point]] = (),
    ) -> Push | None:
        """Return the best push among blocks that all have no grip; None when none helps.

        Args:
            blocks: The blocks.
            obstacles: What must not be touched.
            avoid: Starts and ends of pushes that changed nothing.
        """
        room = [self._room(index, blocks, obstacles) for index in range(len(blocks))]
        judged = [
            (gain, push, after)
            for push, after in self._candidates(blocks, obstacles)
            if (gain := self._gain(push, blocks, after, obstacles, room)) is not None
        ]
        judged.sort(key=lambda one: -one[0])
        for gain, push, after in judged:
            ends = ((push.start.x_mm, push.start.y_mm), (push.end.x_mm, push.end.y_mm))
            if gain < _LEAST_GAIN_MM:
                return None
            if any(_same(ends, old) for old in avoid):
                continue
            moved = [new for old, new in zip(blocks, after, strict=True) if new is not old]
            if self._may_go(push.start, push.end) and all(self._may_lie(b.place) for b in moved):
                spare = [self._room(index, after, obstacles) for index in range(len(after))]
                return replace(push, frees=sum(one >= 0.0 for one in spare))
        return None

    def apart(
        self,
        lump: Footprint,
        others: Sequence[Body],
        avoid: Sequence[tuple[Point, Point]] = (),
    ) -> tuple[TablePlace, TablePlace] | None:
        """Return a way across one end of a lump of blocks that could not be told apart.

        Nobody knows what that does to it, so the way is short, touches nothing else, and
        there is room for it all beyond.

        Args:
            lump: The least rectangle around it.
            others: Everything else.
            avoid: Starts and ends of ways that were gone before.
        """
        if any(self._field.outside_mm(x, y) > 0 for x, y in lump.polygon()):
            return None
        for direction_deg, reach_mm, beside_mm in self._ends_of(lump):
            start = self._start(lump, direction_deg, reach_mm, beside_mm)
            turn = math.radians(direction_deg)
            cos, sin = math.cos(turn), math.sin(turn)
            way = _ROOM_MM + _APART_MM
            beyond = Footprint(
                x_mm=lump.x_mm + 0.5 * _APART_MM * cos,
                y_mm=lump.y_mm + 0.5 * _APART_MM * sin,
                yaw_deg=direction_deg,
                length_mm=2.0 * reach_mm + _APART_MM,
                width_mm=lump.width_mm + lump.length_mm - 2.0 * reach_mm,
            )
            end = (start.x_mm + way * cos, start.y_mm + way * sin)
            ends = ((start.x_mm, start.y_mm), end)
            if (
                not self._is_clear(start, (), others)
                or any(push_out(beyond.polygon(), body.polygon()) for body in others)
                or any(self._field.outside_mm(x, y) > 0 for x, y in beyond.polygon())
                or any(_same(ends, old) for old in avoid)
            ):
                continue
            yaw_deg = direction_deg - 90.0
            way_start = TablePlace(x_mm=start.x_mm, y_mm=start.y_mm, yaw_deg=yaw_deg)
            way_end = TablePlace(x_mm=end[0], y_mm=end[1], yaw_deg=yaw_deg)
            if self._may_go(way_start, way_end):
                return way_start, way_end
        return None

    @staticmethod
    def _ends_of(lump: Footprint) -> Iterator[tuple[float, float, float]]:
        """Yield ways across a rectangle near the ends of its sides, the long sides first."""
        quarters = sorted(range(4), key=lambda quarter: quarter % 2 == 1)
        if lump.length_mm > lump.width_mm:
            quarters.reverse()
        for quarter in quarters:
            along = quarter % 2 == 0
            half_mm = 0.5 * (lump.length_mm if along else lump.width_mm)
            side_mm = lump.width_mm if along else lump.length_mm
            for share in (0.28, -0.28):
                yield lump.yaw_deg + 90.0 * quarter, half_mm, share * side_mm

    def _room(self, index: int, blocks: Sequence[LyingBlock], obstacles: Sequence[Body]) -> float:
        others = [b.body for i, b in enumerate(blocks) if i != index]
        block = blocks[index]
        spare = self._grips.room_mm(block, [*others, *obstacles]) - self._grips.margin_mm(block)
        return min(max(spare, -12.0), 3.0)

    def _gain(
        self,
        push: Push,
        before: Sequence[LyingBlock],
        after: Sequence[LyingBlock],
        obstacles: Sequence[Body],
        room: Sequence[float],
    ) -> float | None:
        """Return how much room a push makes, None when it drives a block off the field."""
        moved = 0
        gain = 0.0
        for old, new in zip(before, after, strict=True):
            if old is new:
                continue
            moved += 1
            out = self._field.outside_mm(new.body.x_mm, new.body.y_mm)
            if out > max(0.0, self._field.outside_mm(old.body.x_mm, old.body.y_mm)):
                return None
        for index in range(len(after)):
            spare = self._room(index, after, obstacles)
            gain += spare - room[index] + (_FREED if spare >= 0.5 > room[index] else 0.0)
        way = math.hypot(push.end.x_mm - push.start.x_mm, push.end.y_mm - push.start.y_mm)
        return gain - 0.02 * way - 0.5 * moved

    def _candidates(
        self,
        blocks: Sequence[LyingBlock],
        obstacles: Sequence[Body],
    ) -> Iterator[tuple[Push, list[LyingBlock]]]:
        for block in blocks:
            for direction_deg, reach_mm, beside_mm in self._faces(block.body):
                start = self._start(block.body, direction_deg, reach_mm, beside_mm)
                if self._is_clear(start, blocks, obstacles):
                    yield from self._ways(block, start, direction_deg, blocks, obstacles)

    @staticmethod
    def _faces(body: Footprint) -> Iterator[tuple[float, float, float]]:
        """Yield directions to push in, half the body's size along them, and ways beside."""
        if body.is_round:
            for step in range(_TURNS):
                yield 360.0 / _TURNS * step, 0.5 * body.width_mm, 0.0
            return
        for quarter in range(4):
            is_along = quarter % 2 == 0
            half_mm = 0.5 * (body.length_mm if is_along else body.width_mm)
            face_mm = body.width_mm if is_along else body.length_mm
            for beside_mm in (0.0,) if face_mm < 50.0 else (0.0, -0.25 * face_mm, 0.25 * face_mm):
                yield body.yaw_deg + 90.0 * quarter, half_mm, beside_mm

    def _start(
        self, body: Footprint, direction_deg: float, reach_mm: float, beside_mm: float
    ) -> Footprint:
        """Return the closed fingers as they come down before a face."""
        turn = math.radians(direction_deg)
        cos, sin = math.cos(turn), math.sin(turn)
        thick_mm = 2.0 * self._gripper.finger_thickness_mm + PUSH_OPENING_MM
        back_mm = reach_mm + 0.5 * thick_mm + _ROOM_MM
        return Footprint(
            x_mm=body.x_mm - back_mm * cos - beside_mm * sin,
            y_mm=body.y_mm - back_mm * sin + beside_mm * cos,
            yaw_deg=direction_deg,
            length_mm=thick_mm,
            width_mm=self._gripper.finger_width_mm,
        )

    def _is_clear(
        self, fingers: Footprint, blocks: Sequence[LyingBlock], obstacles: Sequence[Body]
    ) -> bool:
        """Return whether the fingers come down on nothing, with room around."""
        room = Footprint(
            x_mm=fingers.x_mm,
            y_mm=fingers.y_mm,
            yaw_deg=fingers.yaw_deg,
            length_mm=fingers.length_mm + 2.0 * _ROOM_MM - 1.0,
            width_mm=fingers.width_mm + 2.0 * _ROOM_MM - 1.0,
        ).polygon()
        bodies = [*(b.body for b in blocks), *obstacles]
        return all(push_out(room, body.polygon()) is None for body in bodies)

    def _ways(
        self,
        block: LyingBlock,
        fingers: Footprint,
        direction_deg: float,
        blocks: Sequence[LyingBlock],
        obstacles: Sequence[Body],
    ) -> Iterator[tuple[Push, list[LyingBlock]]]:
        """Yield the ways of growing length, each with how the blocks lie after it."""
        turn = math.radians(direction_deg)
        cos, sin = math.cos(turn), math.sin(turn)
        lying = list(blocks)
        gone_mm = 0.0
        for way_mm in _WAYS_MM:
            while gone_mm < way_mm + _ROOM_MM:
                gone_mm = min(gone_mm + _STEP_MM, way_mm + _ROOM_MM)
                here = Footprint(
                    x_mm=fingers.x_mm + gone_mm * cos,
                    y_mm=fingers.y_mm + gone_mm * sin,
                    yaw_deg=direction_deg,
                    length_mm=fingers.length_mm,
                    width_mm=fingers.width_mm,
                )
                if not slide(lying, here, obstacles):
                    return
            yaw_deg = direction_deg - 90.0
            push = Push(
                block=block,
                start=TablePlace(x_mm=fingers.x_mm, y_mm=fingers.y_mm, yaw_deg=yaw_deg),
                end=TablePlace(x_mm=here.x_mm, y_mm=here.y_mm, yaw_deg=yaw_deg),
                frees=0,
            )
            yield push, list(lying)


def slide(blocks: list[LyingBlock], pusher: Footprint, obstacles: Sequence[Body]) -> bool:
    """Slide blocks out of what pushes them, and on; return whether nothing else was met.

    Args:
        blocks: Where they lie; changed.
        pusher: Outline of what pushes.
        obstacles: What must not be met, by the pusher or by a block.
    """
    waiting: list[tuple[Polygon, Footprint, int | None]] = [(pusher.polygon(), pusher, None)]
    for _ in range(_CASCADE):
        if not waiting:
            return True
        outline, body, own = waiting.pop()
        if any(push_out(outline, thing.polygon()) is not None for thing in obstacles):
            return False
        for index, other in enumerate(blocks):
            if index == own or _are_apart(body, other.body):
                continue
            shift = push_out(other.body.polygon(), outline)
            if shift is not None and math.hypot(*shift) > 1e-6:
                blocks[index] = moved = other.moved(shift)
                waiting.append((moved.body.polygon(), moved.body, index))
    return False


def _are_apart(one: Footprint, other: Footprint) -> bool:
    distance_mm = math.hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm)
    return distance_mm > one.radius_mm + other.radius_mm


def _same(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    return all(math.hypot(a[0] - b[0], a[1] - b[1]) < 5.0 for a, b in zip(one, other, strict=True))
