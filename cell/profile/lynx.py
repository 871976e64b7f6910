"""The small arm of hobby servos of the lynx cell, behind its servo controller."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cell.profile.table import Positive, Table
from cell.profile.wires import SerialProfile

Five = tuple[float, float, float, float, float]
Channel = Annotated[int, Field(ge=0, le=31)]
PulseWidth = Annotated[int, Field(ge=500, le=2500)]


class LynxLengthsProfile(Table):
    """The lengths of the arm."""

    shoulder_mm: Positive = 76.2
    """Height of the shoulder above the base."""
    upper_arm_mm: Positive = 146.05
    forearm_mm: Positive = 187.325
    tool_mm: Positive = 68.0
    """From the wrist to the middle between the fingertips."""


class ServoProfile(Table):
    """One servo: its plug at the controller, and which pulse gives which position."""

    channel: Channel
    centre_us: Positive = 1500.0
    """Pulse width at 0 deg, or at 0 mm for the fingers."""
    us_per_unit: float
    """Pulse width for one degree (one millimetre for the fingers); negative turns the other way."""
    offset_us: Annotated[int, Field(ge=-100, le=100)] = 0
    """Added by the controller to every pulse, to set the horn straight."""
    min_us: PulseWidth = 500
    max_us: PulseWidth = 2500
    map: tuple[tuple[float, float], ...] = ()
    """Measured pairs of position and pulse width; with them the straight line above is not used."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.us_per_unit == 0:
            raise ValueError("us_per_unit is 0: the servo would not move")
        if self.min_us >= self.max_us:
            raise ValueError(f"min_us {self.min_us} is not below max_us {self.max_us}")
        steps = list(zip(self.map, self.map[1:], strict=False))
        ways = {b[1] > a[1] for a, b in steps}
        if (
            len(self.map) == 1
            or len(ways) > 1
            or any(b[0] <= a[0] or a[1] == b[1] for a, b in steps)
        ):
            raise ValueError(
                "map needs two pairs or more, positions rising, pulse widths all rising or "
                "all falling"
            )
        return self


class LynxSagProfile(Table):
    """How far the leaning joints give way to weight, in degrees at full reach."""

    shoulder_deg: float = 0.0
    """Turn of J2 with the forearm level and no weight in the hand."""
    elbow_deg: float = 0.0
    """Turn of J3 at the same."""
    wrist_deg: float = 0.0
    """Turn of J4 with the hand level."""
    hand_share: float = 0.0
    """Moment of the hand about the wrist over that of forearm and hand about the elbow."""


class LynxCorrectionProfile(Table):
    """Where the arm really goes: measured maps of J1 to J5, and sag."""

    maps_deg: tuple[
        tuple[tuple[float, float], ...],
        tuple[tuple[float, float], ...],
        tuple[tuple[float, float], ...],
        tuple[tuple[float, float], ...],
        tuple[tuple[float, float], ...],
    ]
    """Pairs of commanded and reached angle of each joint, both growing."""
    sag: LynxSagProfile = LynxSagProfile()
    """How far the leaning joints give way to weight."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for number, knots in enumerate(self.maps_deg, 1):
            steps = zip(knots, knots[1:], strict=False)
            if len(knots) < 2 or any(b[0] <= a[0] or b[1] <= a[1] for a, b in steps):
                raise ValueError(
                    f"the map of J{number} needs two pairs or more, commanded and reached "
                    "angles both growing"
                )
        return self


class LynxFingersProfile(Table):
    """The fingers on the sixth servo; nothing measures where they are or what they hold."""

    enabled: bool = True
    """Whether the cell has its fingers; without them nothing is gripped."""
    servo: ServoProfile
    min_mm: float = -15.0
    """Least opening asked of the servo; below 0 it squeezes."""
    max_mm: Positive = 30.0
    open_mm: Positive = 30.0
    """Opening with which something is approached and released."""
    grip_mm: float = -5.0
    """Opening asked of the servo to grip; the further below the thing's width, the firmer."""
    speed_mm_s: Positive = 30.0


class LynxProfile(Table):
    """A Lynx (AL5D): five turning joints on an SSC-32; its fingers are a sixth servo."""

    model: Literal["lynx-al5d"]
    enabled: bool = True
    """Whether the cell has its arm; without it the cell does what is left."""
    serial: SerialProfile
    lengths: LynxLengthsProfile = LynxLengthsProfile()
    servos: tuple[ServoProfile, ServoProfile, ServoProfile, ServoProfile, ServoProfile]
    """The servos of J1 to J5."""
    fingers: LynxFingersProfile
    correction: LynxCorrectionProfile | None = None
    """Where the arm really goes when it is told to, if that was measured."""
    joint_min_deg: Five
    joint_max_deg: Five
    joint_speed_deg_s: Five
    linear_speed_mm_s: Positive
    max_linear_speed_mm_s: Positive
    joint_speed_percent: Annotated[float, Field(gt=0, le=100)]
    posture: Annotated[int, Field(ge=0, le=3)] = 0
    """0 is elbow up, 1 elbow down; 2 more is backwards over the shoulder."""
    rest_deg: Five
    """Joint angles where the arm stands aside; its first pose after power-up, too."""
    first_pose: Literal["announced", "confirmed"] = "confirmed"
    """After power-up the arm's pose is unknown and its first move jumps. `announced`: it says so,
    waits `announce_s` and goes to the rest pose; `confirmed`: somebody must have said before
    that the arm was put there by hand."""
    announce_s: Annotated[float, Field(ge=0)] = 5.0
    segment_s: Annotated[float, Field(ge=0.02, le=0.5)] = 0.05
    """Straight moves are cut into joint moves of this time."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        channels = [servo.channel for servo in (*self.servos, self.fingers.servo)]
        if len(set(channels)) < len(channels):
            raise ValueError(f"two servos share a channel: {channels}")
        return self
