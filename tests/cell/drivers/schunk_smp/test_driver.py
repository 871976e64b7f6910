import pytest

from cell.clock import SimulatedClock
from cell.drivers.schunk_smp.command_codec import encode_command
from cell.drivers.schunk_smp.commands import (
    ChangeUser,
    CommandRecord,
    GetConfig,
    SetConfig,
    ToggleImpulses,
)
from cell.drivers.schunk_smp.conversation import Conversation
from cell.drivers.schunk_smp.framing import Frame, encode_frame
from cell.drivers.schunk_smp.replies import (
    Accepted,
    ErrorReport,
    ImpulsesSwitched,
    Info,
    MoveBlocked,
    PositionReached,
    Refused,
    Reply,
)
from cell.drivers.schunk_smp.reply_codec import encode_reply
from cell.drivers.schunk_smp.requests import ModuleRequests
from cell.drivers.schunk_smp.scan import FoundModule, find_modules
from cell.drivers.schunk_smp.settings import SchunkSettings
from cell.drivers.schunk_smp.tables import Code, Command, Register
from cell.errors import DeviceError, DeviceTimeout, LinkError, Stopped
from cell.links.base import Direction
from cell.links.scripted import ScriptedLink
from cell.profile import load_profile
from cell.twin.emulators.schunk_smp import SchunkModuleSettings
from tests.cell.drivers.schunk_smp.bench import GripperBench


def said(*replies: Reply) -> bytes:
    return b"".join(encode_reply(12, reply) for reply in replies)


def test_opening_waits_for_the_boot_references_and_says_who_is_there() -> None:
    bench = GripperBench(is_referenced=False)
    identity = bench.gripper.open()
    assert "PG070" in identity
    assert "id 12" in identity
    assert bench.gripper.read_state().is_referenced
    assert bench.commands().count(Command.REFERENCE) == 1


def test_opening_a_referenced_gripper_does_not_move_it() -> None:
    bench = GripperBench()
    bench.gripper.open()
    assert Command.REFERENCE not in bench.commands()
    assert bench.gripper.read_state().position_mm == 40.0


def test_opening_twice_sends_nothing_the_second_time() -> None:
    bench = GripperBench().opened()
    assert "PG070" in bench.gripper.open()
    assert bench.commands() == []


def test_opening_says_that_the_driver_was_never_tried() -> None:
    assert "never tried" in GripperBench().opened().warnings[0]
    tried = SchunkSettings(was_tried_on_hardware=True)
    assert GripperBench(settings=tried).opened().warnings == []


def test_opening_clears_an_error() -> None:
    bench = GripperBench()
    bench.module.raise_error(Code.TOW)
    bench.gripper.open()
    assert not bench.gripper.read_state().has_error


def test_opening_fails_on_an_error_that_stays_and_names_it() -> None:
    bench = GripperBench()
    bench.module.raise_error(Code.MOTOR_VOLTAGE_LOW, is_lasting=True)
    with pytest.raises(DeviceError, match=r"motor voltage too low \(error 116\); check") as caught:
        bench.gripper.open()
    assert caught.value.code == Code.MOTOR_VOLTAGE_LOW


def test_opening_without_power_names_the_likely_cause() -> None:
    bench = GripperBench()
    bench.body.has_power = False
    with pytest.raises(DeviceTimeout, match="no answer.*is the gripper's power output on"):
        bench.gripper.open()
    assert bench.clock.now_s() - 50.0 < 8.0


def test_opening_refuses_a_unit_system_other_than_millimetres() -> None:
    bench = GripperBench()
    bench.wire.write(encode_command(12, ChangeUser("profi")))
    bench.wire.write(encode_command(12, SetConfig(Register.UNIT_SYSTEM, 1)))
    with pytest.raises(DeviceError, match="unit system is metre, not millimetre"):
        bench.gripper.open()


