"""The registers that master and slave share (Bloch 1994, table 5.1), as data.

Offsets count bytes from the base of the dual-port memory; a register is a 16-bit word,
a position two of them, the low word first. Torque words lie at 40-46: table 5.1 prints
20-26, but both programs use 40-46, and 20-26 hold the velocities.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

JOINTS = 4
JOINT_NAMES = ("J1", "J2", "J3 (slide)", "J4 (roll)")


class Register(IntEnum):
    """Offset of each register from the base."""

    SAMPLE_PERIOD = 0x00
    """Period of the servo loop in microseconds."""
    TIMING_A = 0x02
    TIMING_B = 0x04
    COMMAND = 0x06
    ERROR = 0x08
    POSITIONS = 0x10
    """Four double words."""
    VELOCITIES = 0x20
    ACCELERATIONS = 0x30
    GRIPPER = 0x2A
    TORQUES = 0x40
    LAMPS = 0x1000
    """The lamps' latch lies at an address of its own, 1000 hex past the base."""


class Command(IntFlag):
    """Bits of the command register; the slave clears it when it is done."""

    SERVO = 0x0001
    FIND_HOME = 0x0080


class TimingA(IntFlag):
    """What the slave has ready in this sample period; the master clears it at its end."""

    STARTED = 0x0001
    POSITIONS = 0x0002
    VELOCITIES = 0x0004
    ACCELERATIONS = 0x0008


class TimingB(IntFlag):
    """What the master has ready; the slave clears it when it has taken the torques."""

    TORQUES = 0x0001


class GripperBit(IntFlag):
    """Bits of the gripper register (table 5.2); the slave clears it when it is done."""

    OPEN = 0x0001
    CLOSE = 0x0080


class Lamp(IntFlag):
    """Bits of the lamps' latch."""

    HALOGEN = 0x0001
    FLUORESCENT = 0x0002


class Fault(IntFlag):
    """Bits of the error register."""

    OVERRUN_1_POSITIVE = 0x0001
    OVERRUN_1_NEGATIVE = 0x0002
    OVERRUN_2_POSITIVE = 0x0004
    OVERRUN_2_NEGATIVE = 0x0008
    OVERRUN_3_POSITIVE = 0x0010
    OVERRUN_3_NEGATIVE = 0x0020
    OVERRUN_4_POSITIVE = 0x0040
    OVERRUN_4_NEGATIVE = 0x0080
    TORQUE_1 = 0x0100
    TORQUE_2 = 0x0200
    TORQUE_3 = 0x0400
    TORQUE_4 = 0x0800
    TORQUES_LATE = 0x1000
    LOOP_TOO_SLOW = 0x2000


OVERRUNS = 0x00FF
"""Bits that the slave sets and clears by itself, as the joints stand."""
TORQUE_FAULTS = 0x0F00
TORQUE_ZERO = 0x0800
"""The torque word of no torque: the middle of the 12-bit range."""
TORQUE_MAX = 0x0FFF
TORQUE_REFUSED = 0xFFFF
"""A word that the slave refuses; stands for any torque beyond the range."""

OVERRUN_MIN = (-4361, -2222, -381, -41187)
"""Least position of each joint in pulses before its negative overrun is set."""
OVERRUN_MAX = (176188, 60222, 95621, 41187)
"""Greatest position of each joint in pulses before its positive overrun is set."""

MOTOR_POWER_OFF = 0x10000
"""Alarm beyond the register's 16 bits: the bridge sees that motor power was cut."""


def explain(alarm: int) -> tuple[str, str]:
    """Return what error bits mean and what to do about them.

    Args:
        alarm: The error register, with `MOTOR_POWER_OFF` added where it applies.

    Returns:
        The text and the hint; both empty for 0.
    """
    texts: list[str] = []
    hints: list[str] = []
    if alarm & MOTOR_POWER_OFF:
        texts.append("motor power is off, the emergency stop was pressed")
        hints.append("release the emergency stop, reset the alarm, open the arm again")
    for joint, name in enumerate(JOINT_NAMES):
        for side, word in ((0, "positive"), (1, "negative")):
            if alarm & (1 << (2 * joint + side)):
                texts.append(f"{name} stands past its {word} limit")
                hints.append("move the joint back into the work space by hand")
        if alarm & (Fault.TORQUE_1 << joint):
            texts.append(f"{name} asked for more torque than there is")
            hints.append("look whether something holds the joint or motor power is off")
    if alarm & Fault.TORQUES_LATE:
        texts.append("the torques came later than the sample period")
        hints.append("relieve the computer, or use a faster bridge or a longer sample period")
    if alarm & Fault.LOOP_TOO_SLOW:
        texts.append("the servo loop took longer than the sample period")
        hints.append("relieve the computer, or use a faster bridge or a longer sample period")
    return "; ".join(texts), "; ".join(dict.fromkeys(hints))
