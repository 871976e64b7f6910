"""What the Lynx's driver and kinematics cost, with its emulator in memory."""

from __future__ import annotations

from typing import cast

from benchmarks.measure import Result, median_s
from cell.clock import SimulatedClock
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.drivers.ssc32.line import straight_line
from cell.drivers.ssc32.settings import Ssc32Settings
from cell.geometry import JointPositions, Pose
from cell.kinematics.lynx import LynxArm
from cell.links.memory import MemoryLink
from cell.profile import LynxProfile, load_cell_profile
from cell.twin.emulators.ssc32 import ServoBank, Ssc32Controller

SEED = 1
CALLS = 2000
_LINE_MM = 4.0


def run() -> list[Result]:
    """Measure one exchange, the state of two, the inverse, and the planning of a line."""
    profile = cast(LynxProfile, load_cell_profile("lynx").arm)
    kinematics = LynxArm.from_profile(profile)
    clock = SimulatedClock()
    link = MemoryLink("arm", Ssc32Controller(ServoBank.from_profile(profile, seed=SEED)), clock)
    arm = Ssc32Arm(
        link, clock, Ssc32Settings.from_profile(profile), kinematics, on_warning=lambda text: None
    )
    arm.open()
    start = JointPositions((10.0, 10.0, 20.0, 60.0, -5.0))
    here = kinematics.forward(start)
    there = Pose(here.x_mm - 50.0, here.y_mm + 90.0, here.z_mm, 180.0, 0.0, here.c_deg)

    def plan() -> int:
        return len(straight_line(kinematics, start, there, 0, step_mm=_LINE_MM, step_deg=2.0))

    return [
        Result(
            name="one exchange (Q)",
            value=1e6 * median_s(arm.panel.is_moving, number=CALLS),
            unit="us",
            target=40.0,
        ),
        Result(
            name="the arm's state (two exchanges)",
            value=1e6 * median_s(arm.read_state, number=CALLS),
            unit="us",
            target=80.0,
        ),
        Result(
            name="inverse kinematics",
            value=1e6 * median_s(lambda: kinematics.solve(here, 0), number=CALLS),
            unit="us",
        ),
        Result(
            name="a line planned, each stance",
            value=1e6 * median_s(plan, number=20) / plan(),
            unit="us",
        ),
    ]