@pytest.mark.parametrize("are_on", [True, False])
def test_opening_leaves_impulses_on_however_they_were(are_on: bool) -> None:
    bench = GripperBench()
    if not are_on:
        bench.wire.write(encode_command(12, ToggleImpulses()))
        bench.wire.read(0.1)
    bench.opened()
    bench.gripper.move_to(60.0)
    assert bench.commands().count(Command.GET_STATE) == 1


def test_moving_stands_at_the_opening_when_it_returns() -> None:
    bench = GripperBench().opened()
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0
    state = bench.gripper.read_state()
    assert not state.is_moving
    assert state.velocity_mm_s == 0.0


def test_moving_uses_speed_and_acceleration_of_the_settings() -> None:
    slow = SchunkSettings(speed_mm_s=10.0)
    fast = SchunkSettings(speed_mm_s=80.0)
    durations = []
    for settings in (slow, fast):
        bench = GripperBench(settings=settings).opened()
        begin_s = bench.clock.now_s()
        bench.gripper.move_to(60.0)
        durations.append(bench.clock.now_s() - begin_s)
    assert durations[0] == pytest.approx(20 / 10 + 10 / 200, abs=0.05)
    assert durations[1] == pytest.approx(2 * (20 / 200) ** 0.5, abs=0.05)


@pytest.mark.parametrize("opening_mm", [-0.1, 70.1, float("nan")])
def test_moving_out_of_reach_sends_nothing_and_names_the_nearest(opening_mm: float) -> None:
    bench = GripperBench().opened()
    with pytest.raises(DeviceError, match=r"out of reach; allowed are 0.0 to 70.0 mm"):
        bench.gripper.move_to(opening_mm)
    assert bench.wire.sent == []


def test_moving_against_something_tells_where_it_stopped() -> None:
    bench = GripperBench().opened()
    bench.body.width_mm = 33.0
    with pytest.raises(DeviceError, match=r"blocked at 33.0 mm on the way to 20.0 mm"):
        bench.gripper.move_to(20.0)


def test_gripping_something_holds_it_and_measures_it() -> None:
    bench = GripperBench().opened()
    bench.body.width_mm = 33.0
    result = bench.gripper.grip(1.0)
    assert result.is_holding
    assert result.width_mm == 33.0
    assert bench.gripper.read_state().current_a == -1.0
    bench.gripper.move_to(60.0)


def test_gripping_nothing_is_told_and_leaves_no_error() -> None:
    bench = GripperBench().opened()
    result = bench.gripper.grip(1.0)
    assert not result.is_holding
    assert result.width_mm == 0.0
    assert not bench.gripper.read_state().has_error
    bench.gripper.move_to(60.0)


def test_gripping_closes_whatever_the_sign_of_the_current() -> None:
    opening = SchunkSettings(closing_sign=1.0)
    bench = GripperBench(settings=opening).opened()
    with pytest.raises(DeviceError, match="upper soft limit"):
        bench.gripper.grip(1.0)


@pytest.mark.parametrize("current_a", [0.0, -1.0, 2.5, float("nan")])
def test_gripping_with_a_current_out_of_range_sends_nothing(current_a: float) -> None:
    bench = GripperBench().opened()
    with pytest.raises(DeviceError, match="allowed is above 0 up to 2 A"):
        bench.gripper.grip(current_a)
    assert bench.wire.sent == []


def test_a_fault_while_gripping_is_raised_with_its_advice() -> None:
    bench = GripperBench().opened()
    bench.module.raise_error(Code.TOW, is_lasting=True)
    with pytest.raises(DeviceError, match="acknowledge errors"):
        bench.gripper.grip(1.0)


def test_a_fault_while_moving_is_raised_with_its_advice() -> None:
    bench = GripperBench().opened()
    bench.wire.after_next_request = said(ErrorReport(Code.CURRENT))
    with pytest.raises(DeviceError, match=r"motor current too high \(error 222\); look for"):
        bench.gripper.move_to(60.0)


LATE = [
    said(PositionReached(12.0)),
    said(MoveBlocked(33.0)),
    said(Info(Code.NO_ERROR)),
    bytes.fromhex("07 0C 07 95 36 89 81 3F 02 00 00 00"),
    said(PositionReached(40.0), MoveBlocked(12.0), Info(Code.BOOT)),
    bytes.fromhex("00 FF 07 0C"),
    bytes.fromhex("07 0C 03 92 4F 4B C4 18"),
]


