"""Whole messes, seen by rendered pictures: every block home, none harmed.

`python -m benchmarks cleaning` does two hundred of them.
"""

from __future__ import annotations

import pytest

from benchmarks.cleaning import clean_mess

HARD = (24, 106, 135, 188, 197)
"""Heaps that need a push, or in which blocks touch so that they cannot be told at first."""


@pytest.mark.parametrize("seed", [*HARD, *range(300, 307)])
def test_a_mess_is_cleaned_and_no_block_is_harmed(seed: int) -> None:
    cleaned = clean_mess(seed)
    assert cleaned.not_home == (), f"seed {seed}"
    assert cleaned.harms == (), f"seed {seed}"
    assert cleaned.report.left == (), f"seed {seed}"
    assert cleaned.report.last is not None
    assert cleaned.report.last.playground.blocks == (), f"seed {seed}: the last look proves it"
    assert len(cleaned.report.home) == cleaned.blocks
