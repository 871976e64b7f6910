from __future__ import annotations

import math

import pytest

from benchmarks.messes import store
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.profile import load_profile
from cell.store import TablePlace

CUBE, BRIDGE, CYLINDER = 7, 13, 16


@pytest.mark.parametrize("slot", [CUBE, CYLINDER])
def test_a_block_carried_again_and_again_does_not_creep(slot: int) -> None:
    cell = assemble_twin(load_profile("mash"), store(), seed=4, clock=SimulatedClock())
    try:
        cell.open()
        worst = 0.0
        for turn in range(30):
            place = TablePlace(x_mm=500.0 + turn % 3 * 40, y_mm=-100.0 + turn % 2 * 90, yaw_deg=0.0)
            cell.carry(slot, place)
            block = cell.world.blocks.get(f"slot {slot}")
            worst = max(worst, math.hypot(block.x_mm - place.x_mm, block.y_mm - place.y_mm))
        assert worst < 1.7, "a step scatters by 0.3 mm an axis (seed 4)"
    finally:
        cell.dispose()


def test_a_bridge_is_carried_across_its_width_alone() -> None:
    cell = assemble_twin(load_profile("mash"), store(), seed=4, clock=SimulatedClock())
    try:
        cell.open()
        for yaw_deg in (0.0, 30.0):
            cell.carry(BRIDGE, TablePlace(x_mm=500.0, y_mm=0.0, yaw_deg=yaw_deg))
        block = cell.world.blocks.get(f"slot {BRIDGE}")
        assert block.yaw_deg == pytest.approx(30.0, abs=3.0)
    finally:
        cell.dispose()