@pytest.mark.parametrize("late", LATE, ids=lambda data: data.hex(" "))
def test_what_is_said_late_is_not_taken_for_the_answer_or_the_end(late: bytes) -> None:
    bench = GripperBench().opened()
    bench.wire.after_next_request = late
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


@pytest.mark.parametrize("late", LATE, ids=lambda data: data.hex(" "))
def test_what_is_said_late_does_not_end_a_grip(late: bytes) -> None:
    bench = GripperBench().opened()
    bench.body.width_mm = 33.0
    bench.wire.after_next_request = late
    assert bench.gripper.grip(1.0).is_holding


def test_a_cyclic_state_between_request_and_answer_does_no_harm() -> None:
    bench = GripperBench().opened()
    bench.wire.write(bytes.fromhex("05 0C 06 95 CD CC CC 3D 07 C7 ED"))
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


def test_a_lost_end_of_a_motion_is_found_by_asking() -> None:
    bench = GripperBench().opened()
    bench.wire.lost = said(PositionReached(60.0))
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


def test_a_lost_end_of_a_grip_is_found_by_asking() -> None:
    bench = GripperBench().opened()
    bench.body.width_mm = 33.0
    bench.wire.lost = said(MoveBlocked(33.0))
    assert bench.gripper.grip(1.0).is_holding


def test_a_lost_error_of_an_empty_grip_is_found_by_asking() -> None:
    bench = GripperBench().opened()
    bench.wire.lost = said(ErrorReport(Code.SOFT_LIMIT_LOW))
    assert not bench.gripper.grip(1.0).is_holding


def test_a_damaged_answer_is_asked_for_again() -> None:
    bench = GripperBench().opened()
    bench.module.corrupt_next_reply()
    assert bench.gripper.read_state().position_mm == 40.0
    assert bench.commands() == [Command.GET_STATE] * 2


def test_a_damaged_request_is_sent_again() -> None:
    bench = GripperBench().opened()
    bench.wire.after_next_request = said(Refused(Command.GET_STATE, Code.CHECKSUM))
    assert bench.gripper.read_state().position_mm == 40.0
    assert bench.commands() == [Command.GET_STATE] * 2


def test_a_module_that_falls_silent_is_a_time_out_in_every_operation() -> None:
    operations = ("read_state", "stop", "acknowledge", "emergency_stop", "reference")
    for name in operations:
        bench = GripperBench().opened()
        bench.module.go_silent()
        with pytest.raises(DeviceTimeout, match="is the gripper's power output on"):
            getattr(bench.gripper, name)()
    bench = GripperBench().opened()
    bench.module.go_silent()
    with pytest.raises(DeviceTimeout):
        bench.gripper.move_to(60.0)


def test_power_lost_in_a_motion_is_a_time_out() -> None:
    bench = GripperBench(settings=SchunkSettings(speed_mm_s=5.0)).opened()
    bench.gripper.move_to(45.0)
    bench.body.has_power = False
    with pytest.raises(DeviceTimeout):
        bench.gripper.move_to(60.0)


def test_a_move_before_referencing_is_refused_in_the_tables_words() -> None:
    bench = GripperBench().opened()
    bench.body.has_power = False
    bench.wire.read(0.1)
    bench.body.has_power = True
    bench.wire.read(0.1)
    bench.wire.read(1.0)
    with pytest.raises(DeviceError, match=r"not referenced \(error 6\); reference") as caught:
        bench.gripper.move_to(60.0)
    assert caught.value.code == Code.NOT_REFERENCED


def test_an_emergency_stop_locks_until_acknowledged() -> None:
    bench = GripperBench().opened()
    bench.gripper.emergency_stop()
    assert bench.gripper.read_state().error_text == "emergency stop"
    with pytest.raises(DeviceError, match="acknowledge"):
        bench.gripper.move_to(60.0)
    bench.gripper.acknowledge()
    bench.gripper.move_to(60.0)


