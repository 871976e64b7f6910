"""Two hundred random messes of up to twelve blocks, cleaned by rendered pictures on the twin.

`python -m benchmarks cleaning`; each mess that is not clean at the end, or in which a block was
harmed, is named on stderr with its seed.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass, replace

from benchmarks.measure import Result
from benchmarks.messes import mess, store
from cell.assembly import assemble_twin
from cell.cleaning.report import PictureCleaning
from cell.clock import SimulatedClock
from cell.profile import load_profile
from cell.twin.harm import Harm

MESSES = 200
_HOME_MM = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Cleaned:
    """What came of one mess.

    Attributes:
        blocks: How many blocks were out.
        not_home: Blocks that are not in a slot of their kind and colour.
        harms: What harmed blocks.
        report: What the cell said.
        computing_s: How long it took to calculate.
        cell_s: How long it took in the cell's own time.
    """

    blocks: int
    not_home: tuple[str, ...]
    harms: tuple[Harm, ...]
    report: PictureCleaning
    computing_s: float
    cell_s: float


def clean_mess(seed: int) -> Cleaned:
    """Make a mess on a fresh twin, have it cleaned by pictures, and compare with the truth."""
    profile, plan = load_profile("mash"), store()
    clock = SimulatedClock()
    cell = assemble_twin(profile, plan, seed=seed, clock=clock)
    try:
        cell.open()
        left = mess(seed, profile, plan)
        for number, place in left.items():
            block = cell.world.blocks.get(f"slot {number}")
            cell.world.blocks.put(
                replace(block, x_mm=place.x_mm, y_mm=place.y_mm, yaw_deg=place.yaw_deg)
            )
        start_s, cell_start_s = time.perf_counter(), clock.now_s()
        report = cell.clean_from_picture()
        took_s, cell_took_s = time.perf_counter() - start_s, clock.now_s() - cell_start_s
        belonging = {slot.block for slot in plan.slots}
        lost = []
        for block in cell.world.whereabouts():
            if block.block not in belonging:
                continue
            places = [
                cell.manipulator.slot_place(s.number)
                for s in plan.slots_of(block.kind, block.colour)
            ]
            if all(math.hypot(block.x_mm - p.x_mm, block.y_mm - p.y_mm) > _HOME_MM for p in places):
                lost.append(f"{block.block} at ({block.x_mm:.0f}, {block.y_mm:.0f})")
        return Cleaned(
            blocks=len(left),
            not_home=tuple(lost),
            harms=cell.world.harms,
            report=report,
            computing_s=took_s,
            cell_s=cell_took_s,
        )
    finally:
        cell.dispose()


def run() -> list[Result]:
    """Clean all messes."""
    done = []
    for seed in range(MESSES):
        cleaned = clean_mess(seed)
        done.append(cleaned)
        if cleaned.not_home or cleaned.harms or cleaned.report.left:
            print(
                f"mess {seed}: not home {cleaned.not_home}, harms {cleaned.harms}, "
                f"said {cleaned.report.left}",
                file=sys.stderr,
                flush=True,
            )
    blocks = sum(one.blocks for one in done)
    home = blocks - sum(len(one.not_home) for one in done)
    computing = sorted(one.computing_s for one in done)
    return [
        Result(
            name=f"blocks home of {blocks} in {MESSES} messes", value=100.0 * home / blocks,
            unit="%", target=100.0, target_is="at least",
        ),
        Result(
            name="blocks harmed", value=float(sum(len(one.harms) for one in done)), unit="",
            target=0.0,
        ),
        Result(
            name="messes with a push", value=float(sum(one.report.pushes > 0 for one in done)),
            unit="",
        ),
        Result(
            name="looks a mess", value=sum(one.report.looks for one in done) / len(done), unit=""
        ),
        Result(name="computing a mess, median", value=computing[len(computing) // 2], unit="s"),
        Result(
            name="the cell's time a block", value=sum(one.cell_s for one in done) / blocks, unit="s"
        ),
    ]  # fmt: skip
