"""What the gripper's driver must be told: figures of the cell and patience."""

from __future__ import annotations

from dataclasses import dataclass

from cell.profile import GripperProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class SchunkSettings:
    """Settings of a `SchunkGripper`.

    Attributes:
        device: Name of the device in messages.
        module_id: Id of the module on the line.
        stroke_mm: Largest opening between the fingers.
        speed_mm_s: Speed of moves, of one finger relative to the other.
        acceleration_mm_s2: Acceleration of moves.
        closing_sign: Sign of the motor current that closes the fingers (assumed
            negative for the PG-70, as it is on the EVG 55).
        attempts: How often a request that may be repeated is sent before its silence counts.
        reply_timeout_s: How long one answer may take.
        boot_timeout_s: How long a module just switched on may stay silent.
        reference_timeout_s: How long referencing may take.
        margin_s: How much longer than announced a motion may take before the
            state is asked for.
        grip_timeout_s: How long closing the fingers may take.
        poll_s: Time between two questions for the state.
        tolerance_mm: How far from its target a position counts as reached.
        empty_below_mm: Fingers that stand still below this opening hold nothing.
        was_tried_on_hardware: Whether this driver was tried on a device of metal; it says
            so when it opens if not.
    """

    device: str = "gripper"
    module_id: int = 12
    stroke_mm: float = 70.0
    speed_mm_s: float = 60.0
    acceleration_mm_s2: float = 200.0
    closing_sign: float = -1.0
    attempts: int = 3
    reply_timeout_s: float = 0.5
    boot_timeout_s: float = 5.0
    reference_timeout_s: float = 30.0
    margin_s: float = 0.5
    grip_timeout_s: float = 20.0
    poll_s: float = 0.1
    tolerance_mm: float = 0.5
    empty_below_mm: float = 1.0
    was_tried_on_hardware: bool = False

    @classmethod
    def from_profile(cls, profile: GripperProfile, device: str = "gripper") -> SchunkSettings:
        """Return the settings for the gripper of a profile."""
        return cls(
            device=device,
            module_id=profile.module_id,
            stroke_mm=profile.stroke_mm,
            speed_mm_s=profile.speed_mm_s,
            acceleration_mm_s2=profile.acceleration_mm_s2,
        )
