from __future__ import annotations

import itertools
import random

import pytest

from dsl.draws import Draws
from dsl.kinds import LATTICE_STEP_MM, border_steps, clash, shape_of
from dsl.layout.blame import blame
from dsl.layout.pieces import Piece, broken_by_pair, broken_by_piece
from dsl.layout.search import Search
from dsl.program import (
    Distance,
    Gap,
    Party,
    Region,
    Relation,
    Requirement,
    Selector,
    World,
)
from dsl.spans import NOWHERE


def block(
    kind: str = "cube", colour: str = "red", point: tuple[int, int] | None = None, yaw: float = 0.0
) -> Piece:
    return Piece("block", kind, colour, yaw, is_target=False, point=point, span=NOWHERE)


def gap(limit: int) -> Gap:
    return Gap(Relation(">=", limit), NOWHERE)


def distance(first: str, second: str, sign: str, limit: int) -> Distance:
    def party(colour: str) -> Party:
        return Party("blocks", Selector(None, colour))

    return Distance(party(first), party(second), Relation(sign, limit), NOWHERE)


def is_allowed(
    world: World,
    pieces: list[Piece],
    points: tuple[tuple[int, int], ...],
    rules: list[Requirement],
) -> bool:
    """Check an arrangement rule by rule, without any of the search's short cuts."""
    for piece, (x, y) in zip(pieces, points, strict=True):
        side, end = border_steps(piece.shape)
        if not (side <= x < world.width - side and end <= y < world.height - end):
            return False
        if any(broken_by_piece(rule, piece, x, y) for rule in rules):
            return False
    pairs = itertools.combinations(zip(pieces, points, strict=True), 2)
    for (a, (ax, ay)), (b, (bx, by)) in pairs:
        dx, dy = bx - ax, by - ay
        if clash(a.shape, b.shape, dx * LATTICE_STEP_MM, dy * LATTICE_STEP_MM):
            return False
        if any(broken_by_pair(rule, a, b, dx, dy) for rule in rules):
            return False
    return True


def exists(world: World, pieces: list[Piece], rules: list[Requirement]) -> bool:
    """Say whether there is an arrangement, by trying all of them."""
    cells = list(itertools.product(range(world.width), range(world.height)))
    choices = [[piece.point] if piece.point else cells for piece in pieces]
    return any(is_allowed(world, pieces, points, rules) for points in itertools.product(*choices))


@pytest.mark.parametrize("seed", range(120))
def test_the_search_agrees_with_trying_everything(seed: int) -> None:
    dice = random.Random(seed)
    world = World(dice.randint(2, 6), dice.randint(2, 5))
    pieces = [
        block(
            dice.choice(("cube", "cube", "cylinder", "bridge")),
            dice.choice(("red", "blue")),
            yaw=dice.choice((0.0, 0.0, 90.0)),
        )
        for _ in range(dice.randint(1, 3))
    ]
    offers: list[Requirement] = [
        gap(dice.randint(1, 4)),
        distance("red", "blue", dice.choice((">=", "<=", "=", "<", ">")), dice.randint(1, 6)),
        Region(Selector(None, "red"), dice.random() < 0.5, 0, 0, 2, 1, NOWHERE),
    ]
    rules = dice.sample(offers, dice.randint(0, 3))
    outcome = Search(world, pieces, rules).run(Draws(seed))
    assert outcome.verdict == ("found" if exists(world, pieces, rules) else "impossible")
    if outcome.verdict == "found":
        assert is_allowed(world, pieces, outcome.points, rules)
    else:
        assert blame(world, pieces, rules)
    if Search(world, pieces, rules).surely_succeeds():
        assert outcome.verdict == "found"


@pytest.mark.parametrize(
    ("world", "limit", "most"),
    [(World(4, 4), 6, 1), (World(12, 12), 6, 4), (World(12, 12), 5, 9), (World(12, 12), 3, 16),
     (World(4, 4), 1, 4), (World(12, 12), 1, 24), (World(30, 20), 4, 40)],
)  # fmt: skip
def test_exactly_as_many_blocks_fit_as_the_gap_leaves_room_for(
    world: World, limit: int, most: int
) -> None:
    assert Search(world, [block()] * most, [gap(limit)]).run(Draws(1)).verdict == "found"
    too_many = Search(world, [block()] * (most + 1), [gap(limit)])
    assert too_many.run(Draws(1)).verdict == "impossible"


