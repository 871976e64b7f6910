from __future__ import annotations

import itertools
from collections import Counter

import pytest

from dsl.draws import Draws
from dsl.errors import InfeasibleLayout
from dsl.interpreter import Task
from dsl.layout.demand import Demand
from dsl.program import Gap, Program, Selector
from tests.dsl.corpus import SCRIPTS
from tests.dsl.hosts import RememberingHost
from tests.dsl.scripts import program, script

SIZES_MM = {"cube": (33.0, 33.0), "cylinder": (33.0, 33.0), "bridge": (33.0, 100.0)}


def mash() -> Program:
    from dsl.library import library_script

    return program(library_script("mash"))


def task(compiled: Program, seed: int = 1, goal: str = "G", environment: str = "E") -> Task:
    return Task(compiled, goal, environment, seed, RememberingHost())


Box = tuple[float, float, float, float]


def boxes(item: tuple[str, int, int, float]) -> tuple[Box, list[Box]]:
    """Return a block's footprint and its two finger zones, in millimetres on the lattice.

    Written out from the physical facts, apart from the code under test.
    """
    kind, x, y = item[0], 20.0 * item[1], 20.0 * item[2]
    width, length = (size / 2 for size in SIZES_MM[kind])
    if item[3] % 180 == 90:
        return (x - length, y - width, x + length, y + width), [
            (x - 10, y - 38, x + 10, y - 16.5),
            (x - 10, y + 16.5, x + 10, y + 38),
        ]
    return (x - width, y - length, x + width, y + length), [
        (x - 38, y - 10, x - 16.5, y + 10),
        (x + 16.5, y - 10, x + 38, y + 10),
    ]


def meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def assert_sound(laid: Task) -> None:
    """Check everything that the reference promises of a layout."""
    world = laid.environment.world
    items = [(p.kind, p.x, p.y, p.yaw_deg) for p in laid.placements]
    for first, second in itertools.combinations(items, 2):
        body, zones = boxes(first)
        other, other_zones = boxes(second)
        assert not meet(body, other), (first, second)
        assert not any(meet(zone, other) for zone in zones), (first, second)
        assert not any(meet(zone, body) for zone in other_zones), (first, second)
        gap = max(abs(first[1] - second[1]), abs(first[2] - second[2]))
        for rule in laid.environment.requirements:
            assert not isinstance(rule, Gap) or rule.relation.holds(gap)
    for item in items:
        left, bottom, right, top = boxes(item)[0]
        assert left >= -20
        assert bottom >= -20
        assert right <= 20 * world.width
        assert top <= 20 * world.height
    slots = [p.slot for p in laid.placements]
    assert len(set(slots)) == len(slots)
    goal = laid.goal.target
    targets = [p for p in laid.placements if (p.kind, p.colour) == (goal.kind, goal.colour)]
    assert [(p.x, p.y) for p in targets] == [laid.target]
    assert world.holds(*laid.start)


@pytest.mark.parametrize("goal", ["ReachRedCube", "ReachRedCube.Random"])
def test_500_seeds_of_the_random_environment_keep_every_rule(goal: str) -> None:
    compiled = mash()
    counts: Counter[int] = Counter()
    for seed in range(500):
        laid = task(compiled, seed, goal, "RANDOM_12x12")
        assert_sound(laid)
        counts[len(laid.placements)] += 1
    assert set(counts) == {4, 5, 6, 7}
    assert min(counts.values()) > 70


@pytest.mark.parametrize("environment", ["STATIC_12x12", "STATIC_8x6", "STATIC_4x4"])
def test_a_random_target_comes_everywhere_and_keeps_every_rule(environment: str) -> None:
    compiled = mash()
    seen = set()
    for seed in range(500):
        laid = task(compiled, seed, "ReachRedCube.Random", environment)
        assert_sound(laid)
        seen.add(laid.target)
    world = compiled.environments[environment].world
    assert len(seen) > 0.4 * world.width * world.height
    assert (0, 0) not in seen


def test_dense_layouts_are_found_for_every_seed() -> None:
    compiled = program((SCRIPTS / "valid" / "dense.cell").read_text("utf-8"))
    layouts = set()
    for seed in range(50):
        laid = task(compiled, seed, "Find", "DENSE")
        assert_sound(laid)
        layouts.add(laid.placements)
    assert len(layouts) == 50


