"""What lies where on the sheet: nothing on a block, and every plan its own markers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cell.sheet import SheetError, lay_out
from cell.sheet.fiducials import MODULES, index_of, marker_id
from cell.sheet.layout import label_area
from cell.sheet.room import Area
from cell.sheet.store_sheet import kind_letters
from cell.store import StoreSlot
from tests.cell.sheet.bench import MASH_SLOTS, PROFILE

LAYOUT = lay_out(MASH_SLOTS, PROFILE.blocks)


def meet(first: Area, second: Area) -> bool:
    return (
        first.x_mm < second.x_mm + second.width_mm
        and second.x_mm < first.x_mm + first.width_mm
        and first.y_mm < second.y_mm + second.height_mm
        and second.y_mm < first.y_mm + first.height_mm
    )


def random_slots(seed: int) -> tuple[StoreSlot, ...]:
    """Return slots on a wide lattice, some left out."""
    random = np.random.default_rng(seed)
    places = [(60.0 + 110 * i, 60.0 + 100 * j) for i in range(5) for j in range(3)]
    kept = [place for place in places if random.random() < 0.7] or places[:1]
    kinds, colours = ("cube", "cylinder", "bridge"), ("red", "green", "blue", "yellow", "natural")
    return tuple(
        StoreSlot(
            number=index + 1,
            kind=str(random.choice(kinds)),
            colour=str(random.choice(colours)),
            x_mm=x,
            y_mm=y,
        )
        for index, (x, y) in enumerate(kept)
    )


def test_the_mash_sheet_ends_before_the_screen_and_has_twelve_markers() -> None:
    assert (LAYOUT.width_mm, LAYOUT.height_mm) == (547, 368)
    assert len(LAYOUT.fiducials) == 12
    assert LAYOUT.missing == ()


def test_the_calibration_cylinder_has_its_slot_and_makes_another_print() -> None:
    assert LAYOUT.slots[-1].label == "19 cylinder natural"
    without = lay_out(MASH_SLOTS[:-1], PROFILE.blocks)
    assert (without.width_mm, without.height_mm) == (LAYOUT.width_mm, LAYOUT.height_mm)
    assert without.identity != LAYOUT.identity
    assert without.missing == ()


@pytest.mark.parametrize("seed", range(12))
def test_markers_keep_their_quiet_zone_free_of_slots_labels_and_each_other(seed: int) -> None:
    layout = lay_out(random_slots(seed), PROFILE.blocks)
    areas = []
    for one in layout.fiducials:
        side = one.size_mm * (1 + 2 / MODULES)
        areas.append(
            Area(x_mm=one.x_mm - side / 2, y_mm=one.y_mm - side / 2, width_mm=side, height_mm=side)
        )
    taken = [one.outline for one in layout.slots] + [label_area(one) for one in layout.slots]
    taken += [one for one in (layout.title, layout.ruler_x, layout.ruler_y) if one is not None]
    for index, area in enumerate(areas):
        assert area.x_mm >= 0, f"seed {seed}"
        assert area.x_mm + area.width_mm <= layout.width_mm, f"seed {seed}"
        assert 0 <= area.y_mm <= layout.height_mm - area.height_mm, f"seed {seed}"
        for other in taken + areas[:index]:
            assert not meet(area, other), f"seed {seed}: marker {index}"
    assert len(layout.fiducials) >= 4, f"seed {seed}"


def test_every_marker_says_which_it_is() -> None:
    for one in LAYOUT.fiducials:
        assert index_of(one.marker_id) == one.index
        assert marker_id(LAYOUT.identity, one.index) == one.marker_id
    assert index_of(99) is None
    assert index_of(1000) is None


@pytest.mark.parametrize(
    "change", [{"x_mm": 56.0}, {"colour": "red"}, {"kind": "cylinder"}, {"number": 20}]
)
def test_any_change_of_a_slot_gives_another_print(change: dict[str, object]) -> None:
    changed = (replace(MASH_SLOTS[0], **change), *MASH_SLOTS[1:])  # type: ignore[arg-type]
    other = lay_out(changed, PROFILE.blocks)
    assert other.identity != LAYOUT.identity
    own = {one.marker_id for one in LAYOUT.fiducials}
    shared = own & {one.marker_id for one in other.fiducials}
    assert len(shared) <= 2


def test_the_order_of_the_slots_does_not_matter() -> None:
    assert lay_out(MASH_SLOTS[::-1], PROFILE.blocks).identity == LAYOUT.identity


def test_a_kind_without_a_size_is_refused_by_name() -> None:
    odd = replace(MASH_SLOTS[0], kind="cone")
    with pytest.raises(SheetError, match="slot 1 is for a cone"):
        lay_out((odd,), PROFILE.blocks)


def test_a_plan_without_room_says_what_is_missing() -> None:
    packed = tuple(
        StoreSlot(
            number=i * 8 + j, kind="cube", colour="red", x_mm=18.0 + 36 * i, y_mm=24 + 40.0 * j
        )
        for i in range(12)
        for j in range(8)
    )  # fmt: skip
    missing = " ".join(lay_out(packed, PROFILE.blocks).missing)
    assert "title" in missing
    assert "markers" in missing


@pytest.mark.parametrize("x_mm", [10.0, -400.0, 5000.0, 1e9])
def test_a_slot_over_the_edge_is_told(x_mm: float) -> None:
    over = replace(MASH_SLOTS[0], x_mm=x_mm)
    layout = lay_out((over,), PROFILE.blocks)
    assert f"slot 1 at ({x_mm:g}, 50) lies over" in layout.missing[0]
    assert layout.width_mm <= 2000


def test_kinds_that_begin_alike_have_different_letters() -> None:
    assert kind_letters(["cube", "cylinder", "bridge"]) == {
        "cube": "Cu", "cylinder": "Cy", "bridge": "B",
    }  # fmt: skip