def test_stopping_returns_with_the_fingers_standing() -> None:
    bench = GripperBench().opened()
    bench.wire.write(bytes.fromhex("05 0C 05 B0 00 00 0A 42 CB 21"))
    bench.wire.read(0.1)
    bench.gripper.stop()
    assert not bench.gripper.read_state().is_moving
    assert bench.body.opening_mm(bench.clock.now_s()) == pytest.approx(40.0, abs=0.5)


def test_waiting_for_a_position_ends_there_or_says_where_it_is() -> None:
    bench = GripperBench().opened()
    bench.wire.write(bytes.fromhex("05 0C 05 B0 00 00 0A 42 CB 21"))
    bench.gripper.wait_for_position(34.5, timeout_s=5.0)
    begin_s = bench.clock.now_s()
    with pytest.raises(DeviceTimeout, match=r"at 34.5 mm instead of 50.0 mm after 2 s"):
        bench.gripper.wait_for_position(50.0, timeout_s=2.0)
    assert bench.clock.now_s() - begin_s == pytest.approx(2.0, abs=0.2)


def test_waiting_for_a_stop_returns_the_state_there() -> None:
    bench = GripperBench().opened()
    bench.wire.write(bytes.fromhex("05 0C 05 B0 00 00 0A 42 CB 21"))
    state = bench.gripper.wait_for_stop(timeout_s=5.0)
    assert state.position_mm == 34.5
    assert not state.is_moving


def test_waiting_for_a_stop_that_does_not_come_is_a_time_out() -> None:
    bench = GripperBench(settings=SchunkSettings(speed_mm_s=1.0)).opened()
    bench.wire.write(bytes.fromhex("05 0C 05 B0 00 00 0A 42 CB 21"))
    with pytest.raises(DeviceTimeout, match="still moving after 0.5 s"):
        bench.gripper.wait_for_stop(timeout_s=0.5)


def test_a_stop_that_somebody_asks_for_ends_a_motion() -> None:
    bench = GripperBench().opened()
    bench.token.stop("the technician pressed stop")
    with pytest.raises(Stopped, match="the technician"):
        bench.gripper.move_to(60.0)
    assert Command.STOP in bench.commands()
    bench.token.clear()
    assert not bench.gripper.read_state().is_moving


def test_a_motion_that_never_ends_is_stopped_and_told() -> None:
    bench = GripperBench(is_referenced=False, module=SchunkModuleSettings(reference_settle_s=99.0))
    with pytest.raises(DeviceTimeout, match=r"referencing did not end within 30.0 s; stopped"):
        bench.gripper.open()


@pytest.mark.parametrize("is_blocked", [True, False])
def test_referencing_may_end_with_either_impulse(is_blocked: bool) -> None:
    settings = SchunkModuleSettings(reference_is_blocked=is_blocked)
    bench = GripperBench(is_referenced=False, module=settings)
    bench.gripper.open()
    assert bench.gripper.read_state().is_referenced


def test_closing_stops_the_fingers_and_may_be_repeated() -> None:
    bench = GripperBench().opened()
    bench.wire.write(bytes.fromhex("05 0C 05 B0 00 00 0A 42 CB 21"))
    bench.gripper.close()
    assert bench.body.halts
    bench.wire.sent.clear()
    bench.gripper.close()
    assert bench.wire.sent == []


def test_closing_what_was_never_opened_sends_nothing() -> None:
    bench = GripperBench()
    bench.gripper.close()
    assert bench.wire.sent == []


def test_closing_after_an_opening_that_failed_still_stops() -> None:
    bench = GripperBench(is_referenced=False, module=SchunkModuleSettings(reference_settle_s=99.0))
    with pytest.raises(DeviceTimeout):
        bench.gripper.open()
    bench.wire.sent.clear()
    bench.gripper.close()
    assert bench.commands()[0] == Command.STOP


