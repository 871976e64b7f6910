"""The MELFA arm under the arm contract."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from cell.assembly.wires import TcpFraming, framed
from cell.clock import Clock
from cell.devices.arm import Arm
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.geometry import JointPositions, Pose
from cell.links.base import Emulator, Link
from cell.twin.emulators.melfa_r3.ethernet import EthernetPort
from tests.contracts.arm.case import ArmCase, Place
from tests.contracts.arm.rig import ABOVE, ARM_SETTINGS, KINEMATICS, PROFILE, ArmRig
from tests.contracts.harness import Kind


class MelfaRig(ArmRig):
    """The rig whose emulator the harness puts behind a wire of its own.

    Args:
        is_on_network: Whether the controller is reached at its network port.
    """

    def __init__(self, *, is_on_network: bool = False) -> None:
        super().__init__()
        self.emulator: Emulator = self.controller
        if is_on_network:
            self.emulator = EthernetPort(self.controller)


def _driver(link: Link, clock: Clock) -> Arm:
    return MelfaArm(link, clock, ARM_SETTINGS, on_warning=lambda text: None)


def _place(pose: Pose) -> Place:
    return Place(pose=pose, joints=KINEMATICS.solve(pose, 7))


MELFA = ArmCase(
    kind=Kind("arm", PROFILE.serial, MelfaRig, _driver),
    identity="RV-6SDL",
    start=JointPositions(PROFILE.rest_deg),
    above=_place(ABOVE),
    beside=_place(Pose(490.0, -65.0, 98.0)),
    interpolation="linear",
    posture=7,
    out_of_reach=Pose(1500.0, 0.0, 98.0),
    beyond_limits=JointPositions((171.0, 0.0, 90.0, 0.0, 90.0, 0.0)),
    refusal="out of range",
    output=8,
    press_stop=lambda rig: rig.controller.press_emergency_stop(rig.clock.now_s()),
    release_stop=lambda rig: rig.controller.release_emergency_stop(rig.clock.now_s()),
    teach=lambda rig: rig.controller.set_key_switch(rig.clock.now_s(), is_automatic=False),
    silence=lambda rig: rig.controller.fall_silent(is_silent=True),
)


def _on_network(framing: TcpFraming) -> ArmCase[MelfaRig]:
    def driver(link: Link, clock: Clock) -> Arm:
        return _driver(framed(link, framing, clock), clock)

    rig = partial(MelfaRig, is_on_network=True)
    return replace(MELFA, kind=Kind("arm", PROFILE.serial, rig, driver, is_on_network=True))


MELFA_TEXT, MELFA_HC = _on_network("text"), _on_network("hc")
