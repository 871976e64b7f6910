"""Points for the pieces that the seed places: a search that always ends.

Theory of operation: each free piece has the set of points it can still take. Placing
one removes from the others' sets what its room and the requirements forbid there. The
piece with the fewest points left is placed next. First come some random attempts, each with a
small share of the budget; then a systematic search in scan order, which skips
arrangements that differ only by swapping equal pieces and cuts off wherever fewer
one-block tiles are left than pieces (`masks.crowding_tiles`). If that comes to its end,
there is no layout; if its budget is used up first, the answer is open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from dsl.draws import Draws
from dsl.errors import DslError
from dsl.layout import masks
from dsl.layout.pieces import Piece, PieceKey, broken_by_piece, concerns
from dsl.program import Distance, Gap, Region, Requirement, World

ATTEMPTS = 24
"""Random attempts before the systematic search."""

BUDGET = 400_000
"""Work of the search of a running task, in narrowed sets of points: well under a second.
At most half of it goes into random attempts."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a search found.

    Attributes:
        verdict: `found`, `impossible` (proven) or `open` (the budget is used up).
        points: The point of each piece, in the order of the pieces, when found.
    """

    verdict: Literal["found", "impossible", "open"]
    points: tuple[tuple[int, int], ...] = ()


class _BudgetUsedUp(DslError):
    """The search has narrowed as many sets of points as it may."""


class Search:
    """The search for one layout.

    Args:
        world: The world.
        pieces: All pieces; those with a point stay there.
        requirements: What the layout must keep to.
    """

    def __init__(
        self, world: World, pieces: Sequence[Piece], requirements: Sequence[Requirement]
    ) -> None:
        self._world = world
        self._pieces = tuple(pieces)
        self._requirements = tuple(requirements)
        self._templates: dict[tuple[PieceKey, PieceKey], int] = {}
        self._free = [i for i, piece in enumerate(pieces) if piece.point is None]
        self._domains = {i: self._own_points(pieces[i]) for i in self._free}
        for piece in pieces:
            if piece.point is not None:
                bit = masks.point_bit(world, *piece.point)
                for i in self._free:
                    self._domains[i] &= ~self._forbidden(piece, pieces[i], bit)
        self._ways = self._tilings()
        self._work = 0
        self._limit = 0

    def points_left(self, index: int) -> list[tuple[int, int]]:
        """Return the points that a free piece could take beside the settled ones."""
        return masks.points(self._world, self._domains[index])

    def surely_succeeds(self) -> bool:
        """Return whether there is a layout however the first pieces fall.

        So it is when each free piece has more points than all others can take from it.
        False says nothing.
        """
        for i in self._free:
            taken = sum(
                self._template(self._pieces[j], self._pieces[i]).bit_count()
                for j in self._free
                if j != i
            )
            if self._domains[i].bit_count() <= taken:
                return False
        return True

    def run(self, draws: Draws, budget: int = BUDGET) -> Outcome:
        """Search for a layout; a function of the pieces, the seed and the budget."""
        if any(domain == 0 for domain in self._domains.values()) or self._is_too_tight(
            self._domains
        ):
            return Outcome("impossible")
        self._work = 0
        count = len(self._free)
        for _ in range(ATTEMPTS):
            self._limit = min(self._work + (2 * count + 20) * count, budget // 2)
            try:
                return self._outcome(self._place(self._domains, {}, draws))
            except _BudgetUsedUp:
                continue
        self._limit = budget
        try:
            return self._outcome(self._place(self._domains, {}, None))
        except _BudgetUsedUp:
            return Outcome("open")

    def _outcome(self, found: dict[int, int] | None) -> Outcome:
        if found is None:
            return Outcome("impossible")
        stride = 2 * self._world.width - 1
        return Outcome(
            "found",
            tuple(
                piece.point if piece.point is not None else (found[i] % stride, found[i] // stride)
                for i, piece in enumerate(self._pieces)
            ),
        )

    def _place(
        self, domains: dict[int, int], placed: dict[int, int], draws: Draws | None
    ) -> dict[int, int] | None:
        """Place the pieces that have a domain; None when that is impossible.

        Draws are None in the systematic search.

        Raises:
            _BudgetUsedUp: The work has reached its limit.
        """
        if not domains:
            return placed
        index = min(domains, key=lambda i: (domains[i].bit_count(), i))
        choices = masks.bits(domains[index])
        while choices:
            self._work += len(domains)
            if self._work > self._limit:
                raise _BudgetUsedUp
            if draws is None:
                bit = choices.pop(0)
            else:
                pick = draws.below(len(choices))
                choices[pick], choices[-1] = choices[-1], choices[pick]
                bit = choices.pop()
            rest = self._narrowed(domains, index, bit, is_systematic=draws is None)
            if rest is not None:
                found = self._place(rest, {**placed, index: bit}, draws)
                if found is not None:
                    return found
        return None

    def _narrowed(
        self, domains: dict[int, int], index: int, bit: int, *, is_systematic: bool
    ) -> dict[int, int] | None:
        """Return the other pieces' domains once a piece lies somewhere, None if one is empty."""
        piece = self._pieces[index]
        forbidden: dict[PieceKey, int] = {}
        rest: dict[int, int] = {}
        for i, domain in domains.items():
            if i == index:
                continue
            other = self._pieces[i]
            mask = forbidden.get(other.key)
            if mask is None:
                mask = forbidden[other.key] = self._forbidden(piece, other, bit)
            left = domain & ~mask
            if is_systematic and other.key == piece.key:
                left &= -1 << bit
            if left == 0:
                return None
            rest[i] = left
        return None if self._is_too_tight(rest) else rest

    def _is_too_tight(self, domains: dict[int, int]) -> bool:
        """Whether the blocks to be placed are more than the one-block tiles left for them."""
        blocks = [i for i in domains if self._pieces[i].role == "block"]
        if len(blocks) < 2 or not self._ways:
            return False
        union = 0
        for i in blocks:
            union |= domains[i]
        return any(sum(1 for tile in way if tile & union) < len(blocks) for way in self._ways)

    def _tilings(self) -> tuple[tuple[int, ...], ...]:
        """Return the tilings that bound the number of free blocks, the tightest first."""
        blocks = [self._pieces[i] for i in self._free if self._pieces[i].role == "block"]
        if len(blocks) < 2:
            return ()
        kinds = list({piece.key: piece for piece in blocks}.values())
        common = -1
        for a in kinds:
            for b in kinds:
                common &= self._template(a, b)
        ways = sorted(masks.crowding_tiles(self._world, common), key=len)
        return tuple(ways[:2])

    def _own_points(self, piece: Piece) -> int:
        """Return the points that a piece may take by itself."""
        if piece.role == "start":
            return masks.world_mask(self._world)
        mask = masks.playground_mask(self._world, piece.shape)
        for requirement in self._requirements:
            if isinstance(requirement, Region):
                mask &= masks.points_where(
                    self._world,
                    lambda x, y, rule=requirement: not broken_by_piece(rule, piece, x, y),  # type: ignore[misc]
                )
        return mask

    def _forbidden(self, placed: Piece, other: Piece, bit: int) -> int:
        return masks.shifted(self._world, self._template(placed, other), bit)

    def _template(self, a: Piece, b: Piece) -> int:
        """Return the offsets from one piece at which another must not be."""
        pair = (a.key, b.key)
        template = self._templates.get(pair)
        if template is None:
            template = self._templates[pair] = self._make_template(a, b)
        return template

    def _make_template(self, a: Piece, b: Piece) -> int:
        world = self._world
        is_between_blocks = a.role == b.role == "block"
        template = 0
        if is_between_blocks:
            template = masks.room_template(world, a.shape, b.shape)
        elif a.is_target or b.is_target:
            template = masks.offset_bit(world, 0, 0)
        for requirement in self._requirements:
            if isinstance(requirement, Gap) and is_between_blocks:
                template |= masks.relation_template(world, requirement.relation, is_gap=True)
            elif isinstance(requirement, Distance) and concerns(requirement, a, b):
                template |= masks.relation_template(world, requirement.relation, is_gap=False)
        return template