def test_turned_blocks_and_requirements_are_kept() -> None:
    compiled = program((SCRIPTS / "valid" / "everything.cell").read_text("utf-8"))
    for seed in range(100):
        laid = task(compiled, seed, "Second.Random", "FULL")
        assert_sound(laid)
        (sx, sy), (tx, ty) = laid.start, laid.target
        assert abs(sx - tx) + abs(sy - ty) >= 4
        for block in laid.placements:
            if (block.kind, block.colour) == ("cube", "blue"):
                assert block.y <= 4
            if block.kind == "cylinder":
                assert abs(block.x - tx) + abs(block.y - ty) > 2


def test_a_layout_is_a_function_of_the_seed() -> None:
    compiled, again = mash(), mash()
    layouts = set()
    for seed in range(50):
        first = task(compiled, seed, "ReachRedCube.Random", "RANDOM_12x12")
        second = task(again, seed, "ReachRedCube.Random", "RANDOM_12x12")
        assert first.placements == second.placements
        layouts.add(first.placements)
    assert len(layouts) == 50


def test_the_layout_of_a_recorded_seed_stays_as_it_is() -> None:
    laid = task(mash(), 2011, "ReachRedCube.Random", "RANDOM_12x12")
    assert [(p.slot, p.x, p.y) for p in laid.placements] == RECORDED


def test_the_generator_gives_the_published_numbers() -> None:
    draws = Draws(1234567)
    assert [draws.word() for _ in range(3)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
    ]


def test_draws_below_a_limit_are_even() -> None:
    draws = Draws(7)
    counts = Counter(draws.below(7) for _ in range(7000))
    assert set(counts) == set(range(7))
    assert all(850 < count < 1150 for count in counts.values())


def test_blocks_come_from_the_lowest_slots_of_their_sort() -> None:
    text = script("place cube red at (3, 3)\nplace 2 of cube blue at random", world="9 x 9")
    slots = {(p.kind, p.colour, p.slot) for p in task(program(text)).placements}
    assert slots == {("cube", "red", 3), ("cube", "blue", 4), ("cube", "blue", 5)}


def test_open_places_never_draw_a_second_target() -> None:
    text = script("place cube red at (8, 8)\nplace 4 of any at random", world="9 x 9")
    compiled = program(text)
    for seed in range(100):
        laid = task(compiled, seed)
        assert sum((p.kind, p.colour) == ("cube", "red") for p in laid.placements) == 1


def test_open_places_never_draw_what_sticks_out_everywhere() -> None:
    compiled = program(script("place cube red at (3, 3)\nplace 1 of any at random"))
    kinds = {p.kind for seed in range(60) for p in task(compiled, seed).placements}
    assert kinds == {"cube", "cylinder"}


def first_infeasible(text: str) -> str:
    """Return the blame of the first seed that has no layout."""
    compiled = program(text)
    errors = [error for seed in range(40) if (error := refusal(compiled, seed)) is not None]
    assert [error.seed for error in errors] == sorted(error.seed for error in errors)
    return errors[0].blame


def refusal(compiled: Program, seed: int) -> InfeasibleLayout | None:
    try:
        task(compiled, seed)
    except InfeasibleLayout as error:
        return error
    return None


def test_too_large_a_gap_is_blamed_with_what_would_fit() -> None:
    text = script(
        "place cube red at (3, 3)\nplace 0 to 2 of cube blue at random\nrequire gap >= 3"
        "\nrequire any blue inside (0, 0) to (0, 2)"
    )
    assert first_infeasible(text) == (
        "with `gap >= 3` at most 2 blocks fit into 4 x 4, 3 are asked for"
    )


def test_too_many_blocks_for_the_world_are_blamed_on_the_fingers() -> None:
    text = script("place 0 to 2 of cube blue at random\nplace cube red at (0, 0)", world="4 x 2")
    assert first_infeasible(text) == (
        "with room for the fingers at most 2 blocks fit into 4 x 2, 3 are asked for"
    )


def test_a_shortage_names_what_is_short() -> None:
    red, open_one = Selector("cube", "red"), Selector(None, None)
    stock = {("cube", "red"): 2, ("cube", "blue"): 1}
    assert str(Demand([red] * 3, stock).shortage()) == (
        "3 blocks `cube red` asked for, the store has 2"
    )
    assert Demand([open_one, red, red], stock).shortage() is None
    assert str(Demand([open_one] * 2 + [red] * 2, stock).shortage()) == (
        "4 blocks (2 `any`, 2 `cube red`) asked for, the store has 3 for them"
    )
    assert str(Demand([open_one] * 2, stock, {("cube", "red")}).shortage()) == (
        "2 blocks `any` asked for, the store has 1"
    )


RECORDED = [(11, 11, 7), (15, 2, 4), (5, 9, 5), (6, 8, 1), (17, 4, 7), (7, 2, 1)]
