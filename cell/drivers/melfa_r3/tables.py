"""Tables of the R3 protocol: commands, status bits, error numbers.

What no maker's manual or second source confirms is marked `is_assumed` and is to
be checked at the controller; it is kept here so that a correction touches no logic.
"""

from __future__ import annotations

from enum import IntFlag
from typing import Literal, NamedTuple

ErrorClass = Literal["H", "L", "C"]
"""H switches the servos off, L stops the motion, C is a caution."""


class CommandRule(NamedTuple):
    """What a command needs.

    Attributes:
        needs_right: Whether the client must hold the operation right.
        is_assumed: Whether that is assumed rather than confirmed.
    """

    needs_right: bool
    is_assumed: bool = False


COMMANDS: dict[str, CommandRule] = {
    "OPEN": CommandRule(False),
    "CLOSE": CommandRule(False),
    "CNTLON": CommandRule(False),
    "CNTLOFF": CommandRule(False),
    "SRVON": CommandRule(True),
    "SRVOFF": CommandRule(False),
    "OVRD": CommandRule(False),
    "EXEC": CommandRule(True),
    "HNDON": CommandRule(True),
    "HNDOFF": CommandRule(True),
    "HNDSTS": CommandRule(False),
    "PPOSF": CommandRule(False),
    "JPOSF": CommandRule(False),
    "PPOS": CommandRule(False),
    "JPOS": CommandRule(False),
    "STATE": CommandRule(False),
    "DSTATE": CommandRule(False),
    "STPSIG": CommandRule(False),
    "STOP": CommandRule(False),
    "RUN": CommandRule(True),
    "RSTPRG": CommandRule(True),
    "SLOTINIT": CommandRule(True),
    "PRGLOAD": CommandRule(True),
    "RSTALRM": CommandRule(False),
    "ERROR": CommandRule(False),
    "ERRORMES": CommandRule(False),
    "ERRORRD": CommandRule(False),
    "IN": CommandRule(False, is_assumed=True),
    "OUT": CommandRule(False),
    "IOSIGNAL": CommandRule(False),
    "VAL": CommandRule(False, is_assumed=True),
    "PNR": CommandRule(False),
    "PAR": CommandRule(False),
    "MOVSP": CommandRule(True),
    "PDIR": CommandRule(False),
    "NEW": CommandRule(False, is_assumed=True),
    "LOAD": CommandRule(False, is_assumed=True),
    "ECLR": CommandRule(False, is_assumed=True),
    "EMDAT": CommandRule(False, is_assumed=True),
    "EDATA": CommandRule(False, is_assumed=True),
    "SAVE": CommandRule(False, is_assumed=True),
    "FDEL": CommandRule(False, is_assumed=True),
    "RSTPWR": CommandRule(False, is_assumed=True),
}
"""Command words. `OVRD=` and `OUT=` write and so need the right: see `WRITE_NEEDS_RIGHT`."""

WRITE_NEEDS_RIGHT = frozenset({"OVRD", "OUT"})
"""Commands that need the right only when an `=` follows."""

LONGEST_COMMAND = max(map(len, COMMANDS))
SHORTEST_COMMAND = min(map(len, COMMANDS))


class Run(IntFlag):
    """Bits of the run status (STATE, DSTATE)."""

    REPEAT = 0x01
    CYCLE_STOP_OFF = 0x02
    MACHINE_LOCK = 0x04
    TEACH = 0x08
    TEACH_RUNNING = 0x10
    SERVO_ON = 0x20
    RUNNING = 0x40
    OPERATION_ENABLED = 0x80


class Stop(IntFlag):
    """Bits of the stop status (STATE, DSTATE); one source only."""

    EMERGENCY = 0x01
    STOP = 0x02
    WAIT = 0x04
    STOP_SIGNAL_OFF = 0x08
    PROGRAM_SELECT = 0x10
    PSEUDO_INPUT = 0x40


class ErrorEntry(NamedTuple):
    """What an error number means.

    Attributes:
        severity: H, L or C.
        text: What happened, in our words.
        hint: What to do about it.
        is_assumed: Whether number and meaning are assumed rather than confirmed.
    """

    severity: ErrorClass
    text: str
    hint: str
    is_assumed: bool = True


EMERGENCY_EXTERNAL = 50
EMERGENCY_PANEL = 60
EMERGENCY_PENDANT = 70
SERVO_AMPLIFIER = 1010
SERVO_IS_OFF = 2000
OUT_OF_RANGE = 2600
TARGET_OUT_OF_RANGE = 2602
PATH_OUT_OF_RANGE = 2603
ILLEGAL_POSITION = 2800
POSTURE_MISMATCH = 2810
ARGUMENT_RANGE = 3110
ARGUMENT_COUNT = 3120
ARGUMENT_TYPE = 3810
UNKNOWN_COMMAND = 4200
SYNTAX = 4220
UNKNOWN_VARIABLE = 4330
NO_SUCH_PROGRAM = 4340
NO_SUCH_PARAMETER = 4350
NOT_OPEN = 5000
NOT_AUTOMATIC = 5010
NO_RIGHT = 5020
RIGHT_HELD_ELSEWHERE = 5030
NO_PROGRAM = 5050
SERVO_ON_IMPOSSIBLE = 5130
ALARM_ACTIVE = 5600
STOP_SIGNAL = 5610
CYCLE_STOP = 5620
SERVO_OFF = 5630
BUSY = 5640

