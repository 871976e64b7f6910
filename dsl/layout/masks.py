"""Sets of lattice points as the bits of one whole number.

A world of W x H points has the bit y·S + x for point (x, y), with rows of S = 2W - 1
bits. A template has a bit for each offset (dx, dy) from (1 - W, 1 - H) to (W - 1, H - 1);
shifted to a point it gives the set of points at those offsets. The spare columns take
what would fall out of the world, so a shift never spills into another row.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from dsl.kinds import LATTICE_STEP_MM, border_steps, clash
from dsl.program import Relation, World

Shape = tuple[str, bool]
_ROOM = 6
"""No two blocks that far apart, in steps, are in each other's way (a bridge is 100 mm long)."""


@lru_cache(maxsize=256)
def world_mask(world: World) -> int:
    """Return the set of all points."""
    row = (1 << world.width) - 1
    return sum(row << y * _stride(world) for y in range(world.height))


def point_bit(world: World, x: int, y: int) -> int:
    """Return the number of a point's bit."""
    return y * _stride(world) + x


def points(world: World, mask: int) -> list[tuple[int, int]]:
    """Return the points of a set, row by row from the bottom."""
    stride = _stride(world)
    return [(bit % stride, bit // stride) for bit in bits(mask)]


def bits(mask: int) -> list[int]:
    """Return the numbers of the bits of a set, ascending."""
    found = []
    while mask:
        low = mask & -mask
        found.append(low.bit_length() - 1)
        mask ^= low
    return found


def points_where(world: World, holds: Callable[[int, int], bool]) -> int:
    """Return the set of points for which something holds."""
    return sum(
        1 << point_bit(world, x, y)
        for y in range(world.height)
        for x in range(world.width)
        if holds(x, y)
    )


def shifted(world: World, template: int, bit: int) -> int:
    """Return the points at the offsets of a template from the point with a bit."""
    origin = (world.height - 1) * _stride(world) + world.width - 1
    return (template << bit) >> origin & world_mask(world)


def offset_bit(world: World, dx: int, dy: int) -> int:
    """Return the template that holds one offset."""
    return 1 << (dy + world.height - 1) * _stride(world) + dx + world.width - 1


@lru_cache(maxsize=256)
def playground_mask(world: World, shape: Shape) -> int:
    """Return the points where a block does not stick out of the playground."""
    side, end = border_steps(shape)
    width, height = world
    return points_where(world, lambda x, y: side <= x < width - side and end <= y < height - end)


@lru_cache(maxsize=1024)
def room_template(world: World, first: Shape, second: Shape) -> int:
    """Return the offsets at which two blocks are in each other's way."""
    wide, high = min(_ROOM, world.width - 1), min(_ROOM, world.height - 1)
    return sum(
        offset_bit(world, dx, dy)
        for dy in range(-high, high + 1)
        for dx in range(-wide, wide + 1)
        if clash(first, second, dx * LATTICE_STEP_MM, dy * LATTICE_STEP_MM)
    )


@lru_cache(maxsize=256)
def relation_template(world: World, relation: Relation, *, is_gap: bool) -> int:
    """Return the offsets whose gap, else whose distance, is not as asked for."""
    return sum(
        offset_bit(world, dx, dy)
        for dy in range(1 - world.height, world.height)
        for dx in range(1 - world.width, world.width)
        if not relation.holds(max(abs(dx), abs(dy)) if is_gap else abs(dx) + abs(dy))
    )


@lru_cache(maxsize=1024)
def crowding_tiles(world: World, template: int) -> tuple[tuple[int, ...], ...]:
    """Return ways to cover the world with tiles that hold one block each.

    If every two points in a tile of a x b are at an offset of the template, no tile
    can hold two blocks; so a set of points takes no more blocks than the tiles it
    touches. Each way is the tuple of its tiles, as sets.
    """
    ways = []
    height = world.height
    for width in range(1, world.width + 1):
        height = _crowded_height(world, template, width, height)
        if height == 0:
            break
        ways.append(_tiles(world, width, height))
    return tuple(ways)


def _crowded_height(world: World, template: int, width: int, limit: int) -> int:
    """Return the height of the tallest tile of a width that holds one block only."""
    for dy in range(limit):
        for dx in range(width):
            if (dx or dy) and not (
                template & offset_bit(world, dx, dy) and template & offset_bit(world, -dx, dy)
            ):
                return dy
    return limit


def _tiles(world: World, width: int, height: int) -> tuple[int, ...]:
    stride = _stride(world)
    return tuple(
        sum(
            ((1 << min(width, world.width - x)) - 1) << (row * stride + x)
            for row in range(y, min(y + height, world.height))
        )
        for y in range(0, world.height, height)
        for x in range(0, world.width, width)
    )


def _stride(world: World) -> int:
    return 2 * world.width - 1