def test_a_closed_gripper_opens_again_even_after_a_power_cycle() -> None:
    bench = GripperBench().opened()
    bench.gripper.close()
    bench.body.has_power = False
    bench.wire.read(0.1)
    bench.body.has_power = True
    bench.gripper.open()
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


def test_a_link_that_is_gone_is_an_error_of_the_link() -> None:
    bench = GripperBench().opened()
    bench.wire.close()
    with pytest.raises(LinkError, match="closed"):
        bench.gripper.read_state()


def test_closing_a_gripper_without_power_only_warns() -> None:
    bench = GripperBench().opened()
    bench.body.has_power = False
    bench.gripper.close()
    assert "closed all the same" in bench.warnings[-1]


def test_the_modules_on_a_line_are_found_by_asking() -> None:
    bench = GripperBench()
    found = find_modules(bench.wire, bench.clock, ids=range(10, 15))
    assert found == [FoundModule(12, "PG070", 150)]
    assert len(bench.wire.sent) == 5


def test_the_settings_come_from_the_profile() -> None:
    profile = load_profile("mash").gripper
    settings = SchunkSettings.from_profile(profile)
    assert settings.module_id == profile.module_id
    assert settings.stroke_mm == profile.stroke_mm
    module = SchunkModuleSettings.from_profile(profile)
    assert module.byte_s == pytest.approx(12 / 38400)


def ask(command: CommandRecord) -> tuple[Direction, bytes]:
    return ("to_device", encode_command(12, command))


def test_an_answer_of_another_kind_is_told() -> None:
    odd = encode_frame(Frame(0x07, 12, Command.GET_CONFIG, b"\x01\x0c"))
    link = ScriptedLink("gripper", [ask(GetConfig(None)), ("from_device", odd)])
    clock = SimulatedClock()
    conversation = Conversation(link, clock, device="gripper", module=12)
    with pytest.raises(DeviceError, match="answered RegisterValue to GetConfig"):
        ModuleRequests(conversation, SchunkSettings()).identity()
    assert link.is_exhausted


def test_impulses_that_stay_off_are_told() -> None:
    off: tuple[Direction, bytes] = ("from_device", said(ImpulsesSwitched(False)))
    link = ScriptedLink("gripper", [ask(ToggleImpulses()), off, ask(ToggleImpulses()), off])
    conversation = Conversation(link, SimulatedClock(), device="gripper", module=12)
    with pytest.raises(DeviceError, match="cannot be switched on"):
        ModuleRequests(conversation, SchunkSettings()).switch_impulses_on()


def test_a_grip_whose_answer_is_lost_is_not_started_twice() -> None:
    bench = GripperBench().opened()
    bench.body.width_mm = 33.0
    bench.wire.lost = said(Accepted(Command.MOVE_GRIP))
    assert bench.gripper.grip(1.0).is_holding
    assert bench.commands().count(Command.MOVE_GRIP) == 1


def test_a_move_whose_answer_is_damaged_is_not_started_twice() -> None:
    bench = GripperBench().opened()
    bench.module.corrupt_next_reply()
    bench.gripper.move_to(60.0)
    assert bench.commands().count(Command.MOVE_POSITION) == 1
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


def test_a_move_that_was_never_heard_is_sent_again_once_the_fingers_are_known_to_stand() -> None:
    bench = GripperBench().opened()
    write = bench.wire.write
    deaf: list[bytes] = []

    def deaf_once(data: bytes) -> None:
        if data[3] == Command.MOVE_POSITION and not deaf:
            deaf.append(data)
            return
        write(data)

    bench.wire.write = deaf_once  # type: ignore[method-assign]
    bench.gripper.move_to(60.0)
    assert deaf
    assert bench.commands() == [
        Command.GET_STATE,
        Command.MOVE_POSITION,
        Command.GET_STATE,
    ]
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0


def test_impulses_are_on_though_the_answer_to_switching_them_was_lost() -> None:
    bench = GripperBench()
    bench.module.corrupt_next_reply(3)
    bench.gripper.open()
    bench.gripper.move_to(60.0)
    assert bench.body.opening_mm(bench.clock.now_s()) == 60.0
