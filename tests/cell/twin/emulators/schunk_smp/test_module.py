import pytest

from cell.drivers.schunk_smp.command_codec import encode_command
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
from cell.drivers.schunk_smp.framing import FROM_MODULE, Frame, FrameReader, encode_frame
from cell.drivers.schunk_smp.replies import (
    Accepted,
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
from cell.drivers.schunk_smp.reply_codec import TEST_VALUES, decode_reply
from cell.drivers.schunk_smp.tables import Code, Command, Register, StateMode, Status
from cell.twin.emulators.schunk_smp import SchunkModule, SchunkModuleSettings
from cell.twin.emulators.schunk_smp.motion import trapezoid_s
from tests.cell.twin.emulators.schunk_smp.bodies import BareFingers

SETTINGS = SchunkModuleSettings()
NOT_REFERENCED = Code.NOT_REFERENCED


class Bench:
    """A module on a bench: ask it, let time pass, hear what it says."""

    def __init__(
        self, settings: SchunkModuleSettings = SETTINGS, *, is_referenced: bool = True
    ) -> None:
        self.body = BareFingers()
        self.module = SchunkModule(self.body, settings, is_referenced=is_referenced)
        self.now_s = 100.0
        self._reader = FrameReader(FROM_MODULE)
        if not is_referenced:
            self.pass_time(0.0)
            assert self.pass_time(1.0) == [Info(Code.BOOT)]

    def pass_time(self, duration_s: float, mode: StateMode = StateMode.ALL) -> list[Reply]:
        """Let time pass and return what was said meanwhile."""
        self.now_s += duration_s
        found = self._reader.feed(self.module.transmit(self.now_s))
        return [decode_reply(f, mode=mode) for f in found if isinstance(f, Frame)]

    def say(self, command: CommandRecord) -> None:
        self.module.receive(encode_command(12, command), self.now_s)

    def ask(self, command: CommandRecord, mode: StateMode = StateMode.ALL) -> list[Reply]:
        """Say something and return what comes back within 50 ms."""
        self.say(command)
        return self.pass_time(0.05, mode)

    def state(self) -> StateReply:
        (reply,) = self.ask(GetState())
        assert isinstance(reply, StateReply)
        return reply


def test_a_module_without_power_says_nothing_and_forgets() -> None:
    bench = Bench()
    bench.body.has_power = False
    assert bench.ask(GetState()) == []
    bench.body.has_power = True
    assert bench.pass_time(0.0) == []
    assert bench.pass_time(1.0) == [Info(Code.BOOT)]
    assert not bench.module.is_referenced


def test_what_is_asked_while_it_starts_up_is_lost() -> None:
    bench = Bench(is_referenced=True)
    bench.body.has_power = False
    bench.pass_time(0.0)
    bench.body.has_power = True
    bench.pass_time(0.0)
    assert bench.ask(GetState()) == []


def test_the_boot_message_is_the_worked_frame() -> None:
    body = BareFingers()
    module = SchunkModule(body, SETTINGS)
    module.transmit(0.0)
    assert module.transmit(1.0) == bytes.fromhex("07 0C 03 8A 01 00 31 88")


def test_an_answer_takes_its_bytes_time_on_the_line() -> None:
    bench = Bench()
    bench.say(GetState())
    request_s = 6 * SETTINGS.byte_s
    reply_s = 20 * SETTINGS.byte_s
    end_s = bench.now_s + request_s + SETTINGS.latency_s + reply_s
    assert bench.module.next_output_s() == pytest.approx(end_s)
    half = bench.module.transmit(end_s - 10.5 * SETTINGS.byte_s)
    assert len(half) == 9
    assert len(half + bench.module.transmit(end_s + 1e-9)) == 20


def test_what_was_sent_is_sent_once() -> None:
    bench = Bench()
    assert len(bench.ask(GetState())) == 1
    assert bench.pass_time(1.0) == []


def test_a_frame_for_another_module_is_not_answered() -> None:
    bench = Bench()
    bench.module.receive(encode_command(11, GetState()), bench.now_s)
    assert bench.pass_time(1.0) == []


@pytest.mark.parametrize(
    "command",
    [MovePosition(10.0), MoveGrip(-1.0), MoveCurrent(-1.0), MoveVelocity(5.0)],
    ids=lambda c: type(c).__name__,
)
def test_a_move_before_referencing_is_refused(command: CommandRecord) -> None:
    bench = Bench(is_referenced=False)
    (refused,) = bench.ask(command)
    assert isinstance(refused, Refused)
    assert refused.code == NOT_REFERENCED
    assert bench.body.opening_mm(bench.now_s) == 40.0


@pytest.mark.parametrize("is_blocked", [False, True])
def test_referencing_takes_seconds_and_ends_with_an_impulse(is_blocked: bool) -> None:
    bench = Bench(SchunkModuleSettings(reference_is_blocked=is_blocked), is_referenced=False)
    assert bench.ask(Reference()) == [Accepted(Command.REFERENCE)]
    assert bench.pass_time(1.0) == []
    assert bench.state().status & Status.MOVING
    (end,) = bench.pass_time(4.0)
    assert end == (MoveBlocked(70.0) if is_blocked else PositionReached(70.0))
    assert bench.state().status == 0xE1


def test_a_move_is_announced_carried_out_and_reported() -> None:
    bench = Bench()
    (accepted,) = bench.ask(MovePosition(60.0, 40.0, 100.0))
    expected_s = trapezoid_s(20.0, 40.0, 100.0)
    assert isinstance(accepted, MoveAccepted)
    assert accepted.duration_s == pytest.approx(expected_s, abs=1e-6)
    moving = bench.state()
    assert moving.status & Status.MOVING
    assert moving.velocity_mm_s is not None
    assert moving.velocity_mm_s > 0
    assert bench.pass_time(expected_s) == [PositionReached(60.0)]
    assert bench.state() == StateReply(60.0, 0.0, 0.0, 0xE1, 0)


def test_a_relative_move_counts_from_here() -> None:
    bench = Bench()
    bench.ask(MovePosition(-5.0, is_relative=True))
    assert bench.pass_time(5.0) == [PositionReached(35.0)]


def test_a_timed_move_takes_its_time() -> None:
    bench = Bench()
    (accepted,) = bench.ask(MovePositionTimed(50.0, 80.0, 320.0, 0.5, 4.0))
    assert isinstance(accepted, MoveAccepted)
    assert accepted.duration_s == pytest.approx(4.0, rel=0.01)
    assert bench.pass_time(3.9) == []
    assert bench.pass_time(0.2) == [PositionReached(50.0)]


def test_targets_apply_to_moves_that_name_none() -> None:
    bench = Bench()
    (slow,) = bench.ask(MovePosition(50.0))
    bench.pass_time(10.0)
    for target, value in (
        (Command.SET_TARGET_VELOCITY, 80.0),
        (Command.SET_TARGET_ACCELERATION, 320.0),
    ):
        assert bench.ask(SetTarget(target, value)) == [Accepted(target)]
    (fast,) = bench.ask(MovePosition(40.0))
    assert isinstance(slow, MoveAccepted)
    assert isinstance(fast, MoveAccepted)
    assert slow.duration_s == pytest.approx(trapezoid_s(10.0, 8.3, 32.0), abs=1e-5)
    assert fast.duration_s == pytest.approx(trapezoid_s(10.0, 80.0, 320.0), abs=1e-5)


@pytest.mark.parametrize(
    "command",
    [
        MovePosition(70.5),
        MovePosition(-0.5),
        MovePosition(float("nan")),
        MovePosition(50.0, 84.0),
        MovePosition(50.0, 0.0),
        MovePosition(50.0, 40.0, 321.0),
        MovePosition(50.0, 40.0, 100.0, 2.5),
        MovePositionTimed(50.0, 40.0, 100.0, 1.0, 0.0),
        MoveGrip(-2.5),
        MoveGrip(0.0),
        MoveVelocity(-90.0),
        SetTarget(Command.SET_TARGET_VELOCITY, 84.0),
        SetTarget(Command.SET_TARGET_CURRENT, 0.0),
        GetState(-1.0),
        GetState(0.0, StateMode(0)),
        SetConfig(Register.UNIT_SYSTEM, 0),
    ],
    ids=lambda c: str(c)[:50],
)
def test_a_value_out_of_range_is_refused(command: CommandRecord) -> None:
    bench = Bench()
    (refused,) = bench.ask(command)
    assert isinstance(refused, Refused)
    is_config = isinstance(command, SetConfig)
    assert refused.code == (Code.NO_RIGHTS if is_config else Code.WRONG_PARAMETER)
    assert not bench.state().status & Status.MOVING


@pytest.mark.parametrize("command", [MoveGrip(-0.5), MoveCurrent(-0.5), MoveVelocity(-20.0, 0.5)])
def test_fingers_that_close_on_something_are_blocked_and_hold_it(command: CommandRecord) -> None:
    bench = Bench()
    bench.body.width_mm = 33.0
    (accepted,) = bench.ask(command)
    assert isinstance(accepted, Accepted)
    assert bench.pass_time(5.0) == [MoveBlocked(33.0)]
    state = bench.state()
    assert state.position_mm == 33.0
    assert state.current_a == -0.5
    assert state.status == Status.REFERENCED | Status.MOVE_END


def test_fingers_that_close_on_nothing_run_to_the_soft_limit() -> None:
    bench = Bench()
    bench.ask(MoveGrip(-1.0))
    assert bench.pass_time(6.0) == [ErrorReport(Code.SOFT_LIMIT_LOW)]
    state = bench.state()
    assert state.error == Code.SOFT_LIMIT_LOW
    assert state.status & Status.ERROR
    assert state.position_mm == 0.0
    detail = DetailedError(Command.ERROR, Code.SOFT_LIMIT_LOW, 0.0)
    assert bench.ask(GetDetailedError()) == [detail]


def test_fingers_that_open_without_end_run_to_the_upper_soft_limit() -> None:
    bench = Bench()
    bench.ask(MoveVelocity(20.0))
    assert bench.pass_time(6.0) == [ErrorReport(Code.SOFT_LIMIT_HIGH)]


def test_a_blocked_move_to_a_position_says_so() -> None:
    bench = Bench()
    bench.body.width_mm = 33.0
    bench.ask(MovePosition(20.0))
    assert bench.pass_time(6.0) == [MoveBlocked(33.0)]


def test_stop_ends_a_motion_where_it_is() -> None:
    bench = Bench()
    bench.ask(MovePosition(60.0))
    bench.pass_time(0.5)
    assert bench.ask(Stop()) == [Accepted(Command.STOP)]
    here_mm = bench.state().position_mm
    assert here_mm is not None
    assert 40.0 < here_mm < 60.0
    assert bench.pass_time(10.0) == []
    assert bench.state().position_mm == here_mm


def test_stop_does_not_let_go_of_what_is_held() -> None:
    bench = Bench()
    bench.body.width_mm = 33.0
    bench.ask(MoveGrip(-1.0))
    bench.pass_time(6.0)
    bench.ask(Stop())
    assert bench.state().current_a == -1.0


def test_an_error_is_repeated_every_fifteen_seconds_until_acknowledged() -> None:
    bench = Bench()
    bench.module.raise_error(Code.MOTOR_VOLTAGE_LOW)
    error = ErrorReport(Code.MOTOR_VOLTAGE_LOW)
    assert bench.pass_time(0.0) == []
    assert bench.pass_time(14.0) == [error]
    assert bench.pass_time(30.0) == [error, error]
    assert bench.ask(Acknowledge()) == [Accepted(Command.ACKNOWLEDGE), Info(Code.NO_ERROR)]
    assert bench.pass_time(60.0) == []
    assert bench.state().error == 0


def test_moves_are_refused_while_an_error_is_latched() -> None:
    bench = Bench()
    bench.module.raise_error(Code.TOW)
    bench.pass_time(0.0)
    assert bench.pass_time(1.0) == [ErrorReport(Code.TOW)]
    assert bench.ask(MovePosition(50.0)) == [Refused(Command.MOVE_POSITION, Code.FAILED)]
    assert bench.ask(Reference()) == [Refused(Command.REFERENCE, Code.FAILED)]


def test_an_error_stops_the_motion_under_way() -> None:
    bench = Bench()
    bench.ask(MovePosition(60.0))
    bench.module.raise_error(Code.TOW)
    assert bench.pass_time(1.0) == []
    assert bench.pass_time(0.1) == [ErrorReport(Code.TOW)]
    assert not bench.state().status & Status.MOVING
    assert bench.body.halts


def test_a_lasting_error_cannot_be_acknowledged_before_it_is_cured() -> None:
    bench = Bench()
    bench.module.raise_error(Code.MOTOR_TEMPERATURE, is_lasting=True)
    bench.pass_time(0.1)
    bench.pass_time(0.1)
    error = ErrorReport(Code.MOTOR_TEMPERATURE)
    assert bench.ask(Acknowledge()) == [Accepted(Command.ACKNOWLEDGE), error]
    bench.module.cure()
    assert bench.ask(Acknowledge())[1] == Info(Code.NO_ERROR)


def test_a_warning_is_repeated_every_thirty_seconds_and_forbids_nothing() -> None:
    bench = Bench()
    bench.module.raise_warning(Code.TEMPERATURE_HIGH)
    bench.pass_time(0.0)
    warning = WarningReport(Code.TEMPERATURE_HIGH)
    assert bench.pass_time(61.0) == [warning] * 3
    state = bench.state()
    assert state.status & Status.WARNING
    assert state.error == Code.TEMPERATURE_HIGH
    assert isinstance(bench.ask(MovePosition(50.0))[0], MoveAccepted)
    bench.module.cure()
    bench.pass_time(5.0)
    assert bench.pass_time(60.0) == []
    assert bench.state().error == 0


def test_an_emergency_stop_stops_and_locks_until_acknowledged() -> None:
    bench = Bench()
    bench.ask(MovePosition(60.0))
    said = bench.ask(EmergencyStop())
    assert said == [Accepted(Command.EMERGENCY_STOP), ErrorReport(Code.EMERGENCY_STOP)]
    assert bench.ask(MovePosition(50.0)) == [Refused(Command.MOVE_POSITION, Code.FAILED)]
    bench.ask(Acknowledge())
    assert isinstance(bench.ask(MovePosition(50.0))[0], MoveAccepted)


def test_without_impulses_nothing_is_said_unasked() -> None:
    bench = Bench()
    assert bench.ask(ToggleImpulses()) == [ImpulsesSwitched(False)]
    bench.ask(MovePosition(60.0))
    assert bench.pass_time(10.0) == []
    bench.module.raise_error(Code.TOW)
    assert bench.pass_time(60.0) == []
    assert bench.state().error == Code.TOW
    assert bench.ask(ToggleImpulses()) == [ImpulsesSwitched(True)]


def test_a_cyclic_state_comes_until_the_state_is_asked_once() -> None:
    bench = Bench()
    first = bench.ask(GetState(0.1, StateMode.POSITION), StateMode.POSITION)
    assert len(first) == 1
    assert len(bench.pass_time(0.96, StateMode.POSITION)) == 10
    bench.ask(GetState(0.0, StateMode.POSITION), StateMode.POSITION)
    bench.pass_time(0.1, StateMode.POSITION)
    assert bench.pass_time(1.0) == []


def test_a_state_holds_only_what_was_asked() -> None:
    bench = Bench()
    mode = StateMode.VELOCITY | StateMode.CURRENT
    (state,) = bench.ask(GetState(0.0, mode), mode)
    assert isinstance(state, StateReply)
    assert state.position_mm is None
    assert state.velocity_mm_s == 0.0


def test_who_it_is_and_its_registers_can_be_asked() -> None:
    bench = Bench()
    (identity,) = bench.ask(GetConfig())
    assert isinstance(identity, Identity)
    assert identity.kind == "PG070"
    module_id = RegisterValue(Register.MODULE_ID, 12)
    assert bench.ask(GetConfig(Register.MODULE_ID)) == [module_id]
    assert bench.ask(GetConfig(0x7F)) == [Refused(Command.GET_CONFIG, Code.WRONG_PARAMETER)]


def test_registers_are_written_by_whoever_has_the_rights() -> None:
    bench = Bench()
    write = SetConfig(Register.SOFT_LIMIT_HIGH, 65.0)
    assert bench.ask(write) == [Refused(Command.SET_CONFIG, Code.NO_RIGHTS)]
    assert bench.ask(ChangeUser("wrong")) == [UserChanged(0)]
    assert bench.ask(ChangeUser("profi")) == [UserChanged(2)]
    assert bench.ask(write) == [RegisterWritten(Register.SOFT_LIMIT_HIGH)]
    assert bench.ask(MovePosition(66.0)) == [Refused(Command.MOVE_POSITION, Code.WRONG_PARAMETER)]
    serial = SetConfig(Register.SERIAL_NUMBER, 1)
    assert bench.ask(serial) == [Refused(Command.SET_CONFIG, Code.NO_RIGHTS)]


def test_the_unit_system_changes_every_length_on_the_line() -> None:
    bench = Bench()
    bench.ask(ChangeUser("profi"))
    bench.ask(SetConfig(Register.UNIT_SYSTEM, 1))
    assert bench.state().position_mm == pytest.approx(0.040)
    bench.ask(MovePosition(0.060, 0.080, 0.320))
    (reached,) = bench.pass_time(1.0)
    assert isinstance(reached, PositionReached)
    assert reached.position_mm == pytest.approx(0.060)
    assert bench.body.opening_mm(bench.now_s) == pytest.approx(60.0, abs=1e-4)
    (limit,) = bench.ask(GetConfig(Register.SOFT_LIMIT_HIGH))
    assert isinstance(limit, RegisterValue)
    assert limit.value == pytest.approx(0.070)
    integers = SetConfig(Register.UNIT_SYSTEM, 6)
    assert bench.ask(integers) == [Refused(Command.SET_CONFIG, Code.WRONG_PARAMETER)]


def test_a_new_module_id_is_answered_from_then_on() -> None:
    bench = Bench()
    bench.ask(ChangeUser("profi"))
    bench.ask(SetConfig(Register.MODULE_ID, 13))
    assert bench.ask(GetState()) == []
    bench.module.receive(encode_command(13, GetState()), bench.now_s)
    assert len(bench.pass_time(0.1)) == 1


def test_the_link_self_test_goes_both_ways() -> None:
    bench = Bench()
    assert bench.ask(SendTestValues()) == [KnownValues(TEST_VALUES)]
    assert bench.ask(CheckTestValues(TEST_VALUES)) == [KnownValuesChecked(0)]
    wrong = Refused(Command.CHECK_TEST_VALUES, Code.WRONG_PARAMETER)
    assert bench.ask(CheckTestValues(TEST_VALUES[:-1] + b"\x00")) == [wrong]


def test_a_reboot_is_accepted_and_forgets_the_reference() -> None:
    bench = Bench()
    assert bench.ask(Reboot()) == [Accepted(Command.REBOOT)]
    assert bench.pass_time(1.0) == [Info(Code.BOOT)]
    assert bench.ask(MovePosition(50.0)) == [Refused(Command.MOVE_POSITION, NOT_REFERENCED)]


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (bytes.fromhex("05 0C 01 92 40 F3"), Code.CHECKSUM),
        (encode_frame(Frame(0x05, 12, 0x77)), Code.UNKNOWN_COMMAND),
        (encode_frame(Frame(0x05, 12, 0x92, b"\x00")), Code.MESSAGE_LENGTH),
    ],
)
def test_a_request_that_is_none_is_refused_with_its_code(data: bytes, code: Code) -> None:
    bench = Bench()
    bench.module.receive(data, bench.now_s)
    (refused,) = bench.pass_time(0.05)
    assert refused == Refused(data[3], code)


