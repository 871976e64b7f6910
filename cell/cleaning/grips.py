"""Grips that the fingers can do: which block, how turned, where along it, how far open.

A grip needs room for both fingers beside the block: between its face and the next thing on
either side there must be space for a finger and a margin before and behind it. The opening
that shares that space evenly is taken, so for each turn and each place along a face the best
opening follows at once. A box is gripped across its width, a square one across either side,
a cylinder at any turn; a grip beside the middle of a face is as good as long as most of the
finger lies on it, and what it is off the middle is known when the block is put down.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from cell.cleaning.sight import LyingBlock
from cell.contact import Body, Jaw
from cell.profile import GripperProfile
from cell.store import TablePlace

MARGIN_MM = 1.5
"""Room that a finger needs before and behind it, beside what the vision does not know."""
SIDE_MARGIN_MM = 2.0
"""The same beside its edges."""
_DEVIATIONS = 2.0
_FAR_MM = 200.0
_LEAST_ON_FACE = 0.6
_ALONG_STEP_MM = 5.0
_ENOUGH_MM = 6.0
_TURN_STEP_DEG = 15.0
_SQUARE_MM = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Grip:
    """How a block is gripped.

    Attributes:
        place: The block's middle; the yaw is the direction of the faces that are gripped,
            from -90 deg to below 90.
        along_mm: How far from the middle, along that direction, the fingers close.
        opening_mm: Opening with which the fingers come down and let go.
        clearance_mm: Least room between a finger and anything else.
    """

    place: TablePlace
    along_mm: float
    opening_mm: float
    clearance_mm: float

    @property
    def tool_place(self) -> TablePlace:
        """Where the middle between the fingers goes."""
        return beside(self.place, self.along_mm)


def beside(place: TablePlace, along_mm: float) -> TablePlace:
    """Return the place a way along the yaw of another, `folded` as the tool is turned."""
    turn = math.radians(folded(place.yaw_deg))
    return TablePlace(
        x_mm=place.x_mm + along_mm * math.cos(turn),
        y_mm=place.y_mm + along_mm * math.sin(turn),
        yaw_deg=place.yaw_deg,
    )


def folded(yaw_deg: float) -> float:
    """Return the same direction of a line, from -90 deg to below 90, as the tool is turned."""
    return (yaw_deg + 90.0) % 180.0 - 90.0


class GripPlanner:
    """Lists the grips of blocks among others.

    Args:
        gripper: Sizes of the fingers.
        reaches: Whether the arm may go down to a place of the tool; asked last.
    """

    def __init__(
        self, gripper: GripperProfile, reaches: Callable[[TablePlace], bool] = lambda place: True
    ) -> None:
        self._gripper = gripper
        self._reaches = reaches

    def margin_mm(self, block: LyingBlock) -> float:
        """Return the room that a finger needs beside a block that is known so well."""
        return MARGIN_MM + _DEVIATIONS * block.deviation_mm

    def best(self, block: LyingBlock, others: Sequence[Body]) -> Grip | None:
        """Return the best grip of a block that the arm can reach, None when there is none."""
        needed_mm = self.margin_mm(block)
        fitting = [g for g in self._all(block, others) if g.clearance_mm >= needed_mm]
        fitting.sort(key=lambda g: (-min(g.clearance_mm, _ENOUGH_MM), abs(g.along_mm)))
        return next((grip for grip in fitting if self._reaches(grip.tool_place)), None)

    def fits(self, block: LyingBlock, others: Sequence[Body]) -> bool:
        """Return whether there is room for some grip, whether the arm reaches it or not."""
        return self.room_mm(block, others) >= self.margin_mm(block)

    def room_mm(self, block: LyingBlock, others: Sequence[Body]) -> float:
        """Return the most room that a finger finds beside a block; below 0 it finds none."""
        return max((grip.clearance_mm for grip in self._all(block, others)), default=-_FAR_MM)

    def _all(self, block: LyingBlock, others: Sequence[Body]) -> Iterator[Grip]:
        body = block.body
        polygons = [_Near(other) for other in others]
        reach_mm = body.radius_mm + 0.5 * self._gripper.stroke_mm + 40.0
        near = [one for one in polygons if one.is_within(body.x_mm, body.y_mm, reach_mm)]
        for yaw_deg, face_mm, width_mm in self._sides(block):
            place = TablePlace(x_mm=body.x_mm, y_mm=body.y_mm, yaw_deg=folded(yaw_deg))
            for along_mm in self._places_along(face_mm, is_round=body.is_round):
                slack = abs(along_mm) * math.sin(math.radians(block.deviation_deg))
                grip = self._grip(place, along_mm, width_mm, near)
                if grip is not None:
                    yield Grip(
                        place=place,
                        along_mm=along_mm,
                        opening_mm=grip[0],
                        clearance_mm=grip[1] - slack,
                    )

    def _sides(self, block: LyingBlock) -> Iterator[tuple[float, float, float]]:
        """Yield the turns of a block's faces, their length, and the width between them."""
        body = block.body
        if body.is_round:
            for step in range(round(180.0 / _TURN_STEP_DEG)):
                yield step * _TURN_STEP_DEG, 0.0, body.width_mm
            return
        yield body.yaw_deg, body.length_mm, body.width_mm
        if abs(body.length_mm - body.width_mm) < _SQUARE_MM:
            yield body.yaw_deg + 90.0, body.width_mm, body.length_mm

    def _places_along(self, face_mm: float, *, is_round: bool) -> Iterator[float]:
        yield 0.0
        if is_round:
            return
        finger_mm = self._gripper.finger_width_mm
        farthest_mm = 0.5 * face_mm + (0.5 - _LEAST_ON_FACE) * finger_mm
        for step in range(1, int(farthest_mm / _ALONG_STEP_MM) + 1):
            yield step * _ALONG_STEP_MM
            yield -step * _ALONG_STEP_MM

    def _grip(
        self, place: TablePlace, along_mm: float, width_mm: float, near: Sequence[_Near]
    ) -> tuple[float, float] | None:
        """Return opening and clearance of a grip, None when something is in between."""
        tool = beside(place, along_mm)
        turn = math.radians(place.yaw_deg)
        jaw = Jaw(
            x_mm=tool.x_mm,
            y_mm=tool.y_mm,
            axis=(-math.sin(turn), math.cos(turn)),
            finger_width_mm=self._gripper.finger_width_mm + 2.0 * SIDE_MARGIN_MM,
            finger_thickness_mm=self._gripper.finger_thickness_mm,
        )
        half_mm, free_mm = 0.5 * width_mm, _FAR_MM
        for other in near:
            span = jaw.span(other)
            if span is None:
                continue
            low, high = span
            if low <= 0.0 <= high:
                return None
            free_mm = min(free_mm, low if low > 0 else -high)
        spare_mm = free_mm - half_mm - self._gripper.finger_thickness_mm
        most_mm = 0.5 * min(self._gripper.open_mm, self._gripper.stroke_mm) - half_mm
        clearance_mm = min(0.5 * spare_mm, most_mm)
        return 2.0 * (half_mm + max(clearance_mm, 0.0)), clearance_mm


