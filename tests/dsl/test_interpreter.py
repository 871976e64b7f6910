from __future__ import annotations

from collections import deque

import pytest

from dsl.errors import TaskEnded, UnknownName
from dsl.interpreter import Outcome, Task
from dsl.library import library_script
from dsl.program import World
from dsl.teacher import distances, first_step
from tests.dsl.hosts import RememberingHost
from tests.dsl.scripts import ACTIONS, STORE, program, script


def begun(text: str, seed: int = 1) -> tuple[Task, RememberingHost]:
    host = RememberingHost()
    return Task(program(text), "G", "E", seed, host), host


def test_setting_up_shows_lays_out_and_goes_to_the_start_in_this_order() -> None:
    task, host = begun(
        script(
            "background water travel 70 mm place cube red at (3, 3)", "start (1, 2) target cube red"
        )
    )
    task.set_up()
    assert host.calls == [
        ("show", "water"),
        ("lay_out", task.placements),
        ("move_to", 1, 2, 70.0),
    ]


def test_making_a_task_moves_nothing() -> None:
    assert begun(script())[1].calls == []


def test_a_move_goes_one_step_and_earns_its_rule() -> None:
    task, host = begun(script())
    assert task.act("RIGHT") == Outcome(1, 0.0, None, "running", has_moved=True)
    assert task.position == (1, 0)
    assert host.calls == [("move_to", 1, 0, 65.0)]


@pytest.mark.parametrize("action", ["LEFT", "DOWN"])
def test_a_wall_earns_its_rule_and_moves_nothing(action: str) -> None:
    task, host = begun(script())
    assert task.act(action) == Outcome(1, -10.0, "wall", "running", has_moved=False)
    assert task.position == (0, 0)
    assert host.calls == []


def test_the_target_finishes_the_task_until_it_is_reset() -> None:
    task, host = begun(script("place cube red at (1, 0)"))
    assert task.act("RIGHT") == Outcome(1, 20.0, "there", "finished", has_moved=True)
    with pytest.raises(TaskEnded, match="finished; reset it"):
        task.act("LEFT")
    before = task.placements
    task.reset()
    assert (task.position, task.steps, task.status) == ((0, 0), 0, "running")
    assert task.placements == before
    assert host.calls[-1] == ("move_to", 0, 0, 65.0)
    assert task.act("RIGHT").step == 1


def test_an_action_the_environment_lacks_is_refused_without_a_step() -> None:
    task, host = begun(script(actions="UP, RIGHT"))
    with pytest.raises(UnknownName, match="there is no action 'LEFT'; there are: UP, RIGHT"):
        task.act("LEFT")
    assert (task.steps, host.calls) == (0, [])


def test_an_unknown_goal_or_environment_is_named() -> None:
    compiled = program(script())
    with pytest.raises(UnknownName, match="no goal 'H'; there are: G"):
        Task(compiled, "H", "E", 1, RememberingHost())
    with pytest.raises(UnknownName, match="no environment of G 'F'; there are: E"):
        Task(compiled, "G", "F", 1, RememberingHost())


def test_an_error_of_the_host_leaves_the_task_as_it_was() -> None:
    task, host = begun(script())
    host.is_broken = True
    with pytest.raises(OSError, match="cable"):
        task.act("UP")
    assert (task.position, task.steps, task.status) == ((0, 0), 0, "running")


def test_a_long_move_is_whole_or_not_at_all() -> None:
    text = script(
        declarations=STORE + ACTIONS + "action JUMP { move (2, 1) }\n",
        actions="JUMP, UP, LEFT, DOWN, RIGHT",
    )
    task, _ = begun(text)
    assert task.act("JUMP").has_moved
    assert task.position == (2, 1)
    assert not task.act("JUMP").has_moved
    assert task.position == (2, 1)


RULES = """
  when hit wall reward -1 event "wall"
  when above cube blue reward 5 event "blue"
  when above target reward 20 finish event "target"
  when above block reward 3 event "block"
  after 4 steps reward -7 fail event "late"
  otherwise reward 0.25
"""


