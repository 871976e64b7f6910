"""The rendered top picture against the reference's recognition tables."""

from __future__ import annotations

import math

import pytest

from cell.geometry import PlaneMap
from cell.twin.scene import SceneBlock
from cell.vision import SeenBlock, find_blocks, locate
from tests.cell.twin.cameras.stage import PROFILE, Stage, block

COLOURS = ("red", "green", "blue", "yellow", "natural")
KINDS = ("cube", "cylinder", "bridge")


def lattice(column: int, row: int) -> tuple[float, float]:
    step = PROFILE.lattice.step_mm
    x_mm, y_mm = PROFILE.lattice.origin_mm
    return x_mm - step * row, y_mm + step * column


def recognise(stage: Stage, *blocks: SceneBlock) -> tuple[SeenBlock, ...]:
    camera = stage.camera("top")
    stage.put(*blocks)
    stage.show("white")
    white = camera.grab().pixels
    stage.show("black")
    black = camera.grab().pixels
    return tuple(seen for seen in find_blocks(white, black) if seen.kind is not None)


def plane_map() -> PlaneMap:
    rows = PROFILE.cameras["top"].plane_map
    assert rows is not None
    return PlaneMap(rows)


def assert_found(laid: list[SceneBlock], found: tuple[SeenBlock, ...]) -> None:
    assert len(found) == len(laid)
    for item in laid:
        seen = min(found, key=lambda s: distance_mm(s, item))
        assert (seen.kind, seen.colour) == (item.kind, item.colour)
        assert distance_mm(seen, item) < 5.0


def distance_mm(seen: SeenBlock, item: SceneBlock) -> float:
    place = locate(seen, plane_map())
    return math.hypot(place.x_mm - item.x_mm, place.y_mm - item.y_mm)


@pytest.mark.parametrize("kind", ["cube", "cylinder"])
@pytest.mark.parametrize("turn", range(5))
def test_small_blocks_of_every_colour_are_known_all_over_the_world(kind: str, turn: int) -> None:
    places = [(c, r) for c in (0, 4, 7, 11) for r in (0, 3, 7, 11)]
    laid = [
        block(kind, COLOURS[(i + turn) % 5], *lattice(*place)) for i, place in enumerate(places)
    ]
    assert_found(laid, recognise(Stage(), *laid))


@pytest.mark.parametrize("turn", range(5))
def test_bridges_of_every_colour_are_known_wherever_the_crop_shows_them_whole(turn: int) -> None:
    places = [(c, r) for c in (0, 4, 7, 11) for r in (2, 9)]
    laid = [
        block("bridge", COLOURS[(i + turn) % 5], *lattice(*place)) for i, place in enumerate(places)
    ]
    assert_found(laid, recognise(Stage(), *laid))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("yaw_deg", [7.0, 22.5, 45.0, -30.0])
def test_turned_blocks_are_known_with_their_turn(kind: str, yaw_deg: float) -> None:
    laid = [
        block(kind, COLOURS[i], *lattice(*place), yaw_deg=yaw_deg)
        for i, place in enumerate(((1, 4), (10, 3), (5, 7), (1, 10), (10, 10)))
    ]
    found = recognise(Stage(), *laid)
    assert_found(laid, found)
    period = {"cube": 90.0, "bridge": 180.0, "cylinder": math.inf}[kind]
    if period < math.inf:
        for seen in found:
            off = (locate(seen, plane_map()).yaw_deg - yaw_deg + period / 2) % period - period / 2
            assert abs(off) < 1.5


def test_bridge_that_the_crop_cuts_off_is_not_guessed_at() -> None:
    assert recognise(Stage(), block("bridge", "red", *lattice(5, 0))) == ()


def test_empty_screen_shows_no_block() -> None:
    assert recognise(Stage()) == ()
