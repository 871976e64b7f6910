"""Which blocks a layout takes from the store."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from dsl.draws import Draws
from dsl.program import Selector, Slot

Sort = tuple[str, str]
"""Kind and colour of a block."""


@dataclass(frozen=True, slots=True)
class Shortage:
    """Some of the wanted blocks that the store cannot serve together.

    Attributes:
        wanted: The selectors of those blocks.
        available: How many blocks the store has for them.
    """

    wanted: tuple[Selector, ...]
    available: int

    def __str__(self) -> str:
        counts = Counter(str(selector) for selector in self.wanted)
        if len(counts) == 1:
            name, count = next(iter(counts.items()))
            return f"{_blocks(count)} `{name}` asked for, the store has {self.available}"
        parts = ", ".join(f"{count} `{name}`" for name, count in counts.items())
        total = len(self.wanted)
        return f"{_blocks(total)} ({parts}) asked for, the store has {self.available} for them"


def _blocks(count: int) -> str:
    return "1 block" if count == 1 else f"{count} blocks"


def stock_of(slots: Sequence[Slot]) -> Counter[Sort]:
    """Return how many blocks of each sort the store has."""
    return Counter((slot.kind, slot.colour) for slot in slots)


class Demand:
    """Blocks that are wanted together, and the store that must serve them.

    Args:
        wanted: What is asked for, one selector a block.
        stock: How many blocks there are of each sort.
        withheld: Sorts that open selectors do not take: that of the target, and those
            that do not fit into the world.
    """

    def __init__(
        self,
        wanted: Sequence[Selector],
        stock: Mapping[Sort, int],
        withheld: Collection[Sort] = (),
    ) -> None:
        self._wanted = list(wanted)
        self._stock = dict(stock)
        self._withheld = frozenset(withheld)
        self._takers: dict[Sort, list[int]] = {sort: [] for sort in self._stock}

    def shortage(self) -> Shortage | None:
        """Return what the store cannot serve, or None when it can serve everything.

        An augmenting path for each block (Kuhn's matching, with as many takers of a
        sort as the store has blocks of it); where there is none, the blocks that
        stand in each other's way are those the path went through (Hall's theorem).
        """
        for index in range(len(self._wanted)):
            seen: set[Sort] = set()
            if not self._serve(index, seen):
                rivals = [taker for sort in seen for taker in self._takers[sort]]
                wanted = tuple(self._wanted[i] for i in sorted([*rivals, index]))
                return Shortage(wanted, sum(self._stock[sort] for sort in seen))
        return None

    def _serve(self, index: int, seen: set[Sort]) -> bool:
        for sort, takers in self._takers.items():
            if sort in seen or not self._suits(index, sort):
                continue
            seen.add(sort)
            if len(takers) < self._stock[sort]:
                takers.append(index)
                return True
            for position, rival in enumerate(takers):
                if self._serve(rival, seen):
                    takers[position] = index
                    return True
        return False

    def _suits(self, index: int, sort: Sort) -> bool:
        selector = self._wanted[index]
        if sort in self._withheld and not selector.is_definite:
            return False
        return selector.matches(*sort)

    def draw(self, draws: Draws) -> list[Sort]:
        """Decide kind and colour of every block.

        Open blocks are drawn in order, each uniform over the blocks left in the store
        with which the blocks after it can still be served.

        Raises:
            ValueError: The store cannot serve the demand; ask `shortage` first.
        """
        left = Counter(self._stock)
        chosen: list[Sort | None] = []
        for selector in self._wanted:
            definite = (selector.kind, selector.colour) if selector.is_definite else None
            if definite is not None and definite[0] is not None and definite[1] is not None:
                chosen.append((definite[0], definite[1]))
                left[definite[0], definite[1]] -= 1
            else:
                chosen.append(None)
        open_ones = [index for index, sort in enumerate(chosen) if sort is None]
        for position, index in enumerate(open_ones):
            rest = [self._wanted[i] for i in open_ones[position + 1 :]]
            chosen[index] = sort = self._draw_one(index, rest, left, draws)
            left[sort] -= 1
        return [sort for sort in chosen if sort is not None]

    def _draw_one(
        self, index: int, rest: Sequence[Selector], left: Counter[Sort], draws: Draws
    ) -> Sort:
        blocks = [s for s, count in left.items() for _ in range(count) if self._suits(index, s)]
        for sort in draws.shuffled(blocks):
            remaining = left.copy()
            remaining[sort] -= 1
            if Demand(rest, remaining, self._withheld).shortage() is None:
                return sort
        raise ValueError(f"the store cannot serve {self._wanted[index]}")