def test_half_a_request_is_given_up_after_a_gap() -> None:
    bench = Bench()
    data = encode_command(12, GetState())
    bench.module.receive(data[:3], bench.now_s)
    bench.pass_time(1.0)
    assert len(bench.ask(GetState())) == 1


def test_a_request_in_pieces_is_put_together() -> None:
    bench = Bench()
    for byte in encode_command(12, GetState()):
        bench.module.receive(bytes((byte,)), bench.now_s)
        bench.now_s += SETTINGS.byte_s
    assert len(bench.pass_time(0.05)) == 1


def test_power_lost_in_a_motion_halts_the_fingers() -> None:
    bench = Bench()
    bench.ask(MovePosition(60.0))
    bench.body.has_power = False
    assert bench.pass_time(0.1) == []
    assert bench.body.halts
    assert bench.module.next_output_s() is None


def test_a_corrupted_reply_and_a_cut_wire_can_be_ordered() -> None:
    bench = Bench()
    bench.module.corrupt_next_reply()
    assert bench.ask(GetState()) == []
    assert len(bench.ask(GetState())) == 1
    bench.module.go_silent()
    assert bench.ask(GetState()) == []
    bench.module.speak_again()
    assert len(bench.ask(GetState())) == 1


def test_refusals_begin_as_the_settings_say() -> None:
    bench = Bench(SchunkModuleSettings(refusal_group=0x07), is_referenced=False)
    bench.say(MovePosition(10.0))
    bench.now_s += 0.05
    assert bench.module.transmit(bench.now_s) == bytes.fromhex("07 0C 02 B0 06 E2 92")
