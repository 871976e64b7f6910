"""What a driver costs: exchanges of status in memory on a simulated clock, emulator included.

The target is for STATE, the controller's full state, asked and read through the arm's panel:
encoding the request, the line, the emulated controller, decoding the reply. `read_state` of
the driver asks two questions.
"""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.measure import Result, median_s
from cell.assembly import assemble_twin
from cell.clock import SimulatedClock
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.links.base import Link
from cell.links.memory import MemoryLink
from cell.profile import load_profile
from cell.store import StorePlan
from cell.twin_cell import TwinCell

EXCHANGES = 2000
REPEAT = 15


def run() -> list[Result]:
    profile = load_profile("mash")
    clock = SimulatedClock()
    cell = assemble_twin(profile, StorePlan(()), seed=1, clock=clock)
    try:
        return _measure(cell, clock)
    finally:
        cell.dispose()


def _measure(cell: TwinCell, clock: SimulatedClock) -> list[Result]:
    link = MemoryLink("arm", cell.behind.wires["arm"], clock)
    arm = MelfaArm(
        link, clock, ArmSettings.from_profile(cell.profile.arm), on_warning=lambda text: None
    )
    arm.open()
    bare_us = _us(lambda: _bare(link))
    rows = (
        ("STATE, asked and read by the panel", lambda: arm.panel.state(), 40.0),
        ("read_state of the driver", lambda: arm.read_state(), None),
        ("read_pose of the driver", lambda: arm.read_pose(), None),
    )
    return [
        Result(
            name=name,
            value=_us(work),
            unit="us",
            peer="link and emulator alone, STATE",
            peer_value=bare_us,
            target=target,
        )
        for name, work, target in rows
    ]


def _bare(link: Link) -> bytes:
    link.write(b"1;1;STATE\r")
    return link.read(1.0)


def _us(work: Callable[[], object]) -> float:
    return median_s(work, repeat=REPEAT, number=EXCHANGES) * 1e6