def test_the_blame_counts_what_fits() -> None:
    blocks = [block()] * 5
    assert blame(World(12, 12), blocks, [gap(6)]) == (
        "with `gap >= 6` at most 4 blocks fit into 12 x 12, 5 are asked for"
    )
    assert blame(World(4, 4), blocks, []) == (
        "with room for the fingers at most 4 blocks fit into 4 x 4, 5 are asked for"
    )


def test_the_blame_names_the_requirement_that_leaves_no_point() -> None:
    rule = Region(Selector("cube", None), True, 20, 20, 30, 30, NOWHERE)
    assert blame(World(4, 4), [block()], [gap(1), rule]) == (
        "`cube inside (20, 20) to (30, 30)` leaves no point of 4 x 4 for cube red"
    )


def test_the_blame_names_requirements_that_only_together_are_too_much() -> None:
    rules = [distance("red", "blue", ">=", 5), distance("red", "blue", "<=", 4)]
    pieces = [block(), block(colour="blue")]
    assert blame(World(9, 9), pieces, rules[:1] * 2 + rules[1:] * 2) == (
        "`distance(red, blue) >= 5`, `distance(red, blue) >= 5`, "
        "`distance(red, blue) <= 4`, `distance(red, blue) <= 4` cannot be kept together in 9 x 9"
    ).replace("(red, blue)", "(any red, any blue)")


def test_the_blame_names_the_fixed_blocks_when_nothing_is_left() -> None:
    world = World(3, 3)
    pieces = [block(point=(1, 1)), block()]
    assert blame(world, pieces, []) == (
        "beside the fixed blocks no point of 3 x 3 is left for cube red"
    )


@pytest.mark.parametrize("count", [18, 40, 60, 100])
def test_a_hopeless_search_ends_within_its_budget(count: int) -> None:
    rules: list[Requirement] = [distance("red", "red", "<=", 9), gap(2)]
    search = Search(World(40, 40), [block()] * count, rules)
    assert search.run(Draws(1), budget=3000).verdict in ("impossible", "open")


def test_crossing_bridges_are_placed_around_each_other() -> None:
    world = World(9, 9)
    pieces = [block("bridge"), block("bridge", yaw=90.0), block("bridge", yaw=-90.0)]
    for seed in range(50):
        outcome = Search(world, pieces, []).run(Draws(seed))
        assert is_allowed(world, pieces, outcome.points, [])


@pytest.mark.parametrize(
    ("dx", "dy", "trouble"),
    [(0, 0, "overlap"), (1, 0, "overlap"), (0, 1, "overlap"), (1, 1, "overlap"),
     (2, 0, "fingers"), (2, 1, "fingers"), (-2, -1, "fingers"),
     (3, 0, None), (0, 2, None), (1, 2, None), (2, 2, None), (-3, 0, None)],
)  # fmt: skip
def test_two_cubes_need_three_steps_aside_or_two_above(
    dx: int, dy: int, trouble: str | None
) -> None:
    cube = shape_of("cube", 0.0)
    assert clash(cube, cube, dx * LATTICE_STEP_MM, dy * LATTICE_STEP_MM) == trouble


@pytest.mark.parametrize(
    ("dx", "dy", "trouble"),
    [(0, 3, "overlap"), (0, 4, None), (2, 2, "fingers"), (2, 3, None), (3, 0, None)],
)
def test_a_bridge_is_three_times_as_long(dx: int, dy: int, trouble: str | None) -> None:
    bridge, cube = shape_of("bridge", 0.0), shape_of("cube", 0.0)
    step = LATTICE_STEP_MM
    assert clash(bridge, cube, dx * step, dy * step) == trouble
    across = shape_of("bridge", 90.0)
    turned_cube = shape_of("cube", 90.0)
    assert clash(across, turned_cube, dy * step, dx * step) == trouble


def test_a_bridge_keeps_its_ends_on_the_playground() -> None:
    assert border_steps(shape_of("cube", 0.0)) == (0, 0)
    assert border_steps(shape_of("bridge", 0.0)) == (0, 2)
    assert border_steps(shape_of("bridge", 90.0)) == (2, 0)
