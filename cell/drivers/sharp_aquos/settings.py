"""What the television's driver must be told."""

from __future__ import annotations

from dataclasses import dataclass, field

from cell.drivers.sharp_aquos.codec import Padding
from cell.drivers.sharp_aquos.tables import HDMI_FIRST, INPUTS_OF_MODEL, InputMap
from cell.profile import DisplayProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class SharpSettings:
    """Settings of a `SharpDisplay`.

    Attributes:
        device: Name of the device in messages.
        inputs: Names of the inputs by number.
        padding: How numbers fill the four characters of a parameter.
        attempts: How often a command is sent before silence counts.
        quiet_s: After a missed answer, the line must be silent this long.
        reply_timeout_s: How long an answer may take.
        power_timeout_s: How long the answer to a power command may take.
        ready_timeout_s: How long after power on until inputs are accepted.
        poll_s: Time between two questions whether the set is ready.
        was_tried_on_hardware: Whether this driver was tried on a device of metal; it says
            so when it opens if not.
    """

    device: str = "display"
    inputs: InputMap = field(default_factory=lambda: HDMI_FIRST)
    padding: Padding = "spaces"
    attempts: int = 3
    quiet_s: float = 0.2
    reply_timeout_s: float = 1.0
    power_timeout_s: float = 3.0
    ready_timeout_s: float = 30.0
    poll_s: float = 0.5
    was_tried_on_hardware: bool = False

    @classmethod
    def from_profile(cls, profile: DisplayProfile, device: str = "display") -> SharpSettings:
        """Return the settings for the television of a profile."""
        return cls(device=device, inputs=INPUTS_OF_MODEL[profile.model])
