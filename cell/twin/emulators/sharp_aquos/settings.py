"""Figures of an emulated television; the times are assumed."""

from __future__ import annotations

from dataclasses import dataclass, field

from cell.drivers.sharp_aquos.tables import HDMI_FIRST, INPUTS_OF_MODEL, InputMap, Permission
from cell.profile import DisplayProfile
from cell.twin.emulators.uart import line_byte_s


@dataclass(frozen=True, slots=True, kw_only=True)
class SharpTelevisionSettings:
    """Settings of a `SharpTelevision`.

    Attributes:
        byte_s: Time one byte takes on the line.
        answer_s: Time from a command's last byte to its answer.
        power_answer_s: The same for a power command.
        lit_after_s: Time from the power command to a picture.
        ready_after_s: Time from the power command until other commands are taken.
        inputs: Names of the inputs by number.
        first_input: The input shown after the very first power on.
        permission: Whence the set in standby may be switched on.
        identity: Name, model and software, or None for a set that does not tell.
        is_channel_silent: Whether channel up and down are done without an answer.
    """

    byte_s: float = 11 / 9600
    answer_s: float = 0.05
    power_answer_s: float = 0.5
    lit_after_s: float = 4.0
    ready_after_s: float = 10.0
    inputs: InputMap = field(default_factory=lambda: HDMI_FIRST)
    first_input: int = 1
    permission: Permission = Permission.SERIAL
    identity: tuple[str, str, str] | None = None
    is_channel_silent: bool = True

    @classmethod
    def from_profile(cls, profile: DisplayProfile) -> SharpTelevisionSettings:
        """Return settings for the television of a profile."""
        return cls(
            inputs=INPUTS_OF_MODEL[profile.model],
            byte_s=line_byte_s(profile.serial),
        )
