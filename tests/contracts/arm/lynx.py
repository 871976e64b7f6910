"""The Lynx under the arm contract.

Its controller has no emergency stop, no alarms and no key switch, and cannot tell its
outputs or whether a set speed was heard; test_lynx_says_what_it_lacks.py holds it to saying
so. Positions are commanded ones in whole microseconds of pulse, a tenth of a degree each.
"""

from __future__ import annotations

from cell.clock import Clock, SimulatedClock
from cell.devices.arm import Arm
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.geometry import JointPositions, Pose
from cell.links.base import Link
from cell.twin.emulators.ssc32 import ServoBank, Ssc32Controller
from tests.cell.drivers.ssc32.bench import (
    ABOVE,
    CONTROLLER_SETTINGS,
    KINEMATICS,
    PROFILE,
    SETTINGS,
)
from tests.contracts.arm.case import ArmCase, Place
from tests.contracts.harness import Kind

_WITHIN_DEG = 0.06
"""Half a microsecond of pulse."""
_WITHIN_MM = 0.8
"""That of all joints at full reach."""


class SteppedLynx:
    """Controller and servos, freshly powered, the limp arm put into its rest pose."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.emulator = Ssc32Controller(
            ServoBank.from_profile(PROFILE, seed=1), CONTROLLER_SETTINGS
        )


def _driver(link: Link, clock: Clock) -> Arm:
    return Ssc32Arm(link, clock, SETTINGS, KINEMATICS, on_warning=lambda text: None)


def _place(pose: Pose) -> Place:
    return Place(
        pose=pose,
        joints=KINEMATICS.solve(pose, PROFILE.posture),
        within_mm=_WITHIN_MM,
        within=_WITHIN_DEG,
    )


_HERE = KINEMATICS.forward(ABOVE)

LYNX = ArmCase(
    kind=Kind("arm", PROFILE.serial, SteppedLynx, _driver),
    identity="SSC32",
    start=JointPositions(PROFILE.rest_deg),
    above=_place(_HERE),
    beside=_place(Pose(_HERE.x_mm - 30.0, _HERE.y_mm + 40.0, _HERE.z_mm, 180.0, 0.0, _HERE.c_deg)),
    interpolation="linear",
    posture=PROFILE.posture,
    out_of_reach=Pose(900.0, 0.0, 98.0),
    beyond_limits=JointPositions((81.0, 0.0, 0.0, 0.0, 0.0)),
    refusal="out of range",
    is_speed_sent=False,
    silence=lambda rig: rig.emulator.fall_silent(is_silent=True),
)