_RELEASE = "release the emergency stop, then reset the alarm"
_TARGET = "choose a target within reach and limits, then reset the alarm"

ERRORS: dict[int, ErrorEntry] = {
    EMERGENCY_EXTERNAL: ErrorEntry("H", "the external emergency stop is pressed", _RELEASE),
    EMERGENCY_PANEL: ErrorEntry("H", "the panel's emergency stop is pressed", _RELEASE),
    EMERGENCY_PENDANT: ErrorEntry("H", "the teach pendant's emergency stop is pressed", _RELEASE),
    117: ErrorEntry(
        "H", "the real-time command is irregular", "send a smoother stream of positions", False
    ),
    SERVO_IS_OFF: ErrorEntry("L", "the servos are off", "open the arm again"),
    OUT_OF_RANGE: ErrorEntry("L", "the position is out of range", _TARGET),
    2601: ErrorEntry("L", "the start of the move is out of range", "jog the arm back into range"),
    TARGET_OUT_OF_RANGE: ErrorEntry("L", "the target of the move is out of range", _TARGET),
    PATH_OUT_OF_RANGE: ErrorEntry(
        "L", "the way to the target leaves the range", "choose another way, then reset the alarm"
    ),
    ILLEGAL_POSITION: ErrorEntry("L", "the position data are illegal", _TARGET),
    POSTURE_MISMATCH: ErrorEntry(
        "L",
        "a straight move cannot change the arm's posture",
        "use a joint move to change the posture, then reset the alarm",
    ),
    ARGUMENT_RANGE: ErrorEntry("L", "an argument is out of range", "correct the value"),
    ARGUMENT_COUNT: ErrorEntry("L", "the number of arguments is wrong", "correct the statement"),
    ARGUMENT_TYPE: ErrorEntry("L", "an argument has the wrong type", "correct the statement"),
    UNKNOWN_COMMAND: ErrorEntry(
        "C", "the controller does not know the command", "check the controller's software version"
    ),
    SYNTAX: ErrorEntry("L", "the statement has a syntax error", "correct the statement"),
    UNKNOWN_VARIABLE: ErrorEntry("L", "there is no such variable", "assign it first"),
    NO_SUCH_PROGRAM: ErrorEntry(
        "L", "there is no such program", "create the program, or name one that exists"
    ),
    NO_SUCH_PARAMETER: ErrorEntry("L", "there is no such parameter", "correct the name"),
    NOT_OPEN: ErrorEntry("C", "no session is open", "open the arm first"),
    NOT_AUTOMATIC: ErrorEntry(
        "C",
        "the key switch is not at AUTO",
        "turn the key switch to AUTO and disable the teach pendant",
    ),
    NO_RIGHT: ErrorEntry("C", "the operation right is not held", "open the arm again"),
    RIGHT_HELD_ELSEWHERE: ErrorEntry(
        "C",
        "somebody else holds the operation right",
        "give the right back at the panel or the other program",
    ),
    NO_PROGRAM: ErrorEntry("C", "no program is selected in the slot", "load a program first"),
    SERVO_ON_IMPOSSIBLE: ErrorEntry(
        "L", "the servos cannot be switched on", "clear the alarm and the emergency stop first"
    ),
    ALARM_ACTIVE: ErrorEntry("L", "an alarm is active", "remove its cause and reset the alarm"),
    STOP_SIGNAL: ErrorEntry("L", "the stop signal is on", "release the stop button or input"),
    CYCLE_STOP: ErrorEntry("L", "a cycle stop is active", "start the program anew"),
    SERVO_OFF: ErrorEntry("L", "the servos are off", "open the arm again"),
    BUSY: ErrorEntry("C", "the previous move is still under way", "wait for its end", False),
    6130: ErrorEntry("L", "the network communication failed", "check the network cable", False),
    7850: ErrorEntry("L", "the position file cannot be read", "restore the file", False),
}
"""Error numbers that are known one by one."""

ERROR_RANGES: tuple[tuple[int, int, ErrorEntry], ...] = (
    (
        39,
        46,
        ErrorEntry("H", "a door switch or the enabling device is open", "close the door"),
    ),
    (
        1010,
        1940,
        ErrorEntry(
            "H", "a servo amplifier reports a fault", "read the amplifier's display, call service"
        ),
    ),
    (2800, 2803, ErrorEntry("L", "the position data are illegal", _TARGET)),
)
"""Error numbers that are known by range: first, last, entry."""


def describe(number: int) -> ErrorEntry | None:
    """Return what an error number means, or None if the table does not know it."""
    entry = ERRORS.get(number)
    if entry is None:
        for first, last, ranged in ERROR_RANGES:
            if first <= number <= last:
                return ranged
    return entry
