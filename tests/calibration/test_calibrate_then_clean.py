"""A cell that is not what its profile says: calibrated by its own arm, then cleaned by sight."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from benchmarks.messes import mess, store
from calibration.applying import calibrated_profile
from calibration.homography.procedure import calibrate_homography
from calibration.record import make_record
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import Profile, load_profile
from cell.store import place_of_slot
from cell.twin_cell import TwinCell
from tests.calibration.hidden_truth import hidden
from tests.calibration.playing import played, site_of, twin_of

WHEN = datetime(2026, 5, 4, 7, 0, tzinfo=UTC)


@pytest.mark.parametrize("seed", [3, 8])
def test_a_calibrated_cell_brings_every_block_of_a_mess_home(seed: int) -> None:
    told = load_profile("mash")
    truth = hidden(told, seed)
    with twin_of(told, truth, seed) as cell:
        measured = played(calibrate_homography(site_of(told)), {}, cell)
    record = make_record(measured, cell="mash", measured_at=WHEN, versions={}, answers={})
    known = calibrated_profile(told, [record])
    assert known.cameras["top"] != told.cameras["top"]

    cell = assemble_twin(known, store(), seed=seed, clock=SimulatedClock(), truth=truth)
    try:
        cell.open()
        out = make_mess(cell, seed, told)
        report = cell.clean_from_picture()
        assert not report.left, f"seed {seed}: {report.left}"
        assert not cell.world.harms, f"seed {seed}: {cell.world.harms}"
        assert len(report.home) == len(out), f"seed {seed}"
        for number in out:
            block = cell.world.blocks.get(f"slot {number}")
            off_mm = min(
                math.hypot(block.x_mm - place.x_mm, block.y_mm - place.y_mm)
                for slot in cell.plan.slots_of(block.kind, block.colour)
                for place in [place_of_slot(slot, told.store)]
            )
            assert off_mm < 10, f"seed {seed}: block {number} is {off_mm:.1f} mm from home"
    finally:
        cell.dispose()


def make_mess(cell: TwinCell, seed: int, profile: Profile) -> list[int]:
    """Lay blocks out as a person would leave them; return the numbers of their slots."""
    left = mess(seed, profile, store())
    for number, place in left.items():
        block = cell.world.blocks.get(f"slot {number}")
        cell.world.blocks.put(
            replace(block, x_mm=place.x_mm, y_mm=place.y_mm, yaw_deg=place.yaw_deg)
        )
    return list(left)
