"""Replies and impulses of a module to bytes and back.

A length byte of 2 always means a refusal or, behind the command bytes of
errors, warnings and infos, one of those; every success has another length.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import Frame, encode_frame
from cell.drivers.schunk_smp.replies import (
    Accepted,
    Answer,
    DetailedError,
    ErrorReport,
    Identity,
    ImpulsesSwitched,
    Info,
    KnownValues,
    KnownValuesChecked,
    MoveAccepted,
    MoveBlocked,
    PositionReached,
    Refused,
    RegisterValue,
    RegisterWritten,
    Reply,
    StateReply,
    UserChanged,
    WarningReport,
)
from cell.drivers.schunk_smp.tables import TARGETS, Code, Command, Group, StateMode
from cell.drivers.schunk_smp.values import floats, pack_floats, pack_register, unpack_register

_OK = b"OK"
_IDENTITY = struct.Struct("<8sIHHH21s5s")
_DETAIL = struct.Struct("<BBf")
TEST_VALUES = struct.pack("<ffiihh", -1.2345, 47.11, 0x00BC614E, -0x00BC614E, 512, -20482)
"""The block of the link self-test (assumed; compared as a whole)."""


def encode_reply(module: int, reply: Reply, *, refusal_group: int = Group.REFUSAL) -> bytes:
    """Return the frame with which module number `module` says `reply`.

    Args:
        module: The module's id.
        reply: What is said.
        refusal_group: First byte of refusals; sources differ between 0x03 and 0x07.
    """
    group = Group.MODULE
    if isinstance(reply, Refused):
        group = Group(refusal_group)
    elif isinstance(reply, ErrorReport):
        group = Group.REFUSAL
    code, parameters = _code_and_parameters(reply)
    return encode_frame(Frame(group, module, code, parameters))


def _code_and_parameters(reply: Reply) -> tuple[int, bytes]:
    match reply:
        case StateReply():
            values = (reply.position_mm, reply.velocity_mm_s, reply.current_a)
            told = pack_floats(*(v for v in values if v is not None))
            return Command.GET_STATE, told + bytes((reply.status, reply.error))
        case Accepted(command):
            return command, _OK
        case MoveAccepted(command, duration_s):
            return command, pack_floats(duration_s)
        case Refused(command_byte, code):
            return command_byte, bytes((code,))
        case MoveBlocked(position_mm):
            return Command.MOVE_BLOCKED, pack_floats(position_mm)
        case PositionReached(position_mm, status, error):
            tail = b"" if status is None else bytes((status, error or 0))
            return Command.POSITION_REACHED, pack_floats(position_mm) + tail
        case Info(code):
            return Command.INFO, code.to_bytes(2, "little")
        case ErrorReport(code):
            return Command.ERROR, bytes((code,))
        case WarningReport(code):
            return Command.WARNING, bytes((code,))
        case _:
            return _rare_code_and_parameters(reply)


def _rare_code_and_parameters(
    reply: RegisterValue
    | RegisterWritten
    | Identity
    | DetailedError
    | UserChanged
    | ImpulsesSwitched
    | KnownValues
    | KnownValuesChecked,
) -> tuple[int, bytes]:
    match reply:
        case RegisterValue(register, value):
            return Command.GET_CONFIG, bytes((register,)) + pack_register(register, value)
        case RegisterWritten(register):
            return Command.SET_CONFIG, _OK + bytes((register,))
        case Identity():
            return Command.GET_CONFIG, _IDENTITY.pack(
                reply.kind.encode("ascii"),
                reply.order,
                reply.firmware,
                reply.protocol,
                reply.hardware,
                reply.date.encode("ascii"),
                reply.rest,
            )
        case DetailedError(kind, code, value):
            return Command.GET_DETAILED_ERROR, _DETAIL.pack(kind, code, value)
        case UserChanged(level):
            return Command.CHANGE_USER, _OK + bytes((level,))
        case ImpulsesSwitched(are_on):
            return Command.TOGGLE_IMPULSES, b"ON" if are_on else b"OFF"
        case KnownValues(block):
            return Command.SEND_TEST_VALUES, block
        case KnownValuesChecked(result):
            return Command.CHECK_TEST_VALUES, _OK + bytes((result,))


def decode_reply(frame: Frame, *, mode: StateMode = StateMode.ALL) -> Reply:
    """Return what a module's frame says.

    Args:
        frame: The frame.
        mode: What was asked of the state: a state reply does not say which of the
            three values it holds when it holds fewer.

    Raises:
        MalformedMessage: The frame is none that a module sends.
    """
    parameters = frame.parameters
    if len(parameters) == 1:
        report = _REPORTS.get(frame.command)
        return Refused(frame.command, parameters[0]) if report is None else report(parameters[0])
    if frame.command == Command.GET_STATE:
        return _state(frame, mode)
    decode = _DECODERS.get(frame.command)
    if decode is None:
        raise MalformedMessage(f"unknown reply {frame.command:#04x}", code=Code.UNKNOWN_COMMAND)
    return decode(frame)


def _wrong_length(frame: Frame) -> MalformedMessage:
    name = Command(frame.command).name
    return MalformedMessage(
        f"the reply to {name} does not hold {frame.parameters.hex(' ') or 'nothing'}",
        code=Code.MESSAGE_LENGTH,
    )


def _state(frame: Frame, mode: StateMode) -> StateReply:
    parameters = frame.parameters
    size = len(parameters) - 2
    if size == 12:
        mode = StateMode.ALL
    elif size < 0 or size != 4 * mode.bit_count():
        raise _wrong_length(frame)
    told = iter(floats(parameters[:size]))
    return StateReply(
        next(told) if mode & StateMode.POSITION else None,
        next(told) if mode & StateMode.VELOCITY else None,
        next(told) if mode & StateMode.CURRENT else None,
        parameters[-2],
        parameters[-1],
    )


def _accepted(frame: Frame) -> Reply:
    if frame.parameters != _OK:
        raise _wrong_length(frame)
    return Accepted(Command(frame.command))


def _move_accepted(frame: Frame) -> Reply:
    if len(frame.parameters) == 4:
        return MoveAccepted(Command(frame.command), *floats(frame.parameters))
    return _accepted(frame)


def _blocked(frame: Frame) -> Reply:
    if len(frame.parameters) not in (4, 6):
        raise _wrong_length(frame)
    return MoveBlocked(*floats(frame.parameters[:4]))


def _reached(frame: Frame) -> Reply:
    if len(frame.parameters) not in (4, 6):
        raise _wrong_length(frame)
    (position_mm,) = floats(frame.parameters[:4])
    return PositionReached(position_mm, *frame.parameters[4:])


def _info(frame: Frame) -> Reply:
    if len(frame.parameters) != 2:
        raise _wrong_length(frame)
    return Info(int.from_bytes(frame.parameters, "little"))


def _config(frame: Frame) -> Reply:
    if len(frame.parameters) == _IDENTITY.size:
        kind, order, firmware, protocol, hardware, date, rest = _IDENTITY.unpack(frame.parameters)
        return Identity(
            kind=_text(kind),
            order=order,
            firmware=firmware,
            protocol=protocol,
            hardware=hardware,
            date=_text(date),
            rest=rest,
        )
    if not frame.parameters:
        raise _wrong_length(frame)
    register = frame.parameters[0]
    return RegisterValue(register, unpack_register(register, frame.parameters[1:]))


def _text(field: bytes) -> str:
    return field.split(b"\0")[0].decode("ascii", "replace").strip()


def _after_ok(frame: Frame) -> int:
    if len(frame.parameters) != 3 or frame.parameters[:2] != _OK:
        raise _wrong_length(frame)
    return frame.parameters[2]


def _detail(frame: Frame) -> Reply:
    kinds = (Command.ERROR, Command.WARNING, Command.INFO)
    if len(frame.parameters) != _DETAIL.size or frame.parameters[0] not in kinds:
        raise _wrong_length(frame)
    kind, code, value = _DETAIL.unpack(frame.parameters)
    return DetailedError(Command(kind), code, value)


def _impulses(frame: Frame) -> Reply:
    if frame.parameters not in (b"ON", b"OFF"):
        raise _wrong_length(frame)
    return ImpulsesSwitched(frame.parameters == b"ON")


_REPORTS: dict[int, Callable[[int], Reply]] = {
    Command.ERROR: ErrorReport,
    Command.WARNING: WarningReport,
    Command.INFO: Info,
}
_ONLY_ACCEPTED = (
    Command.REFERENCE,
    Command.STOP,
    Command.EMERGENCY_STOP,
    Command.ACKNOWLEDGE,
    *TARGETS,
    Command.MOVE_CURRENT,
    Command.MOVE_VELOCITY,
    Command.MOVE_GRIP,
    Command.REBOOT,
)
_DECODERS: dict[int, Callable[[Frame], Reply]] = {
    **dict.fromkeys(_ONLY_ACCEPTED, _accepted),
    Command.MOVE_POSITION: _move_accepted,
    Command.MOVE_POSITION_RELATIVE: _move_accepted,
    Command.MOVE_POSITION_TIME: _move_accepted,
    Command.MOVE_POSITION_TIME_RELATIVE: _move_accepted,
    Command.MOVE_BLOCKED: _blocked,
    Command.POSITION_REACHED: _reached,
    Command.INFO: _info,
    Command.GET_CONFIG: _config,
    Command.SET_CONFIG: lambda frame: RegisterWritten(_after_ok(frame)),
    Command.GET_DETAILED_ERROR: _detail,
    Command.CHANGE_USER: lambda frame: UserChanged(_after_ok(frame)),
    Command.SEND_TEST_VALUES: lambda frame: KnownValues(frame.parameters),
    Command.CHECK_TEST_VALUES: lambda frame: KnownValuesChecked(_after_ok(frame)),
    Command.TOGGLE_IMPULSES: _impulses,
}


def answered_command(reply: Answer) -> int:
    """Return the command byte that a reply answers."""
    match reply:
        case Accepted(command) | MoveAccepted(command, _) | Refused(command, _):
            return command
        case _:
            return _code_and_parameters(reply)[0]
