"""Whole messes, seen by rendered pictures: every block home, none harmed.

`python -m benchmarks cleaning` does two hundred of them.
"""

from __future__ import annotations

import math

import pytest

from benchmarks.cleaning import clean_mess
from benchmarks.messes import store
from cell.profile import load_profile
from cell.store import place_of_slot

STORE = load_profile("mash").store

HARD = (24, 106, 135, 188, 197)
"""Heaps that need a push, or in which blocks touch so that they cannot be told at first."""


@pytest.mark.parametrize("seed", [*HARD, *range(300, 320)])
def test_a_mess_is_cleaned_and_no_block_is_harmed(seed: int) -> None:
    cleaned = clean_mess(seed)
    assert cleaned.not_home == (), f"seed {seed}"
    assert cleaned.harms == (), f"seed {seed}"
    assert cleaned.report.left == (), f"seed {seed}"
    assert cleaned.report.last is not None
    for block in cleaned.report.last.playground.blocks:
        places = [place_of_slot(s, STORE) for s in store().slots_of(block.kind, block.colour)]
        off_mm = [math.hypot(block.body.x_mm - p.x_mm, block.body.y_mm - p.y_mm) for p in places]
        assert min(off_mm) < 10.0, f"seed {seed}: the last look shows {block.name} {block.where}"
    assert len(cleaned.report.home) == cleaned.blocks
