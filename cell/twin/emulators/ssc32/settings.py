"""What an emulated servo controller is like: who it is, and how fast it answers."""

from __future__ import annotations

from dataclasses import dataclass

from cell.profile.lynx import LynxProfile
from cell.twin.emulators.uart import line_byte_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Ssc32ControllerSettings:
    """Figures of one emulated controller.

    Attributes:
        version: What VER answers; assumed, never seen.
        knows_stop: Whether the firmware has STOP (SSC-32U, late SSC-32).
        byte_s: Time that a byte is on the wire; 115200 baud, 8N1.
        latency_s: Time from a question's end to its answer's start, 50 us to 5 ms.
        boot_s: Time from power-up to the first command that is heard; assumed.
    """

    version: str = "SSC32-V2.01XE"
    knows_stop: bool = True
    byte_s: float = 10 / 115200
    latency_s: float = 0.001
    boot_s: float = 0.5

    @staticmethod
    def from_profile(profile: LynxProfile) -> Ssc32ControllerSettings:
        """Return the settings of the controller that a profile describes."""
        return Ssc32ControllerSettings(byte_s=line_byte_s(profile.serial))
