"""The IBM 7545 under the arm contract."""

from __future__ import annotations

from cell.clock import Clock, SimulatedClock
from cell.devices.arm import Arm
from cell.drivers.ibm7545.bus import BridgedBus
from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.ibm7545.outputs import HALOGEN
from cell.geometry import JointPositions, Pose
from cell.links.base import Link
from cell.twin.emulators.ibm7545 import RegisterBridge, Slave
from tests.cell.drivers.ibm7545.bench import KINEMATICS, PROFILE, SETTINGS, SLAVE_SETTINGS
from tests.contracts.arm.case import ArmCase, Place
from tests.contracts.harness import Kind

_NEAR = 0.05


class ScaraRig:
    """The slave behind its bridge, on a clock of its own."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.emulator = RegisterBridge(Slave(SLAVE_SETTINGS), SLAVE_SETTINGS)


def _driver(link: Link, clock: Clock) -> Arm:
    bus = BridgedBus(link, clock)
    return Ibm7545Arm(bus, KINEMATICS, clock, SETTINGS, on_warning=lambda text: None)


def _place(values: tuple[float, float, float, float]) -> Place:
    joints = JointPositions(values)
    return Place(pose=KINEMATICS.forward(joints), joints=joints, within_mm=_NEAR, within=_NEAR)


IBM7545 = ArmCase(
    kind=Kind("arm", PROFILE.serial, ScaraRig, _driver),
    identity="IBM 7545",
    start=JointPositions((0.0, 0.0, 0.0, 0.0)),
    above=_place((20.0, 30.0, -50.0, -10.0)),
    beside=_place((25.0, 25.0, -60.0, -10.0)),
    interpolation="linear",
    posture=0,
    out_of_reach=Pose(700.0, 0.0, -50.0, 180.0, 0.0, 0.0),
    beyond_limits=JointPositions((20.0, 136.0, 0.0, 0.0)),
    refusal="out of range",
    output=HALOGEN,
    press_stop=lambda rig: rig.emulator.press_emergency_stop(rig.clock.now_s()),
    release_stop=lambda rig: rig.emulator.release_emergency_stop(rig.clock.now_s()),
    silence=lambda rig: rig.emulator.fall_silent(is_silent=True),
)
