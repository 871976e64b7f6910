from __future__ import annotations

from collections.abc import Collection

from dsl.kinds import COLOURS, KINDS
from dsl.library import library_script
from dsl.program import Slot
from dsl.site import check_on_site
from tests.dsl.scripts import program


class Cell:
    """A cell whose answers a test can change."""

    def __init__(self) -> None:
        self.kinds: Collection[str] = list(KINDS)
        self.colours: Collection[str] = COLOURS
        self.cameras = ["CAMERA_TOP", "CAMERA_OBLIQUE", "CAMERA_GRIPPER"]
        self.far: set[tuple[int, int]] = set()
        self.far_slots: set[int] = set()
        self.known_mm: dict[str, float] = {}
        self.hidden: set[tuple[str, int, int]] = set()

    def reach(self, x: int, y: int, travel_mm: float) -> str | None:
        return "J2 beyond its limit" if (x, y) in self.far else None

    def reach_slot(self, slot: Slot) -> str | None:
        return "J1 beyond its limit" if slot.number in self.far_slots else None

    def sees(self, view: str, x: int, y: int) -> bool:
        return (view, x, y) not in self.hidden

    def lattice_accuracy(self, limit_mm: float) -> str | None:
        known_mm = self.known_mm.get("lattice", 0.0)
        return f"the lattice has {known_mm:g} mm" if known_mm > limit_mm else None

    def view_accuracy(self, view: str, limit_mm: float) -> str | None:
        known_mm = self.known_mm.get(view, 0.0)
        return f"{view} has {known_mm:g} mm" if known_mm > limit_mm else None

    def has_camera(self, view: str) -> bool:
        return view in self.cameras


def findings(cell: Cell) -> list[tuple[str, str]]:
    return [(d.code, d.message) for d in check_on_site(program(library_script("mash")), cell)]


def test_a_program_fits_a_cell_that_has_everything() -> None:
    assert findings(Cell()) == []


def test_points_out_of_reach_are_counted_once_an_environment() -> None:
    cell = Cell()
    cell.far = {(0, 0), (11, 11)}
    assert findings(cell) == [
        (
            "E701",
            f"the arm does not reach {share} of {name}, such as (0, 0): J2 beyond its limit",
        )
        for name, share in (
            ("STATIC_12x12", "2 of the 144 lattice points"),
            ("STATIC_8x6", "1 of the 48 lattice points"),
            ("STATIC_4x4", "1 of the 16 lattice points"),
            ("RANDOM_12x12", "2 of the 144 lattice points"),
        )
    ]


def test_a_slot_out_of_reach_is_named() -> None:
    cell = Cell()
    cell.far_slots = {14}
    assert findings(cell) == [("E702", "the arm does not reach slot 14: J1 beyond its limit")]


def test_a_point_out_of_a_cameras_sight_is_named_for_each_environment() -> None:
    cell = Cell()
    cell.hidden = {("CAMERA_TOP", 9, 9)}
    message = "CAMERA_TOP does not see 1 of the 144 lattice points of {}, such as (9, 9)"
    assert findings(cell) == [
        ("E703", message.format("STATIC_12x12")),
        ("E703", message.format("RANDOM_12x12")),
    ]


def test_a_missing_camera_is_named_once() -> None:
    cell = Cell()
    cell.cameras.remove("CAMERA_GRIPPER")
    assert findings(cell) == [("E704", "this cell has no camera for CAMERA_GRIPPER")]


def test_blocks_the_cell_does_not_know_are_named() -> None:
    cell = Cell()
    cell.kinds = ["cube", "cylinder"]
    cell.colours = ["red", "blue", "yellow", "natural"]
    codes = findings(cell)
    assert codes.count(("E705", "this cell has no kind `bridge`")) == 2
    assert codes.count(("E705", "this cell has no colour `green`")) == 4


def demanding(text: str) -> list[tuple[str, str, int]]:
    cell = Cell()
    cell.known_mm = {"lattice": 0.4, "CAMERA_TOP": 3.1}
    found = check_on_site(program(text), cell)
    return [(d.code, d.message, d.span.line) for d in found]


def test_what_is_demanded_and_not_known_is_told_where_it_is_demanded() -> None:
    text = library_script("mash")
    first = text.index("environment STATIC_12x12 {")
    line = text.count("\n", 0, first) + 2
    head = "environment STATIC_12x12 {\n"
    limited = text.replace(head, head + "  accuracy 2 mm\n")
    found = demanding(limited)
    assert ("E706", "CAMERA_TOP has 3.1 mm", line) in found
    # Every environment takes it over from this one.
    assert {code for code, _, _ in found} == {"E706"}
    assert demanding(text) == []


def test_a_goal_demands_it_of_the_views_of_all_its_environments() -> None:
    text = library_script("mash")
    head = "goal ReachRedCube {\n"
    line = text.count("\n", 0, text.index(head)) + 2
    assert demanding(text.replace(head, head + "  accuracy 0.3 mm\n")) == [
        ("E706", "the lattice has 0.4 mm", line),
        ("E706", "CAMERA_TOP has 3.1 mm", line),
    ]
