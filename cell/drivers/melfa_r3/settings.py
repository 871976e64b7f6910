"""What the driver of a MELFA controller needs to know about its cell."""

from __future__ import annotations

from dataclasses import dataclass

from cell.profile import MelfaProfile


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmSettings:
    """Figures of one arm controller.

    Attributes:
        robot: Robot number in every request, 1 to 3.
        slot: Task slot in every request, 1 to 32.
        client: Name told to the controller when a session opens.
        program: An empty program; direct statements need one selected in the slot.
        override_percent: Override put in force when the arm opens.
        linear_speed_mm_s: Speed of straight moves when the arm opens.
        joint_speed_percent: Share of full speed of joint moves when the arm opens.
        reply_timeout_s: Longest wait for a reply.
        attempts: How often a request that may be repeated is sent before it counts as failed.
        link_pause_s: Pause before a request is sent again over a link that broke; each
            further one is twice as long.
        quiet_s: After a reply was missed, the line must be silent this long.
        control_tries: How often the operation right is asked for.
        control_pause_s: Pause between two such requests.
        servo_timeout_s: Longest wait for the servos.
        servo_poll_s: Pause between two looks at the servos.
        busy_timeout_s: How long a refusal for a move under way is met with a repeat.
        move_timeout_s: Longest wait for the end of a move, beyond its expected time.
        ramp_s: What speeding up and slowing down may add to the time a caller expects.
        poll_s: Pause between two looks at a move.
        arrival_mm: How far from its target a move may end.
        arrival_deg: How far from its target a joint may end.
        was_tried_on_hardware: Whether this driver was tried on a controller of metal.
    """

    robot: int = 1
    slot: int = 1
    client: str = "ROBOCELL"
    program: str = "1"
    override_percent: int = 100
    linear_speed_mm_s: float
    joint_speed_percent: float
    reply_timeout_s: float = 2.0
    attempts: int = 3
    link_pause_s: float = 0.25
    quiet_s: float = 0.1
    control_tries: int = 5
    control_pause_s: float = 0.05
    servo_timeout_s: float = 10.0
    servo_poll_s: float = 0.1
    busy_timeout_s: float = 2.0
    move_timeout_s: float = 30.0
    ramp_s: float = 0.1
    poll_s: float = 0.05
    arrival_mm: float = 0.5
    arrival_deg: float = 0.1
    was_tried_on_hardware: bool = False

    @staticmethod
    def from_profile(profile: MelfaProfile) -> ArmSettings:
        """Return the settings that an arm's profile asks for."""
        return ArmSettings(
            robot=profile.robot,
            slot=profile.slot,
            linear_speed_mm_s=profile.linear_speed_mm_s,
            joint_speed_percent=profile.joint_speed_percent,
        )
