"""The layout of one task: a function of goal, environment and seed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dsl.draws import Draws
from dsl.errors import InfeasibleLayout
from dsl.host import Placement
from dsl.layout.blame import blame
from dsl.layout.demand import Demand, stock_of
from dsl.layout.pieces import (
    Piece,
    block_pieces,
    places_of,
    requirements_of,
    start_piece,
    withheld_sorts,
)
from dsl.layout.search import Search
from dsl.program import Environment, Goal, Store


@dataclass(frozen=True, slots=True)
class Layout:
    """Where everything is when a task begins.

    Attributes:
        placements: The blocks, in the order they are laid out.
        start: Lattice point of the gripper.
        target: Lattice point of the target.
    """

    placements: tuple[Placement, ...]
    start: tuple[int, int]
    target: tuple[int, int]


def arrange(store: Store, environment: Environment, goal: Goal, seed: int) -> Layout:
    """Draw the layout of a task.

    Raises:
        InfeasibleLayout: This seed has no layout, or none was found within the budget.
    """
    draws = Draws(seed)
    places = places_of(environment, goal)
    counts = [p.low if p.low == p.high else draws.between(p.low, p.high) for p in places]
    wanted = [p.selector for p, count in zip(places, counts, strict=True) for _ in range(count)]
    stock = stock_of(store.slots)
    withheld = withheld_sorts(environment, goal, stock)
    shortage = Demand(wanted, stock, withheld).shortage()
    if shortage is not None:
        raise InfeasibleLayout(goal.name, environment.name, seed, str(shortage))
    sorts = Demand(wanted, stock, withheld).draw(draws)
    pieces = block_pieces(places, counts, sorts, environment.world, goal)
    pieces.append(start_piece(goal.start, environment.world))
    points = _points(pieces, environment, goal, seed, draws)
    target = next(point for piece, point in zip(pieces, points, strict=True) if piece.is_target)
    return Layout(_placements(store, pieces, points), points[-1], target)


def _points(
    pieces: list[Piece], environment: Environment, goal: Goal, seed: int, draws: Draws
) -> tuple[tuple[int, int], ...]:
    world, requirements = environment.world, requirements_of(environment, goal)
    outcome = Search(world, pieces, requirements).run(draws)
    if outcome.verdict == "found":
        return outcome.points
    reason = blame(world, pieces, requirements)
    if outcome.verdict == "open":
        reason = f"none was found within the budget of the search; perhaps {reason}"
    raise InfeasibleLayout(goal.name, environment.name, seed, reason)


def _placements(
    store: Store, pieces: Iterable[Piece], points: Iterable[tuple[int, int]]
) -> tuple[Placement, ...]:
    """Give each block the lowest slot of its sort that is not yet taken."""
    slots = {slot.number: slot for slot in sorted(store.slots, key=lambda slot: slot.number)}
    placements = []
    for piece, (x, y) in zip(pieces, points, strict=True):
        if piece.role == "start":
            continue
        sort = (piece.kind, piece.colour)
        number = next(n for n, slot in slots.items() if (slot.kind, slot.colour) == sort)
        slot = slots.pop(number)
        placements.append(
            Placement(
                slot=number, kind=slot.kind, colour=slot.colour, x=x, y=y, yaw_deg=piece.yaw_deg
            )
        )
    return tuple(placements)
