"""A Lynx on its emulator in memory, with every byte that passes."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import cast

from cell.clock import SimulatedClock
from cell.drivers.ssc32.driver import Ssc32Arm
from cell.drivers.ssc32.gripper import Ssc32Gripper
from cell.drivers.ssc32.settings import FingerSettings, Ssc32Settings
from cell.geometry import JointPositions
from cell.kinematics.lynx import LynxArm
from cell.links.base import Direction
from cell.links.capture import CapturedLink
from cell.links.memory import MemoryLink
from cell.profile import CellProfile, LynxProfile, profile_text
from cell.stop import StopToken
from cell.twin.emulators.ssc32 import (
    LynxMechanics,
    Sag,
    ServoBank,
    Ssc32Controller,
    Ssc32ControllerSettings,
)

PROFILE = cast(LynxProfile, CellProfile.model_validate(tomllib.loads(profile_text("lynx"))).arm)
KINEMATICS = LynxArm.from_profile(PROFILE)
SETTINGS = Ssc32Settings.from_profile(PROFILE)
FINGERS = FingerSettings.from_profile(PROFILE)
CONTROLLER_SETTINGS = Ssc32ControllerSettings.from_profile(PROFILE)
CHANNELS = tuple(servo.channel for servo in PROFILE.servos)

ABOVE = JointPositions((10.0, 10.0, 20.0, 60.0, -5.0))
"""Gripper down, in front of the base."""


class LynxRig:
    """Arm, fingers, link, emulator and servos on one simulated clock."""

    def __init__(
        self,
        *,
        settings: Ssc32Settings = SETTINGS,
        controller_settings: Ssc32ControllerSettings = CONTROLLER_SETTINGS,
        seed: int = 1,
        error_scale: float = 1.0,
        sag: Sag | None = None,
    ) -> None:
        self.clock = SimulatedClock()
        self.bank = ServoBank.from_profile(PROFILE, seed=seed, error_scale=error_scale)
        self.emulator = Ssc32Controller(self.bank, controller_settings)
        self.mechanics = LynxMechanics(PROFILE, self.bank, KINEMATICS, sag)
        self.traffic: list[tuple[Direction, bytes]] = []
        self.sent_s: list[float] = []
        self.warnings: list[str] = []
        self.token = StopToken()
        self.link = MemoryLink("arm", self.emulator, self.clock)
        captured = CapturedLink(self.link, self._note)
        self.arm = Ssc32Arm(
            captured,
            self.clock,
            settings,
            KINEMATICS,
            on_warning=self.warnings.append,
            token=self.token,
        )
        self.gripper = Ssc32Gripper(
            captured, self.clock, FINGERS, on_warning=self.warnings.append, token=self.token
        )

    def _note(self, link: str, direction: Direction, data: bytes) -> None:
        self.traffic.append((direction, data))
        if direction == "to_device":
            self.sent_s.append(self.clock.now_s())

    @property
    def requests(self) -> list[str]:
        """Everything that was sent, a command each."""
        return [data.decode("ascii").strip() for way, data in self.traffic if way == "to_device"]

    @property
    def moves(self) -> list[str]:
        """Every move that was sent."""
        return [request for request in self.requests if request.startswith("#")]

    def say(self, data: bytes) -> bytes:
        """Send bytes by hand and return what comes back within a quarter of a second."""
        self.link.write(data)
        return self.link.read(0.25)

    def pulses_us(self) -> tuple[float, ...]:
        """Return the pulse widths that the controller commands now."""
        return tuple(self.emulator.pulse_us(c, self.clock.now_s()) for c in CHANNELS)


def opened_rig(settings: Ssc32Settings = SETTINGS) -> LynxRig:
    """Return a rig whose arm is open and stands in the rest pose."""
    rig = LynxRig(settings=settings)
    rig.arm.open()
    return rig


def confirmed() -> Ssc32Settings:
    """Return settings by which the first pose must be confirmed."""
    return replace(SETTINGS, first_pose="confirmed")
