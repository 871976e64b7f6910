from __future__ import annotations

import pytest

from dsl.compiler import compile_script
from dsl.errors import DslError, UnknownName
from dsl.library import library_names, library_script
from tests.dsl.scripts import program, script


def test_the_mash_script_says_what_the_platform_has() -> None:
    mash = program(library_script("mash"))
    assert list(mash.goals) == ["ReachRedCube", "ReachRedCube.Random"]
    assert list(mash.environments) == ["STATIC_12x12", "STATIC_8x6", "STATIC_4x4", "RANDOM_12x12"]
    for goal in mash.goals.values():
        assert goal.environments == tuple(mash.environments)
    worlds = [(e.world.width, e.world.height) for e in mash.environments.values()]
    assert worlds == [(12, 12), (8, 6), (4, 4), (12, 12)]
    for environment in mash.environments.values():
        assert environment.actions == ("UP", "DOWN", "RIGHT", "LEFT")
        assert environment.is_teaching
        assert (environment.background, environment.travel_mm) == ("black", 65.0)
        assert [(v.name, v.mime, v.width_px, v.height_px) for v in environment.views] == [
            ("CAMERA_TOP", "image/mif", 1280, 960),
            ("CAMERA_OBLIQUE", "image/mif", 1280, 960),
            ("CAMERA_GRIPPER", "image/mif", 1280, 960),
        ]
    moves = {name: (a.dx, a.dy) for name, a in mash.actions.items()}
    assert moves == {"UP": (0, 1), "DOWN": (0, -1), "RIGHT": (1, 0), "LEFT": (-1, 0)}


def test_the_mash_store_is_the_printed_plan() -> None:
    slots = program(library_script("mash")).store.slots
    assert [slot.number for slot in slots] == list(range(1, 19))
    assert sum(slot.kind == "cube" for slot in slots) == 12
    assert sum(slot.kind == "bridge" for slot in slots) == 2
    assert sum(slot.kind == "cylinder" for slot in slots) == 4
    red_cylinder = slots[17]
    assert (red_cylinder.kind, red_cylinder.colour) == ("cylinder", "red")
    assert (red_cylinder.x_mm, red_cylinder.y_mm) == (495.0, 350.0)


def test_defaults_are_those_of_the_reference() -> None:
    compiled = program(script())
    environment, goal = compiled.environments["E"], compiled.goals["G"]
    assert (environment.background, environment.travel_mm) == ("black", 65.0)
    assert (environment.views, environment.is_teaching) == ((), False)
    assert goal.start.within(environment.world) == (0, 0)


@pytest.mark.parametrize(
    ("views", "described"),
    [
        ("views A", [("A", "image/mif", 1280)]),
        ("views A, B as png 640x480", [("A", "image/png", 640), ("B", "image/png", 640)]),
        ("views A as 800x600, B as jpeg", [("A", "image/mif", 800), ("B", "image/jpeg", 1280)]),
        ("views A as ppm, B, C as pgm 1024 x 768, D",
         [("A", "image/ppm", 1280), ("B", "image/pgm", 1024), ("C", "image/pgm", 1024),
          ("D", "image/mif", 1280)]),
    ],
)  # fmt: skip
def test_a_view_takes_what_stands_after_the_next_as(
    views: str, described: list[tuple[str, str, int]]
) -> None:
    environment = program(script(f"{views}\nplace cube red at (3, 3)")).environments["E"]
    assert [(v.name, v.mime, v.width_px) for v in environment.views] == described


def extended(statements: str) -> str:
    base = "background water teaching on place cube red at (3, 3) place cube blue at (0, 3)"
    text = script(base + "\nrequire gap >= 2")
    return text.replace("in E", "in E, F") + f"environment F extends E {{ {statements} }}\n"


def test_an_environment_takes_over_what_it_does_not_state() -> None:
    environments = program(extended("")).environments
    base, other = environments["E"], environments["F"]
    assert (other.world, other.background, other.is_teaching) == (base.world, "water", True)
    assert (other.places, other.requirements) == (base.places, base.requirements)


def test_what_an_environment_states_replaces_that_sort_of_statement() -> None:
    other = program(extended("place cube red at (2, 0) teaching off")).environments["F"]
    assert [str(place.selector) for place in other.places] == ["cube red"]
    assert not other.is_teaching
    assert len(other.requirements) == 1


def test_place_nothing_takes_over_no_blocks() -> None:
    text = extended("place nothing").replace("in E, F", "in E")
    text += "goal H { in F target cube red at (1, 1) otherwise finish }\n"
    assert program(text).environments["F"].places == ()


def test_a_target_that_the_goal_places_replaces_the_one_of_the_environment() -> None:
    from dsl.interpreter import Task
    from tests.dsl.hosts import RememberingHost

    compiled = program(script("place cube red at (3, 3)", "target cube red at (3, 0)"))
    task = Task(compiled, "G", "E", 1, RememberingHost())
    assert [(p.kind, p.x, p.y) for p in task.placements] == [("cube", 3, 0)]


def test_mappings_of_a_program_cannot_be_changed() -> None:
    goals = program(script()).goals
    with pytest.raises(TypeError):
        goals["other"] = goals["G"]  # type: ignore[index]


def test_the_order_of_declarations_does_not_matter() -> None:
    text = script()
    store_end = text.index("environment")
    swapped = text[store_end:] + text[:store_end]
    assert compile_script(swapped, "test").diagnostics == ()


def test_a_name_the_library_does_not_have_is_refused() -> None:
    assert library_names() == ["mash"]
    with pytest.raises(UnknownName, match="no shipped script '../mash'; there are: mash"):
        library_script("../mash")
    assert issubclass(UnknownName, DslError)


def test_a_long_chain_of_extends_is_no_trouble() -> None:
    text = script().replace("in E", "in E3000")
    text = text.replace("environment E {", "environment E0 {")
    text += "".join(f"environment E{i} extends E{i - 1} {{ }}\n" for i in range(1, 3001))
    assert compile_script(text, "test").diagnostics == ()
