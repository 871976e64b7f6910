from __future__ import annotations

import pytest

from cell.profile import CellProfile, Profile, load_cell_profile, parse_profile, profile_text
from cell.profile.checking import check_profile
from cell.profile.compare import ABSENT, differences
from cell.profile.fresh import fresh_profile
from cell.profile.listing import listed_values
from cell.profile.loading import parse_cell_profile
from cell.profile.reference import PAGE, reference_page
from cell.profile.schema import Node, Schema, schema_of
from cell.profile.sources import ProfileSource, find_profile, shipped_profiles


def test_the_reference_page_is_up_to_date() -> None:
    stale = "the page is stale: run python -m cell.profile.reference"
    assert PAGE.read_text("utf-8") == reference_page(), stale


def undocumented(schema: Schema, node: Node, path: str) -> list[str]:
    missing = []
    for field in schema.fields(node):
        where = f"{path}.{field.name}"
        if not field.words:
            missing.append(where)
        inner = list(schema.variants(field.node).values())
        element = schema.element(field.node)
        inner += [schema.table(field.node, {})] if element is None else [element]
        for table in inner:
            missing += undocumented(schema, table, where)
    return missing


@pytest.mark.parametrize("model", [CellProfile, Profile])
def test_every_field_says_what_it_is_for(model: type[CellProfile]) -> None:
    schema = schema_of(model)
    assert undocumented(schema, schema.root, model.__name__) == []


@pytest.mark.parametrize("name", shipped_profiles())
def test_a_new_profile_has_the_figures_of_its_base_and_every_field_explained(name: str) -> None:
    text = fresh_profile("mine", find_profile(name))
    fresh = parse_cell_profile(text, "mine")
    base = load_cell_profile(name)
    assert fresh == base.model_copy(update={"name": "mine"})
    before = ""
    for line in text.split("\n"):
        if "=" in line and not line.startswith("#"):
            assert before.startswith("#"), line
        before = line


def test_a_new_profile_takes_the_ports_that_were_chosen() -> None:
    text = fresh_profile("mine", find_profile("mash"), {"gripper": "/dev/ttyUSB3"})
    fresh = parse_profile(text, "mine")
    assert fresh.gripper.serial.port == "/dev/ttyUSB3"
    assert fresh.arm.serial.port == "COM9"


def test_each_value_tells_its_line_or_that_it_is_a_default() -> None:
    source = find_profile("mash")
    listed = {one.field: one for one in listed_values(check_profile(source))}
    baud = listed["arm.serial.baud"]
    assert (baud.value, baud.unit) == (38400, "bit/s")
    assert baud.line is not None
    assert "baud = 38400" in source.text.split("\n")[baud.line - 1]
    assert listed["server.idle_timeout_s"].line is None
    assert listed["boxes[1].name"].value == "left camera pillar"
    assert listed["blocks.cube.width_mm"].unit == "mm"


def changed(old: str, new: str) -> Profile:
    text = profile_text("mash")
    assert old in text
    return parse_profile(text.replace(old, new, 1), "changed")


def test_two_profiles_differ_by_meaning_only() -> None:
    mash = parse_profile(profile_text("mash"), "mash")
    assert differences(mash, changed("port = 10993", "port = 10_993   # the same")) == ()
    assert differences(mash, changed("stroke_mm = 70", "stroke_mm = 70.0")) == ()
    assert differences(mash, changed("[server]", "[server]\nmax_connections = 16")) == ()


def test_boxes_are_compared_by_name_whatever_their_order() -> None:
    first = parse_profile(profile_text("mash"), "mash")
    second = first.model_copy(update={"boxes": first.boxes[::-1]})
    assert differences(first, second) == ()
    third = first.model_copy(update={"boxes": first.boxes[1:]})
    found = differences(first, third)
    assert [one.field for one in found] == [
        f"boxes.table.{f}" for f in ("name", "min_mm", "max_mm")
    ]
    assert all(one.second is ABSENT for one in found)


def test_a_difference_names_field_values_and_unit() -> None:
    mash = parse_profile(profile_text("mash"), "mash")
    (found,) = differences(mash, changed("step_mm = 20", "step_mm = 25"))
    assert (found.field, found.first, found.second, found.unit) == (
        "lattice.step_mm", 20.0, 25.0, "mm",
    )  # fmt: skip


def test_a_table_that_one_has_is_told_field_by_field() -> None:
    mash = parse_profile(profile_text("mash"), "mash")
    other = changed("robot = 1", 'robot = 1\ntcp = { host = "h", port = 1 }')
    fields = {one.field for one in differences(mash, other)}
    assert fields == {"arm.tcp.host", "arm.tcp.port", "arm.tcp.connect_timeout_s"}


def test_a_broken_base_makes_no_new_profile() -> None:
    broken = ProfileSource("broken.toml", "name = 3")
    with pytest.raises(Exception, match=r"broken\.toml cannot be used"):
        fresh_profile("mine", broken)
