"""Commands of a master to bytes and back."""

from __future__ import annotations

from collections.abc import Callable

from cell.drivers.schunk_smp.commands import (
    Acknowledge,
    ChangeUser,
    CheckTestValues,
    CommandRecord,
    EmergencyStop,
    GetConfig,
    GetDetailedError,
    GetState,
    MoveCurrent,
    MoveGrip,
    MovePosition,
    MovePositionTimed,
    MoveVelocity,
    Reboot,
    Reference,
    SendTestValues,
    SetConfig,
    SetTarget,
    Stop,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import Frame, encode_frame
from cell.drivers.schunk_smp.tables import TARGETS, Code, Command, Group, StateMode
from cell.drivers.schunk_smp.values import floats, pack_floats, pack_register, unpack_register

_BARE: dict[int, CommandRecord] = {
    Command.REFERENCE: Reference(),
    Command.STOP: Stop(),
    Command.EMERGENCY_STOP: EmergencyStop(),
    Command.ACKNOWLEDGE: Acknowledge(),
    Command.GET_DETAILED_ERROR: GetDetailedError(),
    Command.REBOOT: Reboot(),
    Command.TOGGLE_IMPULSES: ToggleImpulses(),
    Command.SEND_TEST_VALUES: SendTestValues(),
}
_BARE_CODES: dict[type[CommandRecord], Command] = {
    type(record): Command(code) for code, record in _BARE.items()
}


def command_byte(command: CommandRecord) -> Command:
    """Return the command byte of a record; its reply carries the same one."""
    bare = _BARE_CODES.get(type(command))
    return _code_and_parameters(command)[0] if bare is None else bare


def encode_command(module: int, command: CommandRecord) -> bytes:
    """Return the frame that asks module number `module`.

    Raises:
        MalformedMessage: A value does not fit its field, or a value follows one left out.
    """
    bare = _BARE_CODES.get(type(command))
    code, parameters = _code_and_parameters(command) if bare is None else (bare, b"")
    return encode_frame(Frame(Group.MASTER, module, code, parameters))


def _code_and_parameters(command: CommandRecord) -> tuple[Command, bytes]:
    match command:
        case MovePosition():
            relative = command.is_relative
            return (
                Command.MOVE_POSITION_RELATIVE if relative else Command.MOVE_POSITION,
                pack_floats(
                    command.position_mm,
                    command.velocity_mm_s,
                    command.acceleration_mm_s2,
                    command.current_a,
                    command.jerk_mm_s3,
                ),
            )
        case GetState(period_s, mode):
            tail = b"" if mode is None else bytes((mode,))
            if period_s is None and tail:
                raise MalformedMessage("a state's mode follows its period", code=Code.FAILED)
            return Command.GET_STATE, pack_floats(period_s) + tail
        case MovePositionTimed():
            relative = command.is_relative
            return (
                Command.MOVE_POSITION_TIME_RELATIVE if relative else Command.MOVE_POSITION_TIME,
                pack_floats(
                    command.position_mm,
                    command.velocity_mm_s,
                    command.acceleration_mm_s2,
                    command.current_a,
                    command.time_s,
                ),
            )
        case MoveCurrent(current_a):
            return Command.MOVE_CURRENT, pack_floats(current_a)
        case MoveVelocity(velocity_mm_s, current_a):
            return Command.MOVE_VELOCITY, pack_floats(velocity_mm_s, current_a)
        case MoveGrip(current_a):
            return Command.MOVE_GRIP, pack_floats(current_a)
        case SetTarget(target, value):
            return target, pack_floats(value)
        case GetConfig(register):
            return Command.GET_CONFIG, b"" if register is None else bytes((register,))
        case SetConfig(register, value):
            return Command.SET_CONFIG, bytes((register,)) + pack_register(register, value)
        case ChangeUser(password):
            return Command.CHANGE_USER, password.encode("ascii", "replace")
        case CheckTestValues(block):
            return Command.CHECK_TEST_VALUES, block
        case _:
            return _BARE_CODES[type(command)], b""


def decode_command(frame: Frame) -> CommandRecord:
    """Return what a master's frame asks.

    Raises:
        MalformedMessage: The command is unknown, or its parameters have the wrong length.
    """
    bare = _BARE.get(frame.command)
    if bare is not None:
        if frame.parameters:
            raise _wrong_length(frame)
        return bare
    decode = _DECODERS.get(frame.command)
    if decode is None:
        raise MalformedMessage(f"unknown command {frame.command:#04x}", code=Code.UNKNOWN_COMMAND)
    return decode(frame)


def _wrong_length(frame: Frame) -> MalformedMessage:
    name = Command(frame.command).name
    return MalformedMessage(
        f"{name} does not have {len(frame.parameters)} parameter bytes", code=Code.MESSAGE_LENGTH
    )


def _float_parameters(frame: Frame, least: int, most: int) -> tuple[float, ...]:
    count, rest = divmod(len(frame.parameters), 4)
    if rest or not least <= count <= most:
        raise _wrong_length(frame)
    return floats(frame.parameters)


def _move_position(frame: Frame) -> CommandRecord:
    values: list[float | None] = list(_float_parameters(frame, 1, 5))
    values += [None] * (5 - len(values))
    position_mm, velocity, acceleration, current, jerk = values
    is_relative = frame.command == Command.MOVE_POSITION_RELATIVE
    return MovePosition(position_mm or 0.0, velocity, acceleration, current, jerk, is_relative)


def _move_position_timed(frame: Frame) -> CommandRecord:
    position, velocity, acceleration, current, time_s = _float_parameters(frame, 5, 5)
    is_relative = frame.command == Command.MOVE_POSITION_TIME_RELATIVE
    return MovePositionTimed(position, velocity, acceleration, current, time_s, is_relative)


def _move_velocity(frame: Frame) -> CommandRecord:
    return MoveVelocity(*_float_parameters(frame, 1, 2))


def _get_state(frame: Frame) -> CommandRecord:
    size = len(frame.parameters)
    if size == 0:
        return GetState()
    if size not in (4, 5):
        raise _wrong_length(frame)
    (period_s,) = floats(frame.parameters[:4])
    mode = StateMode(frame.parameters[4] & StateMode.ALL) if size == 5 else None
    return GetState(period_s, mode)


def _get_config(frame: Frame) -> CommandRecord:
    if len(frame.parameters) > 1:
        raise _wrong_length(frame)
    return GetConfig(frame.parameters[0] if frame.parameters else None)


def _set_config(frame: Frame) -> CommandRecord:
    if not frame.parameters:
        raise _wrong_length(frame)
    register = frame.parameters[0]
    return SetConfig(register, unpack_register(register, frame.parameters[1:]))


def _change_user(frame: Frame) -> CommandRecord:
    return ChangeUser(frame.parameters.decode("ascii", "replace"))


def _set_target(frame: Frame) -> CommandRecord:
    return SetTarget(Command(frame.command), *_float_parameters(frame, 1, 1))


def _move_current(frame: Frame) -> CommandRecord:
    return MoveCurrent(*_float_parameters(frame, 1, 1))


def _move_grip(frame: Frame) -> CommandRecord:
    return MoveGrip(*_float_parameters(frame, 1, 1))


def _check_test_values(frame: Frame) -> CommandRecord:
    return CheckTestValues(frame.parameters)


_DECODERS: dict[int, Callable[[Frame], CommandRecord]] = {
    Command.MOVE_POSITION: _move_position,
    Command.MOVE_POSITION_RELATIVE: _move_position,
    Command.MOVE_POSITION_TIME: _move_position_timed,
    Command.MOVE_POSITION_TIME_RELATIVE: _move_position_timed,
    Command.MOVE_CURRENT: _move_current,
    Command.MOVE_VELOCITY: _move_velocity,
    Command.MOVE_GRIP: _move_grip,
    Command.GET_STATE: _get_state,
    Command.GET_CONFIG: _get_config,
    Command.SET_CONFIG: _set_config,
    Command.CHANGE_USER: _change_user,
    Command.CHECK_TEST_VALUES: _check_test_values,
    **dict.fromkeys(TARGETS, _set_target),
}
