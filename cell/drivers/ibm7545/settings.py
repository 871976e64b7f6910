"""What the driver of an IBM 7545 needs to know about its cell."""

from __future__ import annotations

from dataclasses import dataclass

from cell.profile.ibm7545 import Four, Ibm7545Profile


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaraSettings:
    """Figures of one arm and its servo.

    Attributes:
        joint_speed: Mean speed of each joint in a segment at 100 %: deg/s, deg/s, mm/s, deg/s.
        linear_speed_mm_s: Greatest speed of the tool along a line until another is set.
        joint_speed_percent: Share of the joints' speed until another is set.
        period_us: Sample period of the servo.
        kp: Torque counts for each pulse of error.
        kv: Torque counts for each pulse a second of the error's change.
        segment_extra_s: Added to the time of each segment, for speeding up and slowing down.
        via_s: Time between the points of a line that the servo is led through.
        settled_pulses: How far a joint may stand from its target when a move is over.
        settled_samples: How many samples in a row that must hold.
        settle_timeout_s: Longest wait for it after the path's end.
        wait_ms: Longest wait of the bridge within a sample period's handshake.
        home_timeout_s: Longest wait for the home position.
        poll_s: Pause between two looks at the slave while it works by itself.
        reset_s: Time in which the slave looks at its joints again after a reset.
        gripper_timeout_s: Longest wait for the gripper's valve.
        was_tried_on_hardware: Whether this driver was tried on an arm of metal.
    """

    joint_speed: Four
    linear_speed_mm_s: float
    joint_speed_percent: float
    period_us: int = 1000
    kp: Four = (60.0, 60.0, 55.0, 60.0)
    kv: Four = (0.1, 0.1, 0.1, 0.1)
    segment_extra_s: float = 0.2
    via_s: float = 0.05
    settled_pulses: int = 20
    settled_samples: int = 10
    settle_timeout_s: float = 1.0
    wait_ms: int = 50
    home_timeout_s: float = 180.0
    poll_s: float = 0.1
    reset_s: float = 0.02
    gripper_timeout_s: float = 5.0
    was_tried_on_hardware: bool = False

    @property
    def period_s(self) -> float:
        """Sample period of the servo."""
        return self.period_us / 1e6

    @staticmethod
    def from_profile(profile: Ibm7545Profile) -> ScaraSettings:
        """Return the settings that an arm's profile asks for."""
        return ScaraSettings(
            joint_speed=profile.joint_speed,
            linear_speed_mm_s=profile.linear_speed_mm_s,
            joint_speed_percent=profile.joint_speed_percent,
            period_us=profile.servo.period_us,
            kp=profile.servo.kp,
            kv=profile.servo.kv,
        )
