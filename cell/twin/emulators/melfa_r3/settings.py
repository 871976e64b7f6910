"""What an emulated controller is like: who it is, its limits, speeds and delays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cell.drivers.melfa_r3.records import Identity
from cell.profile import MelfaProfile
from cell.twin.bodies import JointTuple
from cell.twin.emulators.uart import line_byte_s


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerSettings:
    """Figures of one emulated controller.

    Attributes:
        robot: The robot number it listens to, besides 0 and 1 for all.
        identity: What it answers to OPEN.
        joint_min_deg: Lower joint limits (parameter MEJAR).
        joint_max_deg: Upper joint limits (parameter MEJAR).
        joint_speed_deg_s: Largest joint speeds.
        flange_min_z_mm: Lowest height of the flange (parameter MEPAR).
        tool_mm: Tool point in the flange frame (parameter MEXTL); the kinematics has the same.
        tools: Offsets of the tools that M_TOOL selects, by number.
        safe_deg: Where MOVSP goes (parameter JSAFE).
        max_linear_speed_mm_s: Largest speed that SPD takes.
        max_turn_speed_deg_s: Largest turn of the tool in a straight move.
        acceleration_mm_s2: Acceleration and braking of straight moves at ACCEL 100,100.
        ramp_s: Time in which a joint or a turn comes to full speed at ACCEL 100,100.
        byte_s: Time that a byte is on the wire; 12 bits at 38400 baud (8E2) by default.
        processing_s: Time from a request's end to its reply's start.
        servo_on_s: Time from SRVON to the servo bit.
        boot_s: Time from a restart to the first reply (assumed).
        override_percent: Override at power-up.
        edit_slot: The slot whose direct statements need no program.
        programs: Programs in the controller's memory, name to lines.
    """

    robot: int = 1
    identity: Identity = Identity(
        axis_mask=0x3F,
        joint_mask=0x3F,
        flags=(7, 0),
        jog_speeds=(3, 5, 10, 30, 50, 70, 100),
        program_extension="MB5",
        parameter_extension="PRM",
        robot="RV-6SDL",
        controller="CRnD-7xx",
        maker="MELFA",
        date="10-06-17",
        version="Ver.P8a",
        language="ENG",
        copyright="COPYRIGHT(C)2010 EMULATED",
        tail=("1", "3", "8"),
    )
    joint_min_deg: JointTuple
    joint_max_deg: JointTuple
    joint_speed_deg_s: JointTuple
    flange_min_z_mm: float
    tool_mm: tuple[float, float, float]
    tools: Mapping[int, tuple[float, float, float]]
    safe_deg: JointTuple
    max_linear_speed_mm_s: float = 8500.0
    max_turn_speed_deg_s: float = 360.0
    acceleration_mm_s2: float = 3000.0
    ramp_s: float = 0.2
    byte_s: float = 12 / 38400
    processing_s: float = 0.005
    servo_on_s: float = 1.0
    boot_s: float = 20.0
    override_percent: int = 10
    edit_slot: int = 9
    programs: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: {"1": ()})

    @staticmethod
    def from_profile(profile: MelfaProfile) -> ControllerSettings:
        """Return the settings of the controller that a profile describes."""
        return ControllerSettings(
            robot=profile.robot,
            joint_min_deg=profile.joint_min_deg,
            joint_max_deg=profile.joint_max_deg,
            joint_speed_deg_s=profile.joint_speed_deg_s,
            flange_min_z_mm=profile.flange_min_z_mm,
            tool_mm=profile.tool_mm,
            tools={1: profile.tool_mm},
            safe_deg=profile.rest_deg,
            byte_s=line_byte_s(profile.serial),
        )
