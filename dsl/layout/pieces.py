"""What lies on the lattice: blocks and the gripper's start, settled or yet to be placed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

from dsl.kinds import border_steps, shape_of
from dsl.program import (
    Distance,
    Environment,
    Gap,
    Goal,
    Party,
    Place,
    Region,
    Requirement,
    Selector,
    Spot,
    World,
)
from dsl.spans import Span

PieceKey = tuple[str, str | None, str | None, bool, bool]


@dataclass(frozen=True, slots=True)
class Piece:
    """A block or the start.

    Attributes:
        role: `block` or `start`.
        kind: Kind of a block; None while it is not drawn.
        colour: Its colour; None while it is not drawn.
        yaw_deg: Its turn.
        is_target: Whether it is the goal's target.
        point: Where it is; None where it is yet to be placed.
        span: Where the script says so.
    """

    role: Literal["block", "start"]
    kind: str | None
    colour: str | None
    yaw_deg: float
    is_target: bool
    point: tuple[int, int] | None
    span: Span

    @property
    def shape(self) -> tuple[str, bool]:
        """What its room depends on; a block of unknown kind needs at least a cube's."""
        return shape_of(self.kind or "cube", self.yaw_deg)

    @property
    def key(self) -> PieceKey:
        """Equal for pieces that any rule treats alike."""
        return self.role, self.kind, self.colour, self.yaw_deg % 180.0 == 90.0, self.is_target

    def is_surely(self, party: Party) -> bool:
        """Return whether it is one of those a distance speaks of, whatever is drawn."""
        if party.selector is None:
            return self.role == "start" if party.role == "start" else self.is_target
        return self.role == "block" and self.is_surely_of(party.selector)

    def is_surely_of(self, selector: Selector) -> bool:
        """Return whether a selector means this block, whatever is drawn."""
        return selector.kind in (None, self.kind) and selector.colour in (None, self.colour)

    def __str__(self) -> str:
        what = "the start" if self.role == "start" else str(Selector(self.kind, self.colour))
        return what if self.point is None else f"{what} at ({self.point[0]}, {self.point[1]})"


def places_of(environment: Environment, goal: Goal | None) -> tuple[Place, ...]:
    """Return what lies out: the environment's places, with the goal's target in their stead."""
    if goal is None or goal.target.spot is None:
        return environment.places
    target = goal.target
    selector = Selector(target.kind, target.colour)
    kept = [place for place in environment.places if place.selector != selector]
    return (*kept, Place(selector, 1, 1, goal.target.spot, target.yaw_deg, target.span))


def withheld_sorts(
    environment: Environment, goal: Goal | None, stock: Collection[tuple[str, str]]
) -> frozenset[tuple[str, str]]:
    """Return the sorts of block that places which leave kind or colour open do not take.

    Those are the target's, so that it stays the only one, and kinds that stick out of the
    playground wherever they lie.
    """
    width, height = environment.world
    withheld = set() if goal is None else {(goal.target.kind, goal.target.colour)}
    for kind, colour in stock:
        side, end = border_steps(shape_of(kind, 0.0))
        if 2 * side >= width or 2 * end >= height:
            withheld.add((kind, colour))
    return frozenset(withheld)


def requirements_of(environment: Environment, goal: Goal | None) -> tuple[Requirement, ...]:
    """Return the requirements of a layout, the environment's first."""
    return environment.requirements + (() if goal is None else goal.requirements)


def block_pieces(
    places: Sequence[Place],
    counts: Sequence[int],
    sorts: Sequence[tuple[str | None, str | None]],
    world: World,
    goal: Goal | None,
) -> list[Piece]:
    """Make the pieces of all places.

    Args:
        places: The places.
        counts: How many blocks each has.
        sorts: Kind and colour of each block, None where not drawn.
        world: The world they lie in.
        goal: The goal whose target is among them, if there is one.
    """
    owners = [place for place, count in zip(places, counts, strict=True) for _ in range(count)]
    target = None if goal is None else (goal.target.kind, goal.target.colour)
    return [
        Piece(
            "block",
            kind,
            colour,
            place.yaw_deg,
            (kind, colour) == target,
            place.spot.within(world),
            place.span,
        )
        for place, (kind, colour) in zip(owners, sorts, strict=True)
    ]


def start_piece(spot: Spot, world: World) -> Piece:
    """Make the piece of the start."""
    return Piece(
        "start", None, None, 0.0, is_target=False, point=spot.within(world), span=spot.span
    )


def broken_by_pair(requirement: Requirement, a: Piece, b: Piece, dx: int, dy: int) -> bool:
    """Return whether two pieces break a requirement, b lying (dx, dy) from a."""
    match requirement:
        case Gap():
            if a.role == "start" or b.role == "start":
                return False
            return not requirement.relation.holds(max(abs(dx), abs(dy)))
        case Distance():
            return concerns(requirement, a, b) and not requirement.relation.holds(abs(dx) + abs(dy))
        case _:
            return False


def concerns(requirement: Distance, a: Piece, b: Piece) -> bool:
    """Return whether a distance speaks of these two."""
    first, second = requirement.first, requirement.second
    return (a.is_surely(first) and b.is_surely(second)) or (
        a.is_surely(second) and b.is_surely(first)
    )


def broken_by_piece(requirement: Requirement, piece: Piece, x: int, y: int) -> bool:
    """Return whether a piece at a point breaks a requirement by itself."""
    if not isinstance(requirement, Region) or piece.role == "start":
        return False
    return piece.is_surely_of(requirement.selector) and not requirement.holds(x, y)
