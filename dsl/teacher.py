"""The teacher: the next action of a shortest way to the target."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import lru_cache

from dsl.program import World

Move = tuple[int, int]


@lru_cache(maxsize=256)
def distances(world: World, moves: tuple[Move, ...], target: tuple[int, int]) -> tuple[int, ...]:
    """Return how many actions each point is from the target, -1 where there is no way.

    A search in breadth, from the target backwards over the moves. The distance of
    point (x, y) stands at index y * width + x.
    """
    width = world.width
    found = [-1] * (width * world.height)
    found[target[1] * width + target[0]] = 0
    waiting = deque([target])
    while waiting:
        x, y = waiting.popleft()
        steps = found[y * width + x] + 1
        for dx, dy in moves:
            px, py = x - dx, y - dy
            if world.holds(px, py) and found[py * width + px] < 0:
                found[py * width + px] = steps
                waiting.append((px, py))
    return tuple(found)


def first_step(
    world: World, moves: Sequence[Move], target: tuple[int, int], position: tuple[int, int]
) -> int | None:
    """Return the index of the first move of a shortest way, the first of several.

    Returns:
        None at the target, and where no way leads to it.
    """
    table = distances(world, tuple(moves), target)
    x, y = position
    remaining = table[y * world.width + x]
    if remaining <= 0:
        return None
    for index, (dx, dy) in enumerate(moves):
        px, py = x + dx, y + dy
        if world.holds(px, py) and table[py * world.width + px] == remaining - 1:
            return index
    return None