class _Near:
    """A body whose outline is made once."""

    __slots__ = ("_corners", "_high", "_low")

    def __init__(self, body: Body) -> None:
        self._corners = body.polygon()
        xs, ys = [x for x, _ in self._corners], [y for _, y in self._corners]
        self._low, self._high = (min(xs), min(ys)), (max(xs), max(ys))

    def polygon(self) -> tuple[tuple[float, float], ...]:
        """Return the outline."""
        return self._corners

    def is_within(self, x_mm: float, y_mm: float, reach_mm: float) -> bool:
        """Return whether any of it may be that near."""
        return (
            self._low[0] - reach_mm <= x_mm <= self._high[0] + reach_mm
            and self._low[1] - reach_mm <= y_mm <= self._high[1] + reach_mm
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One block of a plan and the grip that it is taken with."""

    block: LyingBlock
    grip: Grip


@dataclass(frozen=True, slots=True, kw_only=True)
class RemovalPlan:
    """Which blocks are taken in which order, and which have no grip even then.

    Attributes:
        steps: Blocks in the order in which they are taken; each is free by then.
        stuck: Blocks to which the fingers find no way.
    """

    steps: tuple[Step, ...]
    stuck: tuple[LyingBlock, ...]


def plan_removal(
    blocks: Sequence[LyingBlock], obstacles: Sequence[Body], planner: GripPlanner
) -> RemovalPlan:
    """Plan which block is taken when: always the one with the most room next.

    Each one taken away may make room for others.
    """
    left = list(blocks)
    steps: list[Step] = []
    known: dict[int, Grip | None] = {}
    while left:
        for number, block in enumerate(left):
            if id(block) not in known:
                others = [b.body for i, b in enumerate(left) if i != number]
                known[id(block)] = planner.best(block, [*others, *obstacles])
        free = [(known[id(block)], block) for block in left]
        choice = max(
            ((grip.clearance_mm, -index) for index, (grip, _) in enumerate(free) if grip),
            default=None,
        )
        if choice is None:
            break
        grip, block = free[-choice[1]]
        if grip is None:
            break
        steps.append(Step(block=block, grip=grip))
        del left[-choice[1]]
        _forget_near(known, block, left)
    return RemovalPlan(steps=tuple(steps), stuck=tuple(left))


def _forget_near(
    known: dict[int, Grip | None], taken: LyingBlock, left: Sequence[LyingBlock]
) -> None:
    """Have the grips of blocks near a taken one looked for anew."""
    for block in left:
        distance = math.hypot(block.body.x_mm - taken.body.x_mm, block.body.y_mm - taken.body.y_mm)
        if distance < _FAR_MM:
            known.pop(id(block), None)
