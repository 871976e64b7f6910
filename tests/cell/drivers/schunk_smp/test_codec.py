import pytest

from cell.drivers.schunk_smp.command_codec import command_byte, decode_command, encode_command
from cell.drivers.schunk_smp.commands import (
    ChangeUser,
    CheckTestValues,
    CommandRecord,
    EmergencyStop,
    GetConfig,
    GetDetailedError,
    GetState,
    MoveCurrent,
    MovePosition,
    MovePositionTimed,
    MoveVelocity,
    Reboot,
    SendTestValues,
    SetConfig,
    SetTarget,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.errors import MalformedMessage
from cell.drivers.schunk_smp.framing import FROM_MASTER, FROM_MODULE, Frame, FrameReader
from cell.drivers.schunk_smp.replies import (
    IMPULSES,
    Accepted,
    DetailedError,
    Identity,
    ImpulsesSwitched,
    Info,
    KnownValues,
    KnownValuesChecked,
    PositionReached,
    Refused,
    RegisterValue,
    RegisterWritten,
    Reply,
    StateReply,
    UserChanged,
    WarningReport,
)
from cell.drivers.schunk_smp.reply_codec import (
    TEST_VALUES,
    answered_command,
    decode_reply,
    encode_reply,
)
from cell.drivers.schunk_smp.tables import TARGETS, Code, Command, Group, Register, StateMode
from tests.cell.drivers.schunk_smp.worked import COMMANDS, REPLIES

OTHER_COMMANDS: list[CommandRecord] = [
    EmergencyStop(),
    GetDetailedError(),
    Reboot(),
    ToggleImpulses(),
    SendTestValues(),
    CheckTestValues(TEST_VALUES),
    MovePosition(-2.5, 10.0, 20.0, 0.5, 100.0, is_relative=True),
    MovePositionTimed(30.0, 40.0, 100.0, 0.5, 2.0),
    MovePositionTimed(3.0, 40.0, 100.0, 0.5, 2.0, is_relative=True),
    MoveCurrent(-0.5),
    MoveVelocity(-10.0, 0.75),
    *(SetTarget(target, 12.5) for target in TARGETS),
    GetState(),
    GetState(0.5),
    GetState(0.0, StateMode.VELOCITY | StateMode.CURRENT),
    GetConfig(),
    SetConfig(Register.UNIT_SYSTEM, 1),
    SetConfig(Register.BAUD, 38400),
    SetConfig(Register.SERIAL_NUMBER, 4_000_000_000),
    SetConfig(Register.SOFT_LIMIT_HIGH, 68.5),
    ChangeUser("profi"),
    ChangeUser(),
]

OTHER_REPLIES: list[tuple[Reply, StateMode]] = [
    (StateReply(None, 2.5, -0.5, 0x03, 0x00), StateMode.VELOCITY | StateMode.CURRENT),
    (StateReply(None, None, -0.5, 0x13, 0xD5), StateMode.CURRENT),
    (RegisterValue(Register.SOFT_LIMIT_HIGH, 69.0), StateMode.ALL),
    (RegisterValue(Register.ORDER_NUMBER, 306090), StateMode.ALL),
    (RegisterWritten(Register.UNIT_SYSTEM), StateMode.ALL),
    (
        Identity(
            kind="PG070", order=306090, firmware=150, protocol=3, hardware=1, date="2011-03-01"
        ),
        StateMode.ALL,
    ),
    (DetailedError(Command.ERROR, Code.SOFT_LIMIT_LOW, -0.5), StateMode.ALL),
    (UserChanged(2), StateMode.ALL),
    (ImpulsesSwitched(True), StateMode.ALL),
    (ImpulsesSwitched(False), StateMode.ALL),
    (KnownValues(TEST_VALUES), StateMode.ALL),
    (KnownValuesChecked(0), StateMode.ALL),
    (PositionReached(20.0, 0xE1, 0x00), StateMode.ALL),
    (WarningReport(Code.TEMPERATURE_HIGH), StateMode.ALL),
    *((Accepted(target), StateMode.ALL) for target in TARGETS),
]


def only_frame(data: bytes, groups: frozenset[int]) -> Frame:
    (frame,) = FrameReader(groups).feed(data)
    assert isinstance(frame, Frame)
    return frame


@pytest.mark.parametrize(("module", "record", "text"), COMMANDS, ids=lambda v: str(v)[:60])
def test_a_worked_command_reads_and_writes(module: int, record: CommandRecord, text: str) -> None:
    data = bytes.fromhex(text)
    assert encode_command(module, record) == data
    frame = only_frame(data, FROM_MASTER)
    assert frame.module == module
    assert decode_command(frame) == record
    assert frame.command == command_byte(record)


@pytest.mark.parametrize(("module", "record", "mode", "text"), REPLIES, ids=lambda v: str(v)[:60])
def test_a_worked_reply_reads_and_writes(
    module: int, record: Reply, mode: StateMode, text: str
) -> None:
    data = bytes.fromhex(text)
    assert encode_reply(module, record) == data
    frame = only_frame(data, FROM_MODULE)
    assert frame.module == module
    assert decode_reply(frame, mode=mode) == record


@pytest.mark.parametrize("record", OTHER_COMMANDS, ids=lambda v: str(v)[:60])
def test_every_other_command_survives_the_wire(record: CommandRecord) -> None:
    assert decode_command(only_frame(encode_command(12, record), FROM_MASTER)) == record


@pytest.mark.parametrize(("record", "mode"), OTHER_REPLIES, ids=lambda v: str(v)[:60])
def test_every_other_reply_survives_the_wire(record: Reply, mode: StateMode) -> None:
    assert decode_reply(only_frame(encode_reply(12, record), FROM_MODULE), mode=mode) == record


@pytest.mark.parametrize("text", ["03 0C 02 B0 06 13 52", "07 0C 02 B0 06 E2 92"])
def test_a_refusal_is_one_with_either_first_byte(text: str) -> None:
    frame = only_frame(bytes.fromhex(text), FROM_MODULE)
    assert decode_reply(frame) == Refused(Command.MOVE_POSITION, Code.NOT_REFERENCED)
    refused = Refused(Command.MOVE_POSITION, Code.NOT_REFERENCED)
    assert encode_reply(12, refused, refusal_group=frame.group) == bytes.fromhex(text)


def test_a_length_of_two_is_a_refusal_whatever_the_command() -> None:
    spontaneous = {Command.ERROR, Command.WARNING, Command.INFO}
    for command in set(range(256)) - spontaneous:
        reply = decode_reply(Frame(Group.MODULE, 12, command, b"\x05"))
        assert reply == Refused(command, Code.FAILED)
    assert decode_reply(Frame(Group.MODULE, 12, Command.INFO, b"\x08")) == Info(Code.NO_ERROR)


def test_a_state_with_all_three_values_is_read_whatever_was_asked() -> None:
    record = StateReply(1.0, 2.0, 3.0, 0x41, 0)
    frame = only_frame(encode_reply(12, record), FROM_MODULE)
    assert decode_reply(frame, mode=StateMode.POSITION) == record


@pytest.mark.parametrize(
    ("command", "parameters", "code"),
    [
        (0xFF, b"", Code.UNKNOWN_COMMAND),
        (Command.POSITION_REACHED, bytes(4), Code.UNKNOWN_COMMAND),
        (Command.REFERENCE, b"\x00", Code.MESSAGE_LENGTH),
        (Command.MOVE_POSITION, b"", Code.MESSAGE_LENGTH),
        (Command.MOVE_POSITION, bytes(5), Code.MESSAGE_LENGTH),
        (Command.MOVE_POSITION, bytes(24), Code.MESSAGE_LENGTH),
        (Command.MOVE_POSITION_TIME, bytes(16), Code.MESSAGE_LENGTH),
        (Command.MOVE_VELOCITY, bytes(12), Code.MESSAGE_LENGTH),
        (Command.MOVE_GRIP, bytes(8), Code.MESSAGE_LENGTH),
        (Command.GET_STATE, bytes(3), Code.MESSAGE_LENGTH),
        (Command.GET_STATE, bytes(6), Code.MESSAGE_LENGTH),
        (Command.GET_CONFIG, bytes(2), Code.MESSAGE_LENGTH),
        (Command.SET_CONFIG, b"", Code.MESSAGE_LENGTH),
        (Command.SET_CONFIG, b"\x01", Code.MESSAGE_LENGTH),
        (Command.SET_CONFIG, b"\x01\x02\x03", Code.MESSAGE_LENGTH),
        (Command.SET_CONFIG, b"\x7f\x02", Code.WRONG_PARAMETER),
    ],
)
def test_a_command_that_is_none_is_refused_with_its_code(
    command: int, parameters: bytes, code: Code
) -> None:
    with pytest.raises(MalformedMessage) as caught:
        decode_command(Frame(Group.MASTER, 12, command, parameters))
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("command", "parameters"),
    [
        (0xFF, b"OK"),
        (Command.REFERENCE, b"KO"),
        (Command.REFERENCE, b""),
        (Command.MOVE_POSITION, bytes(3)),
        (Command.GET_STATE, bytes(5)),
        (Command.GET_STATE, b""),
        (Command.MOVE_BLOCKED, bytes(3)),
        (Command.POSITION_REACHED, bytes(5)),
        (Command.INFO, bytes(3)),
        (Command.GET_CONFIG, b""),
        (Command.GET_CONFIG, b"\x01\x02\x03"),
        (Command.SET_CONFIG, b"KO\x01"),
        (Command.GET_DETAILED_ERROR, b"\x88" + bytes(4)),
        (Command.GET_DETAILED_ERROR, b"\x77" + bytes(5)),
        (Command.TOGGLE_IMPULSES, b"MAYBE"),
    ],
)
def test_a_reply_that_is_none_is_told_so(command: int, parameters: bytes) -> None:
    with pytest.raises(MalformedMessage):
        decode_reply(Frame(Group.MODULE, 12, command, parameters))


@pytest.mark.parametrize(
    "record",
    [
        MovePosition(1.0, None, 20.0),
        MovePosition(1e39),
        SetConfig(Register.MODULE_ID, 256),
        SetConfig(Register.MODULE_ID, 1.5),
        SetConfig(0x7F, 1),
        GetState(None, StateMode.ALL),
        CheckTestValues(bytes(255)),
    ],
)
def test_a_record_that_fits_no_frame_is_not_sent(record: CommandRecord) -> None:
    with pytest.raises(MalformedMessage):
        encode_command(12, record)


def test_an_answer_names_the_command_that_it_answers() -> None:
    for record, _ in OTHER_REPLIES:
        if not isinstance(record, IMPULSES):
            frame = only_frame(encode_reply(12, record), FROM_MODULE)
            assert answered_command(record) == frame.command
