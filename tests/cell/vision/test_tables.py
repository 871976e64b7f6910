from __future__ import annotations

import itertools

import pytest

from cell.vision.tables import COLOURS, KINDS, colour_of, fold_deg, kind_of


@pytest.mark.parametrize("entry", KINDS, ids=lambda entry: entry.kind)
def test_both_ends_of_a_kind_s_ranges_belong_to_it(entry: object) -> None:
    kind = next(k for k in KINDS if k is entry)
    for area in (kind.area_px.low, kind.area_px.high):
        for roundness in (kind.circularity.low, kind.circularity.high):
            assert kind_of(area, roundness) is kind
    assert kind_of(kind.area_px.low - 1, kind.circularity.low) is None
    assert kind_of(kind.area_px.high + 1, kind.circularity.high) is None


def test_no_two_colours_share_a_mean() -> None:
    for one, other in itertools.combinations(COLOURS, 2):
        ranges = ((one.red, other.red), (one.green, other.green), (one.blue, other.blue))
        assert any(a.high < b.low or b.high < a.low for a, b in ranges)


@pytest.mark.parametrize("entry", COLOURS, ids=lambda entry: entry.colour)
def test_middle_of_a_colour_s_ranges_is_that_colour(entry: object) -> None:
    colour = next(c for c in COLOURS if c is entry)
    middle = [(r.low + r.high) / 2 for r in (colour.red, colour.green, colour.blue)]
    assert colour_of((middle[0], middle[1], middle[2])) == colour.colour
    assert colour_of((colour.red.high + 1, middle[1], middle[2])) is None


@pytest.mark.parametrize(
    ("angle_deg", "symmetry", "folded"),
    [(50, 90, -40), (-45, 90, -45), (45, 90, -45), (100, 180, -80), (123, 0, 0), (360, 180, 0)],
)
def test_turns_fold_by_the_kind_s_symmetry(
    angle_deg: float, symmetry: float, folded: float
) -> None:
    assert fold_deg(angle_deg, symmetry) == pytest.approx(folded)
