"""The protocol's numbers: commands, status bits, codes, registers, unit systems.

What is marked "assumed" was not seen in two sources and was not tried on
hardware; it is kept here, and not in the logic, for that reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Literal


class Group(IntEnum):
    """First byte of a frame."""

    REFUSAL = 0x03
    BROADCAST = 0x04  # assumed
    MASTER = 0x05
    MODULE = 0x07


class Command(IntEnum):
    """Command byte of a frame."""

    GET_CONFIG = 0x80
    SET_CONFIG = 0x81
    ERROR = 0x88
    WARNING = 0x89
    INFO = 0x8A
    ACKNOWLEDGE = 0x8B
    EMERGENCY_STOP = 0x90
    STOP = 0x91
    REFERENCE = 0x92
    MOVE_BLOCKED = 0x93
    POSITION_REACHED = 0x94
    GET_STATE = 0x95
    GET_DETAILED_ERROR = 0x96
    SET_TARGET_VELOCITY = 0xA0
    SET_TARGET_ACCELERATION = 0xA1
    SET_TARGET_JERK = 0xA2
    SET_TARGET_CURRENT = 0xA3
    SET_TARGET_TIME = 0xA4
    MOVE_POSITION = 0xB0
    MOVE_POSITION_TIME = 0xB1
    MOVE_CURRENT = 0xB3
    MOVE_VELOCITY = 0xB5
    MOVE_GRIP = 0xB7
    MOVE_POSITION_RELATIVE = 0xB8
    MOVE_POSITION_TIME_RELATIVE = 0xB9
    REBOOT = 0xE0
    CHANGE_USER = 0xE3
    SEND_TEST_VALUES = 0xE4
    CHECK_TEST_VALUES = 0xE5
    TOGGLE_IMPULSES = 0xE7


TARGETS = (
    Command.SET_TARGET_VELOCITY,
    Command.SET_TARGET_ACCELERATION,
    Command.SET_TARGET_JERK,
    Command.SET_TARGET_CURRENT,
    Command.SET_TARGET_TIME,
)
"""The commands that set a target."""


class StateMode(IntFlag):
    """What a state reply holds."""

    POSITION = 0x01
    VELOCITY = 0x02
    CURRENT = 0x04
    ALL = 0x07


class Status(IntFlag):
    """Bits of the status byte."""

    REFERENCED = 0x01
    MOVING = 0x02
    PROGRAM_MODE = 0x04
    WARNING = 0x08
    ERROR = 0x10
    BRAKE = 0x20
    MOVE_END = 0x40
    POSITION_REACHED = 0x80


class Code(IntEnum):
    """Codes of refusals, errors, warnings and infos."""

    NONE = 0x00
    BOOT = 0x01
    NO_FREE_SPACE = 0x02
    NO_RIGHTS = 0x03
    UNKNOWN_COMMAND = 0x04
    FAILED = 0x05
    NOT_REFERENCED = 0x06
    SEARCH_SINE_VECTOR = 0x07
    NO_ERROR = 0x08
    COMMUNICATION = 0x09
    TIMEOUT = 0x10
    WRONG_BAUD = 0x16
    CHECKSUM = 0x19
    MESSAGE_LENGTH = 0x1D
    WRONG_PARAMETER = 0x1E
    PROGRAM_END = 0x1F
    TRIGGER = 0x40
    READY = 0x41
    GUI_CONNECTED = 0x42
    GUI_DISCONNECTED = 0x43
    PROGRAM_CHANGED = 0x44
    TEMPERATURE_LOW = 0x70
    TEMPERATURE_HIGH = 0x71
    LOGIC_VOLTAGE_LOW = 0x72
    LOGIC_VOLTAGE_HIGH = 0x73
    MOTOR_VOLTAGE_LOW = 0x74
    MOTOR_VOLTAGE_HIGH = 0x75
    CABLE_BREAK = 0x76
    MOTOR_TEMPERATURE = 0x78
    WRONG_RAMP_TYPE = 0xC8
    CONFIG_MEMORY = 0xD2
    PROGRAM_MEMORY = 0xD3
    INVALID_PHRASE = 0xD4
    SOFT_LIMIT_LOW = 0xD5
    SOFT_LIMIT_HIGH = 0xD6
    PRESSURE = 0xD7
    SERVICE = 0xD8
    EMERGENCY_STOP = 0xD9
    TOW = 0xDA
    VPC3 = 0xDB
    FRAGMENTATION = 0xDC
    COMMUTATION = 0xDD
    CURRENT = 0xDE
    I2T = 0xDF
    INITIALISE = 0xE0
    INTERNAL = 0xE1
    HARD_LIMIT_LOW = 0xE2
    HARD_LIMIT_HIGH = 0xE3
    TOO_FAST = 0xE4
    MATH = 0xEC


@dataclass(frozen=True, slots=True)
class Problem:
    """What a code means and what to do about it."""

    text: str
    advice: str = ""


_POWER_CYCLE = "switch the gripper's power off and on; if it comes back, have it serviced"
_SUPPLY = "check the gripper's power supply and its cable"
_COOL = "let the gripper cool down and lower speed or current"

PROBLEMS: dict[int, Problem] = {
    Code.NONE: Problem("no error"),
    Code.BOOT: Problem("started up", "if it starts up by itself, check the power supply"),
    Code.NO_FREE_SPACE: Problem("no memory left", "delete programs stored in the module"),
    Code.NO_RIGHTS: Problem("the user level does not allow this", "change the user first"),
    Code.UNKNOWN_COMMAND: Problem("unknown command", "check the module's firmware version"),
    Code.FAILED: Problem("cannot be done in this state", "acknowledge errors, then try again"),
    Code.NOT_REFERENCED: Problem("not referenced", "reference the gripper first"),
    Code.SEARCH_SINE_VECTOR: Problem("searching its motor angle", "wait a moment"),
    Code.NO_ERROR: Problem("no error"),
    Code.COMMUNICATION: Problem("communication error", "check cable, baud rate and parity"),
    Code.TIMEOUT: Problem("a message was not completed in time", "check the cable"),
    Code.WRONG_BAUD: Problem("wrong baud rate", "set the baud rate of the profile to the module's"),
    Code.CHECKSUM: Problem("wrong checksum", "check the cable for noise and the serial settings"),
    Code.MESSAGE_LENGTH: Problem("wrong message length", "check the module's unit system"),
    Code.WRONG_PARAMETER: Problem("a parameter is out of range", "stay within the limits"),
    Code.PROGRAM_END: Problem("program ended"),
    Code.TRIGGER: Problem("triggered"),
    Code.READY: Problem("ready"),
    Code.GUI_CONNECTED: Problem("a service program is connected", "disconnect it"),
    Code.GUI_DISCONNECTED: Problem("the service program is disconnected"),
    Code.PROGRAM_CHANGED: Problem("the stored program changed"),
    Code.TEMPERATURE_LOW: Problem("too cold", "warm the gripper up"),
    Code.TEMPERATURE_HIGH: Problem("too hot", _COOL),
    Code.LOGIC_VOLTAGE_LOW: Problem("logic voltage too low", _SUPPLY),
    Code.LOGIC_VOLTAGE_HIGH: Problem("logic voltage too high", _SUPPLY),
    Code.MOTOR_VOLTAGE_LOW: Problem("motor voltage too low", _SUPPLY),
    Code.MOTOR_VOLTAGE_HIGH: Problem("motor voltage too high", _SUPPLY),
    Code.CABLE_BREAK: Problem("a cable is broken", "check the gripper's cables and plugs"),
    Code.MOTOR_TEMPERATURE: Problem("motor too hot", _COOL),
    Code.WRONG_RAMP_TYPE: Problem("wrong ramp type", "check the module's configuration"),
    Code.CONFIG_MEMORY: Problem("configuration memory unreadable", _POWER_CYCLE),
    Code.PROGRAM_MEMORY: Problem("program memory unreadable", _POWER_CYCLE),
    Code.INVALID_PHRASE: Problem("invalid step in a stored program", "correct the program"),
    Code.SOFT_LIMIT_LOW: Problem(
        "the fingers ran to the lower soft limit", "nothing was between them; acknowledge"
    ),
    Code.SOFT_LIMIT_HIGH: Problem(
        "the fingers ran to the upper soft limit", "acknowledge, then close them a little"
    ),
    Code.PRESSURE: Problem("pressure fault", _POWER_CYCLE),
    Code.SERVICE: Problem("service is due", "have the gripper serviced"),
    Code.EMERGENCY_STOP: Problem("emergency stop", "make sure it is safe, then acknowledge"),
    Code.TOW: Problem("the fingers lag behind", "look for something that blocks them; acknowledge"),
    Code.VPC3: Problem("field-bus chip fault", _POWER_CYCLE),
    Code.FRAGMENTATION: Problem("a message arrived in wrong parts", "check the cable"),
    Code.COMMUTATION: Problem("motor commutation failed", _POWER_CYCLE),
    Code.CURRENT: Problem("motor current too high", "look for something that jams the fingers"),
    Code.I2T: Problem("motor overloaded for too long", _COOL),
    Code.INITIALISE: Problem("could not start up", _POWER_CYCLE),
    Code.INTERNAL: Problem("internal fault", _POWER_CYCLE),
    Code.HARD_LIMIT_LOW: Problem("the fingers hit their lower stop", "acknowledge and reference"),
    Code.HARD_LIMIT_HIGH: Problem("the fingers hit their upper stop", "acknowledge and reference"),
    Code.TOO_FAST: Problem("moved too fast", "lower the speed and acknowledge"),
    Code.MATH: Problem("internal arithmetic fault", _POWER_CYCLE),
}


def problem_of(code: int) -> Problem:
    """Return what a code means; an unknown code is named by its number."""
    return PROBLEMS.get(code) or Problem(f"unknown code {code:#04x}", "see the module's manual")


ValueType = Literal["u8", "u16", "u32", "f32"]


class Register(IntEnum):
    """Sub-ids of the configuration."""

    MODULE_ID = 0x01
    GROUP_ID = 0x02
    BAUD = 0x03
    CAN_BAUD = 0x04
    COMMUNICATION_MODE = 0x05
    UNIT_SYSTEM = 0x06
    SOFT_LIMIT_HIGH = 0x07
    SOFT_LIMIT_LOW = 0x08
    MAX_VELOCITY = 0x09
    MAX_ACCELERATION = 0x0A
    MAX_CURRENT = 0x0B
    NOMINAL_CURRENT = 0x0C
    MAX_JERK = 0x0D
    REFERENCE_OFFSET = 0x14
    SERIAL_NUMBER = 0x15
    ORDER_NUMBER = 0x16
    GEAR_RATIO = 0x18


REGISTER_TYPES: dict[int, ValueType] = {
    Register.MODULE_ID: "u8",
    Register.GROUP_ID: "u8",
    Register.BAUD: "u16",
    Register.CAN_BAUD: "u16",
    Register.COMMUNICATION_MODE: "u8",
    Register.UNIT_SYSTEM: "u8",
    Register.SOFT_LIMIT_HIGH: "f32",
    Register.SOFT_LIMIT_LOW: "f32",
    Register.MAX_VELOCITY: "f32",
    Register.MAX_ACCELERATION: "f32",
    Register.MAX_CURRENT: "f32",
    Register.NOMINAL_CURRENT: "f32",
    Register.MAX_JERK: "f32",
    Register.REFERENCE_OFFSET: "f32",
    Register.SERIAL_NUMBER: "u32",
    Register.ORDER_NUMBER: "u32",
    Register.GEAR_RATIO: "f32",
}

LENGTH_REGISTERS = frozenset(
    {
        Register.SOFT_LIMIT_HIGH,
        Register.SOFT_LIMIT_LOW,
        Register.MAX_VELOCITY,
        Register.MAX_ACCELERATION,
        Register.MAX_JERK,
        Register.REFERENCE_OFFSET,
    }
)
"""Registers whose value is told in the module's unit of length."""

UNIT_SYSTEMS = {
    0: "millimetre",
    1: "metre",
    2: "inch",
    3: "radian",
    4: "degree",
    5: "internal",
    6: "micrometre, integer",
    7: "micro-degree, integer",
    8: "micro-inch, integer",
    9: "milli-degree, integer",
}
"""Unit systems by the value of their register; names of 6 to 9 are assumed."""

UNIT_MILLIMETRE = 0

MM_PER_UNIT = {0: 1.0, 1: 1000.0, 2: 25.4}
"""Millimetres in the unit of length of each unit system that has one and uses floats."""


class UserLevel(IntEnum):
    """What the connected user may do."""

    USER = 0
    DIAGNOSTICS = 1
    PROFI = 2
    ADVANCED = 3
