"""The worked frames of the protocol's reference, as records and as bytes."""

import struct

from cell.drivers.schunk_smp.commands import (
    Acknowledge,
    CommandRecord,
    GetConfig,
    GetState,
    MoveGrip,
    MovePosition,
    MoveVelocity,
    Reference,
    Stop,
)
from cell.drivers.schunk_smp.replies import (
    Accepted,
    ErrorReport,
    Info,
    MoveAccepted,
    MoveBlocked,
    PositionReached,
    Refused,
    RegisterValue,
    Reply,
    StateReply,
)
from cell.drivers.schunk_smp.tables import Code, Command, Register, StateMode

ALL = StateMode.ALL
POSITION = StateMode.POSITION


def single(hexadecimal: str) -> float:
    """Return the single float that the four bytes are."""
    value: float = struct.unpack("<f", bytes.fromhex(hexadecimal))[0]
    return value


COMMANDS: list[tuple[int, CommandRecord, str]] = [
    (1, Reference(), "05 01 01 92 D1 31"),
    (1, MovePosition(10.0), "05 01 05 B0 00 00 20 41 48 80"),
    (1, GetState(1.0, POSITION), "05 01 06 95 00 00 80 3F 01 54 41"),
    (1, Acknowledge(), "05 01 01 8B 10 FB"),
    (12, Reference(), "05 0C 01 92 40 F2"),
    (12, Stop(), "05 0C 01 91 00 F3"),
    (12, Acknowledge(), "05 0C 01 8B 81 38"),
    (12, GetState(0.0, ALL), "05 0C 06 95 00 00 00 00 07 05 C2"),
    (12, GetState(0.0, POSITION), "05 0C 06 95 00 00 00 00 01 85 C0"),
    (12, GetState(single("CDCCCC3D"), ALL), "05 0C 06 95 CD CC CC 3D 07 C7 ED"),
    (12, MovePosition(34.5), "05 0C 05 B0 00 00 0A 42 CB 21"),
    (
        12,
        MovePosition(34.5, 40.0, 100.0),
        "05 0C 0D B0 00 00 0A 42 00 00 20 42 00 00 C8 42 DD B7",
    ),
    (12, MoveGrip(-1.0), "05 0C 05 B7 00 00 80 BF D8 00"),
    (12, MoveVelocity(10.0), "05 0C 05 B5 00 00 20 41 58 40"),
    (12, GetConfig(Register.MODULE_ID), "05 0C 02 80 01 CE 90"),
]

REPLIES: list[tuple[int, Reply, StateMode, str]] = [
    (1, Accepted(Command.REFERENCE), ALL, "07 01 03 92 4F 4B E9 D9"),
    (1, MoveBlocked(single("2156B940")), ALL, "07 01 05 93 21 56 B9 40 4D 22"),
    (
        1,
        MoveAccepted(Command.MOVE_POSITION, single("EEEE5640")),
        ALL,
        "07 01 05 B0 EE EE 56 40 7B E4",
    ),
    (1, PositionReached(single("B6F31F41")), ALL, "07 01 05 94 B6 F3 1F 41 7E D5"),
    (
        1,
        StateReply(single("3689813F"), None, None, 0x02, 0x00),
        POSITION,
        "07 01 07 95 36 89 81 3F 02 00 F9 BC",
    ),
    (1, ErrorReport(Code.MOTOR_VOLTAGE_LOW), ALL, "03 01 02 88 74 82 1B"),
    (1, Accepted(Command.ACKNOWLEDGE), ALL, "07 01 03 8B 4F 4B 38 1E"),
    (1, Info(Code.NO_ERROR), ALL, "07 01 03 8A 08 00 1A 19"),
    (12, Accepted(Command.REFERENCE), ALL, "07 0C 03 92 4F 4B C4 18"),
    (12, Accepted(Command.STOP), ALL, "07 0C 03 91 4F 4B 34 18"),
    (12, Accepted(Command.ACKNOWLEDGE), ALL, "07 0C 03 8B 4F 4B 15 DF"),
    (12, Info(Code.NO_ERROR), ALL, "07 0C 03 8A 08 00 37 D8"),
    (
        12,
        StateReply(34.5, 0.0, 0.0, 0xE1, 0x00),
        ALL,
        "07 0C 0F 95 00 00 0A 42 00 00 00 00 00 00 00 00 E1 00 6A DC",
    ),
    (12, MoveAccepted(Command.MOVE_POSITION, 1.5), ALL, "07 0C 05 B0 00 00 C0 3F DC 79"),
    (12, PositionReached(34.5), ALL, "07 0C 05 94 00 00 0A 42 3A FF"),
    (12, MoveBlocked(20.0), ALL, "07 0C 05 93 00 00 A0 41 B1 9E"),
    (12, Accepted(Command.MOVE_GRIP), ALL, "07 0C 03 B7 4F 4B D5 D3"),
    (12, Refused(Command.MOVE_POSITION, Code.NOT_REFERENCED), ALL, "03 0C 02 B0 06 13 52"),
    (12, ErrorReport(Code.SOFT_LIMIT_LOW), ALL, "03 0C 02 88 D5 41 0F"),
    (12, Info(Code.BOOT), ALL, "07 0C 03 8A 01 00 31 88"),
    (12, RegisterValue(Register.MODULE_ID, 12), ALL, "07 0C 03 80 01 0C 11 8F"),
]