@pytest.mark.parametrize(
    ("actions", "reward", "event", "status"),
    [
        ("L", -1.0, "wall", "running"),
        ("R", 0.25, None, "running"),
        ("U", 5.0, "blue", "running"),
        ("RRR", 20.0, "target", "finished"),
        ("RUURR", -7.0, "late", "failed"),
        ("UUU", 3.0, "block", "running"),
        ("LLLL", -1.0, "wall", "running"),
        ("LLLR", -7.0, "late", "failed"),
    ],
)
def test_exactly_the_first_rule_that_holds_applies(
    actions: str, reward: float, event: str | None, status: str
) -> None:
    names = {"U": "UP", "D": "DOWN", "L": "LEFT", "R": "RIGHT"}
    blocks = "place cube red at (3, 0) place cube blue at (0, 1) place cylinder green at (0, 3)"
    task, _ = begun(script(blocks, rules=RULES))
    outcomes = []
    for letter in actions:
        outcomes.append(task.act(names[letter]))
        if task.status != "running":
            break
    last = outcomes[-1]
    assert (last.reward, last.event, last.status) == (reward, event, status)
    assert [outcome.step for outcome in outcomes] == list(range(1, len(outcomes) + 1))


@pytest.mark.parametrize("goal", ["ReachRedCube", "ReachRedCube.Random"])
@pytest.mark.parametrize(
    "environment", ["STATIC_12x12", "STATIC_8x6", "STATIC_4x4", "RANDOM_12x12"]
)
def test_the_teacher_reaches_the_target_in_as_many_steps_as_it_is_away(
    goal: str, environment: str
) -> None:
    compiled = program(library_script("mash"))
    for seed in range(25):
        task = Task(compiled, goal, environment, seed, RememberingHost())
        away = abs(task.target[0] - task.start[0]) + abs(task.target[1] - task.start[1])
        outcome = None
        while (action := task.suggest()) is not None:
            outcome = task.act(action)
        assert outcome is not None
        assert (outcome.step, outcome.reward, outcome.status) == (away, 20.0, "finished")
        assert outcome.event == "Target reached"


MOVE_SETS = [
    ((0, 1), (0, -1), (1, 0), (-1, 0)),
    ((1, 2), (2, 1), (-1, 2), (-2, 1), (1, -2), (2, -1), (-1, -2), (-2, -1)),
    ((3, 0), (-2, 0), (0, 1), (0, -4)),
    ((1, 1), (-1, 0)),
    ((0, 1),),
]


def plain_distance(
    world: World,
    moves: tuple[tuple[int, int], ...],
    start: tuple[int, int],
    target: tuple[int, int],
) -> int:
    """Search forward from the start, as a client would have to."""
    seen = {start: 0}
    waiting = deque([start])
    while waiting:
        here = waiting.popleft()
        for dx, dy in moves:
            there = (here[0] + dx, here[1] + dy)
            if world.holds(*there) and there not in seen:
                seen[there] = seen[here] + 1
                waiting.append(there)
    return seen.get(target, -1)


@pytest.mark.parametrize("moves", MOVE_SETS)
def test_the_teacher_is_on_a_shortest_way_for_any_set_of_actions(
    moves: tuple[tuple[int, int], ...],
) -> None:
    world = World(7, 6)
    target = (5, 2)
    table = distances(world, moves, target)
    for y in range(world.height):
        for x in range(world.width):
            away = plain_distance(world, moves, (x, y), target)
            assert table[y * world.width + x] == away
            index = first_step(world, moves, target, (x, y))
            if away <= 0:
                assert index is None
                continue
            assert index is not None
            ways = [
                plain_distance(world, moves, (x + dx, y + dy), target)
                if world.holds(x + dx, y + dy)
                else -1
                for dx, dy in moves
            ]
            assert index == ways.index(away - 1)


def test_of_equally_good_actions_the_teacher_takes_the_first_listed() -> None:
    right_first, _ = begun(script(actions="RIGHT, UP, LEFT, DOWN"))
    up_first, _ = begun(script(actions="UP, RIGHT, LEFT, DOWN"))
    assert right_first.suggest() == "RIGHT"
    assert up_first.suggest() == "UP"
