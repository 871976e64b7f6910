"""Why there is no layout, in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

from dsl.draws import Draws
from dsl.layout.pieces import Piece
from dsl.layout.search import Search
from dsl.program import Distance, Requirement, World

_BUDGET = 20_000


def blame(world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement]) -> str:
    """Name what keeps the pieces from having a layout.

    Tried in this order: a piece that has no point beside the settled ones; a single
    requirement without which there is a layout; the room that the blocks and the
    fingers need; else all requirements together.
    """
    return (
        _homeless_piece(world, pieces, requirements)
        or _single_requirement(world, pieces, requirements)
        or _room(world, pieces)
        or _together(world, requirements)
    )


def _homeless_piece(
    world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement]
) -> str | None:
    for index, piece in enumerate(pieces):
        if piece.point is not None:
            continue
        alone = [piece]
        for requirement in requirements:
            if not Search(world, alone, [requirement]).points_left(0):
                return f"`{requirement}` leaves no point of {world} for {piece}"
        if not Search(world, pieces, ()).points_left(index):
            return f"beside the fixed blocks no point of {world} is left for {piece}"
    return None


def _single_requirement(
    world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement]
) -> str | None:
    for index, requirement in enumerate(requirements):
        others = [*requirements[:index], *requirements[index + 1 :]]
        if not _is_possible(world, pieces, others):
            continue
        if isinstance(requirement, Distance):
            return f"`{requirement}` cannot be kept in {world}"
        return _too_many(world, pieces, requirements, f"with `{requirement}`")
    return None


def _room(world: World, pieces: Sequence[Piece]) -> str | None:
    if _is_possible(world, pieces, ()):
        return None
    return _too_many(world, pieces, (), "with room for the fingers")


def _too_many(
    world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement], why: str
) -> str:
    """Say how many of the blocks fit, found by leaving out free ones from the end."""
    free = [i for i, p in enumerate(pieces) if p.point is None and p.role == "block"]
    asked = sum(piece.role == "block" for piece in pieces)

    def fits(kept: int) -> bool:
        left_out = set(free[kept:])
        rest = [piece for i, piece in enumerate(pieces) if i not in left_out]
        return _is_possible(world, rest, requirements)

    if not fits(0):
        return f"{why} no block fits into {world} beside the fixed ones"
    few, many = 0, len(free)
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if fits(middle) else (few, middle)
    fit = asked - len(free) + few
    blocks = "1 block fits" if fit == 1 else f"{fit} blocks fit"
    return f"{why} at most {blocks} into {world}, {asked} are asked for"


def _together(world: World, requirements: Sequence[Requirement]) -> str:
    names = ", ".join(f"`{requirement}`" for requirement in requirements)
    return f"{names} cannot be kept together in {world}"


def _is_possible(
    world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement]
) -> bool:
    """Whether a layout exists; one that cannot be told counts as possible."""
    return Search(world, pieces, requirements).run(Draws(0), _BUDGET).verdict != "impossible"
