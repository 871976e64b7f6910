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
        self.hidden: set[tuple[str, int, int]] = set()

    def reach(self, x: int, y: int, travel_mm: float) -> str | None:
        return "J2 beyond its limit" if (x, y) in self.far else None

    def reach_slot(self, slot: Slot) -> str | None:
        return "J1 beyond its limit" if slot.number in self.far_slots else None

    def sees(self, view: str, x: int, y: int) -> bool:
        return (view, x, y) not in self.hidden

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
