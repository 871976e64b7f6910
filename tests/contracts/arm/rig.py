"""A MELFA arm on its emulator in memory, with an arm body that has no world around it."""

from __future__ import annotations

from dataclasses import replace

from cell.clock import SimulatedClock
from cell.drivers.melfa_r3.driver import MelfaArm
from cell.drivers.melfa_r3.settings import ArmSettings
from cell.geometry import JointPositions, Pose
from cell.kinematics import SixAxisArm
from cell.links.base import Direction
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.profile import load_profile
from cell.twin.bodies import JointPath, JointTuple
from cell.twin.emulators.melfa_r3 import ControllerSettings, MelfaController

PROFILE = load_profile("mash").arm
KINEMATICS = SixAxisArm.from_profile(PROFILE)
ARM_SETTINGS = ArmSettings.from_profile(PROFILE)
CONTROLLER_SETTINGS = ControllerSettings.from_profile(PROFILE)
ABOVE = Pose(510.0, -65.0, 98.0)
"""A pose above the playground, gripper down."""


class FakeBody:
    """The arm's mechanics without anything around them."""

    def __init__(self, joints_deg: JointTuple) -> None:
        self._joints_deg = joints_deg
        self.path: JointPath | None = None
        self.outputs: dict[int, bool] = {}

    def joints_deg(self, now_s: float) -> JointTuple:
        return self._joints_deg if self.path is None else self.path.at(now_s)

    def follow(self, path: JointPath) -> None:
        self.path = path

    def halt(self, now_s: float) -> None:
        self._joints_deg = self.joints_deg(now_s)
        self.path = None

    def is_moving(self, now_s: float) -> bool:
        return self.path is not None and now_s < self.path.end_s

    def set_output(self, bit: int, *, is_on: bool, now_s: float) -> None:
        self.outputs[bit] = is_on


class ArmRig:
    """Driver, link, emulator and body on one simulated clock."""

    def __init__(
        self,
        *,
        joints_deg: JointTuple = PROFILE.rest_deg,
        arm_settings: ArmSettings = ARM_SETTINGS,
        controller_settings: ControllerSettings = CONTROLLER_SETTINGS,
    ) -> None:
        self.clock = SimulatedClock()
        self.body = FakeBody(joints_deg)
        self.controller = MelfaController(self.body, KINEMATICS, controller_settings)
        self.traffic: list[tuple[Direction, bytes]] = []
        self.warnings: list[str] = []
        self.repeats: list[tuple[str, str]] = []
        self.link = MemoryLink("arm", self.controller, self.clock)
        captured = CapturedLink(
            self.link, lambda link, direction, data: self.traffic.append((direction, data))
        )
        self.arm = MelfaArm(
            captured,
            self.clock,
            arm_settings,
            on_warning=self.warnings.append,
            on_repeat=lambda device, problem: self.repeats.append((device, problem)),
        )

    @property
    def requests(self) -> list[str]:
        """Everything the driver has sent, a request each."""
        return [
            data.decode("ascii").removesuffix("\r").removeprefix("1;1;")
            for direction, data in self.traffic
            if direction == "to_device"
        ]

    def say(self, text: str) -> str:
        """Send a request by hand and return the reply's text."""
        self.link.write(f"1;1;{text}\r".encode("latin-1"))
        return self.link.read(2.0).decode("latin-1").removesuffix("\r")

    def tool_pose(self) -> Pose:
        """Return where the tool point really is."""
        return KINEMATICS.forward(JointPositions(self.body.joints_deg(self.clock.now_s())))


def opened_rig(arm_settings: ArmSettings = ARM_SETTINGS) -> ArmRig:
    """Return a rig whose arm is open and stands above the playground."""
    start = KINEMATICS.solve(ABOVE, 7)
    a, b, c, d, e, f = start.values
    rig = ArmRig(joints_deg=(a, b, c, d, e, f), arm_settings=arm_settings)
    rig.arm.open()
    return rig


def slow(percent: int) -> ArmSettings:
    """Return settings with another override."""
    return replace(ARM_SETTINGS, override_percent=percent)
