"""What the drivers of an SSC-32 need to know about their cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cell.drivers.ssc32.servo_map import ServoMap, servo_map
from cell.errors import ProfileError
from cell.profile.lynx import LynxProfile, ServoProfile

FirstPose = Literal["announced", "confirmed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """One servo on the controller.

    Attributes:
        channel: Its plug, 0 to 31.
        map: Position to pulse width.
        offset_us: Shift that the controller adds to every pulse.
        min_us: Least pulse width that is sent.
        max_us: Greatest pulse width that is sent.
    """

    channel: int
    map: ServoMap
    offset_us: int = 0
    min_us: int = 500
    max_us: int = 2500

    @staticmethod
    def from_profile(profile: ServoProfile) -> Servo:
        """Return the servo that a profile describes."""
        return Servo(
            channel=profile.channel,
            map=servo_map(profile),
            offset_us=profile.offset_us,
            min_us=profile.min_us,
            max_us=profile.max_us,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LineSettings:
    """Patience on the line; the controller answers 50 us to 5 ms after a request.

    Attributes:
        reply_timeout_s: Longest wait for a reply.
        quiet_s: After a reply was missed, the line must be silent this long.
        attempts: How often a question is asked before its silence counts.
    """

    reply_timeout_s: float = 0.25
    quiet_s: float = 0.05
    attempts: int = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Ssc32Settings:
    """Figures of one arm on a servo controller.

    Attributes:
        servos: The servos of the joints, J1 first.
        other_channels: Channels of servos that are not the arm's, such as the fingers'.
        rest_deg: The pose of the first move after power-up.
        first_pose: What `open` does when the pose is unknown; see `Ssc32Arm.open`.
        announce_s: Time between the warning and the first move.
        first_joint_s: Time given to each joint of the first move; a servo at full speed
            turns its whole range in half a second.
        linear_speed_mm_s: Speed of straight moves when the arm opens.
        joint_speed_percent: Share of full speed of joint moves when the arm opens.
        segment_s: Straight moves are cut into joint moves of this time.
        watch_s: How often a move under way is looked at.
        settle_s: Time a servo is given to come to rest after the last pulse.
        margin_s: How much longer than planned a move may take.
        knows_stop: Whether the firmware has STOP (SSC-32U, late SSC-32).
        line: Patience on the line.
        was_tried_on_hardware: Whether this driver was tried on a controller of metal.
    """

    servos: tuple[Servo, ...]
    other_channels: tuple[int, ...] = ()
    rest_deg: tuple[float, ...]
    first_pose: FirstPose = "confirmed"
    announce_s: float = 5.0
    first_joint_s: float = 1.0
    linear_speed_mm_s: float
    joint_speed_percent: float
    segment_s: float = 0.05
    watch_s: float = 0.2
    settle_s: float = 0.1
    margin_s: float = 1.0
    knows_stop: bool = False
    line: LineSettings = LineSettings()
    was_tried_on_hardware: bool = False

    @staticmethod
    def from_profile(profile: LynxProfile) -> Ssc32Settings:
        """Return the settings that an arm's profile asks for.

        Raises:
            ProfileError: A servo's pulses do not reach a joint's limits, or the line is
                too slow for the segments of straight moves.
        """
        servos = tuple(Servo.from_profile(servo) for servo in profile.servos)
        for number, (servo, low, high) in enumerate(
            zip(servos, profile.joint_min_deg, profile.joint_max_deg, strict=True), 1
        ):
            _require_pulses(f"J{number}", servo, low, high, "deg")
        _require_line(profile)
        return Ssc32Settings(
            servos=servos,
            other_channels=(profile.fingers.servo.channel,),
            rest_deg=profile.rest_deg,
            first_pose=profile.first_pose,
            announce_s=profile.announce_s,
            linear_speed_mm_s=profile.linear_speed_mm_s,
            joint_speed_percent=profile.joint_speed_percent,
            segment_s=profile.segment_s,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerSettings:
    """Figures of fingers on a servo.

    Attributes:
        servo: The servo; positions are openings in millimetres.
        min_mm: Least opening that is asked of the servo; negative squeezes.
        max_mm: Greatest opening.
        open_mm: Where the fingers go at their first move after power-up.
        grip_mm: Opening asked of the servo to grip.
        speed_mm_s: Speed of both fingers towards each other.
        poll_s: Pause between two looks at a move.
        margin_s: How much longer than planned a move may take.
        settle_s: Time the servo is given to come to rest after the last pulse.
        first_s: Time given to the first move, which goes at full speed.
        device: Name of the device in messages.
        line: Patience on the line.
        was_tried_on_hardware: Whether this driver was tried on a controller of metal.
    """

    servo: Servo
    min_mm: float
    max_mm: float
    open_mm: float
    grip_mm: float
    speed_mm_s: float
    poll_s: float = 0.05
    margin_s: float = 1.0
    settle_s: float = 0.1
    first_s: float = 1.0
    device: str = "gripper"
    line: LineSettings = LineSettings()
    was_tried_on_hardware: bool = False

    @staticmethod
    def from_profile(profile: LynxProfile) -> FingerSettings:
        """Return the settings that an arm's profile asks for.

        Raises:
            ProfileError: The servo's pulses do not reach an opening.
        """
        fingers = profile.fingers
        servo = Servo.from_profile(fingers.servo)
        _require_pulses("the fingers", servo, fingers.min_mm, fingers.max_mm, "mm")
        for what, opening_mm in (("open_mm", fingers.open_mm), ("grip_mm", fingers.grip_mm)):
            if not fingers.min_mm <= opening_mm <= fingers.max_mm:
                raise ProfileError(
                    f"arm.fingers.{what}: {opening_mm:g} mm is out of range; allowed are "
                    f"{fingers.min_mm:g} to {fingers.max_mm:g} mm"
                )
        return FingerSettings(
            servo=servo,
            min_mm=fingers.min_mm,
            max_mm=fingers.max_mm,
            open_mm=fingers.open_mm,
            grip_mm=fingers.grip_mm,
            speed_mm_s=fingers.speed_mm_s,
        )


def _require_pulses(what: str, servo: Servo, low: float, high: float, unit: str) -> None:
    for position in (low, high):
        pulse = servo.map.pulse_us(position)
        if not servo.min_us - 0.5 <= pulse <= servo.max_us + 0.5:
            raise ProfileError(
                f"{what} on channel {servo.channel}: {position:g} {unit} needs a pulse of "
                f"{pulse:.0f} us, allowed are {servo.min_us} to {servo.max_us} us; "
                "correct centre_us, us_per_unit or the limit"
            )


def _require_line(profile: LynxProfile) -> None:
    """Insist that a segment and a look at the pulses fit into a segment's time."""
    serial = profile.serial
    characters = len("#31P2500S65535") * len(profile.servos) + len("T500\r")
    characters += len("QP31") * len(profile.servos) + len("\r") + len(profile.servos)
    needed_s = characters * 10 / serial.baud + 0.005
    if needed_s > profile.segment_s:
        raise ProfileError(
            f"arm.segment_s: {profile.segment_s:g} s is too short at {serial.baud} baud; "
            f"at least {needed_s:.3f} s are needed (or a faster line)"
        )
