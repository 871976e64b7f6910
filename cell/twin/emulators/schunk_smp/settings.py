"""Figures of an emulated module; what is marked "assumed" was not found for the PG-70."""

from __future__ import annotations

from dataclasses import dataclass, field

from cell.drivers.schunk_smp.tables import Group, UserLevel
from cell.profile import GripperProfile
from cell.twin.emulators.uart import line_byte_s


@dataclass(frozen=True, slots=True, kw_only=True)
class SchunkModuleSettings:
    """Settings of a `SchunkModule`.

    Attributes:
        module_id: Id on the line.
        byte_s: Time one byte takes on the line.
        latency_s: Time from a request's last byte to its answer's first (assumed).
        frame_gap_s: A frame whose rest does not come for so long is given up (assumed).
        boot_s: Time from power on to the boot message (assumed).
        stroke_mm: Upper soft limit.
        max_velocity_mm_s: Fastest move, fingers relative to each other.
        max_acceleration_mm_s2: Steepest ramp.
        max_jerk_mm_s3: Largest jerk (assumed).
        max_current_a: Largest motor current (assumed).
        nominal_current_a: Continuous motor current (assumed).
        running_current_a: Current of an unhindered motion (assumed).
        reference_speed_mm_s: Speed of referencing (assumed).
        reference_settle_s: Time referencing takes beyond its motion (assumed).
        reference_is_blocked: Whether referencing ends with "move blocked" instead of
            "position reached"; both were seen.
        refusal_group: First byte of refusals; sources differ between 0x03 and 0x07.
        error_period_s: Time between repetitions of an error.
        warning_period_s: Time between repetitions of a warning.
        kind: Type in the identity.
        order_number: Order number in the identity (assumed).
        serial_number: Serial number (assumed).
        firmware: Firmware version times 100 (assumed).
        passwords: The level each password gives (assumed).
    """

    module_id: int = 12
    byte_s: float = 12 / 38400
    latency_s: float = 0.002
    frame_gap_s: float = 0.1
    boot_s: float = 0.5
    stroke_mm: float = 70.0
    max_velocity_mm_s: float = 83.0
    max_acceleration_mm_s2: float = 320.0
    max_jerk_mm_s3: float = 10_000.0
    max_current_a: float = 2.0
    nominal_current_a: float = 1.0
    running_current_a: float = 0.2
    reference_speed_mm_s: float = 20.0
    reference_settle_s: float = 1.0
    reference_is_blocked: bool = False
    refusal_group: int = Group.REFUSAL
    error_period_s: float = 15.0
    warning_period_s: float = 30.0
    kind: str = "PG070"
    order_number: int = 306_090
    serial_number: int = 70_012
    firmware: int = 150
    passwords: dict[str, UserLevel] = field(
        default_factory=lambda: {
            "diagnostics": UserLevel.DIAGNOSTICS,
            "profi": UserLevel.PROFI,
            "advanced": UserLevel.ADVANCED,
        }
    )

    @classmethod
    def from_profile(cls, profile: GripperProfile) -> SchunkModuleSettings:
        """Return settings for the gripper of a profile."""
        return cls(
            module_id=profile.module_id,
            stroke_mm=profile.stroke_mm,
            byte_s=line_byte_s(profile.serial),
        )
