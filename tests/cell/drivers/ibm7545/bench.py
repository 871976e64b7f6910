"""The avrs cell's arm on its emulator in memory, on one simulated clock."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from importlib import resources

from cell.clock import SimulatedClock
from cell.drivers.ibm7545.bus import BridgedBus
from cell.drivers.ibm7545.driver import Ibm7545Arm
from cell.drivers.ibm7545.settings import ScaraSettings
from cell.geometry import JointPositions
from cell.kinematics.scara import ScaraArm
from cell.links.memory import MemoryLink
from cell.profile import CellProfile
from cell.profile.ibm7545 import Ibm7545Profile
from cell.stop import StopToken
from cell.twin.emulators.ibm7545 import RegisterBridge, Slave, SlaveSettings
from cell.twin.wire_faults import FaultyEmulator

CELL = CellProfile.model_validate(
    tomllib.loads((resources.files("cell") / "profiles" / "avrs.toml").read_text("utf-8"))
)
if not isinstance(CELL.arm, Ibm7545Profile):
    raise TypeError("the avrs cell has another arm")
PROFILE = CELL.arm
KINEMATICS = ScaraArm.from_profile(PROFILE)
SETTINGS = ScaraSettings.from_profile(PROFILE)
SLAVE_SETTINGS = SlaveSettings.from_profile(PROFILE)


class Bench:
    """Driver, bus, link, bridge and slave."""

    def __init__(
        self,
        *,
        settings: ScaraSettings = SETTINGS,
        slave_settings: SlaveSettings = SLAVE_SETTINGS,
    ) -> None:
        self.clock = SimulatedClock()
        self.slave = Slave(slave_settings)
        self.bridge = RegisterBridge(self.slave, slave_settings)
        self.wire = FaultyEmulator(self.bridge)
        self.bus = BridgedBus(MemoryLink("arm", self.wire, self.clock), self.clock)
        self.token = StopToken()
        self.warnings: list[str] = []
        self.arm = Ibm7545Arm(
            self.bus,
            KINEMATICS,
            self.clock,
            settings,
            token=self.token,
            on_warning=self.warnings.append,
        )

    @property
    def torques(self) -> tuple[float, ...]:
        """What the motors get, in counts from the middle."""
        return tuple(self.slave.mechanics._torques)


def opened(
    *, settings: ScaraSettings = SETTINGS, slave_settings: SlaveSettings = SLAVE_SETTINGS
) -> Bench:
    """Return a bench whose arm is open and stands at home."""
    bench = Bench(settings=settings, slave_settings=replace(slave_settings, start=(0, 0, 0, 0)))
    bench.arm.open()
    return bench


def joints(*values: float) -> JointPositions:
    return JointPositions(values)
