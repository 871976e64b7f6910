"""The controller spoken to by hand: states, refusals, delays."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cell.drivers.melfa_r3.codec import decode_reply
from cell.drivers.melfa_r3.tables import COMMANDS
from cell.twin.emulators.melfa_r3 import ControllerSettings, MelfaController
from tests.contracts.arm.rig import (
    CONTROLLER_SETTINGS,
    KINEMATICS,
    PROFILE,
    ArmRig,
    FakeBody,
    opened_rig,
)

POSE = "(490,-65,98,180,0,180)(7,0)"


def _ready() -> ArmRig:
    rig = opened_rig()
    assert rig.say("DSTATE") == "QoKA1060;1;0"
    return rig


def test_an_idle_controller_reports_the_observed_state() -> None:
    rig = _ready()
    assert rig.say("STATE") == "QoK1;0;100;00;A1060;1;01;;;;;;;;1;REP;START;1;0"


def test_a_moving_controller_reports_the_run_bit_and_owns_the_mechanism() -> None:
    rig = _ready()
    rig.say(f"EXECP1={POSE}")
    assert rig.say("EXECMVS P1") == "QoK"
    assert rig.say("DSTATE") == "QoKE1000;1;1"
    assert rig.say("STATE").endswith("START;1;1")


def test_the_identity_has_the_observed_fields() -> None:
    reply = ArmRig().say("OPEN=TOOLBOX")
    assert reply.startswith("QoK3F;3F;7,0;3,5,A,1E,32,46,64;MB5;PRM;RV-6SDL;CRnD-7xx;MELFA;")
    assert reply.endswith(";1;3;8;")


def test_positions_are_printed_as_observed() -> None:
    rig = _ready()
    assert rig.say("PPOSF") == (
        "QoKX;510.00;Y;-65.00;Z;98.00;A;180.00;B;0.00;C;180.00;;7,0;100;0.00;00000000"
    )
    assert rig.say("PPOSX") == "QoKX;510.00;;7,0;100;0.00;00000000"
    assert rig.say("JPOSF").endswith(";;****,****;100;0.00;00000000")


def test_everything_but_opening_and_stopping_is_refused_before_open() -> None:
    for command in sorted(COMMANDS):
        reply = ArmRig().say(command)
        is_allowed = command in {"OPEN", "STOP", "RSTALRM", "SRVOFF"}
        assert (reply[:3] == "QoK") == is_allowed, command
        if not is_allowed:
            assert reply == "QeR5000"


@pytest.mark.parametrize(
    "text",
    ["SRVON", "OVRD=50", "EXECSPD 10", "HNDON1", "HNDOFF1", "RUN", "RSTPRG", "SLOTINIT",
     "PRGLOAD=1", "OUT=8;0001", "MOVSP"],
)  # fmt: skip
def test_what_changes_something_needs_the_operation_right(text: str) -> None:
    rig = ArmRig()
    rig.say("OPEN=X")
    assert rig.say(text) == "QeR5020"
    rig.say("CNTLON")
    assert rig.say(text) != "QeR5020"


@pytest.mark.parametrize(
    "text", ["OVRD", "HNDSTS", "PPOSF", "JPOSF", "STATE", "DSTATE", "STPSIG", "STOP", "RSTALRM",
             "SRVOFF", "ERROR", "ERRORMES60", "ERRORRD", "IN0", "OUT0", "IOSIGNAL0;0",
             "VALM_SVO", "PNRMEJAR", "PARMEJAR", "PDIR<", "CNTLOFF", "CLOSE"],
)  # fmt: skip
def test_reading_and_stopping_need_no_right(text: str) -> None:
    rig = ArmRig()
    rig.say("OPEN=X")
    assert rig.say(text)[:3] == "QoK"


REFUSALS = [
    ("a statement that is none", "EXECDANCE", "QeR4220"),
    ("a command that is none", "NONSENSE", "QeR4200"),
    ("a variable that was never assigned", "EXECMOV P9", "QeR4330"),
    ("a joint variable that was never assigned", "EXECMOV J9", "QeR4330"),
    ("too few joints", "EXECJ1=(1,2,3)", "QeR3120"),
    ("an override beyond its range", "OVRD=101", "QeR3110"),
    ("an override that is no number", "OVRD=fast", "QeR3810"),
    ("a speed beyond its range", "EXECSPD 0", "QeR3110"),
    ("a hand that is not there", "HNDON9", "QeR3110"),
    ("an output that is not there", "EXECM_OUT(99999)=1", "QeR3110"),
    ("signals that are not there", "OUT32760", "QeR3110"),
    ("signals without a value", "OUT=8", "QeR3120"),
    ("signals with a wrong value", "OUT=8;xyz1", "QeR3810"),
    ("signals with three digits", "OUT=8;001", "QeR3810"),
    ("one number for two signals", "IOSIGNAL0", "QeR3120"),
    ("a program that is not there", "PRGLOAD=NONE", "QeR4340"),
    ("a parameter that is not there", "PNRNONE", "QeR4350"),
    ("a variable write that is none", "VAL=MOV P1", "QeR4220"),
    ("a variable write that cannot be read", "VAL=P1=5", "QeR4220"),
    ("a target out of reach", "EXECP1=(2000,0,98,180,0,180)(7,0)|EXECMVS P1", "Qer2602"),
    ("a flange too low", "EXECP1=(510,-65,-110,180,0,180)(7,0)|EXECMVS P1", "Qer2602"),
    ("a posture that is none", "EXECP1=(490,-65,98,180,0,180)(9,0)|EXECMVS P1", "Qer2800"),
    ("a turn beyond the limit of J6", "EXECP1=(490,-65,98,180,0,180)(7,1048576)|EXECMOV P1",
     "Qer2602"),
    ("a joint beyond its limit", "EXECJ1=(0,0,90,0,101,0)|EXECMOV J1", "Qer2602"),
    ("joints with the flange too low", "EXECJ1=(0,120,60,0,-90,0)|EXECMOV J1", "Qer2602"),
    ("a way that leaves the reach", "EXECP1=(-450,255,98,180,0,180)(7,0)|EXECMVS P1", "Qer2603"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "reply"), [r[1:] for r in REFUSALS], ids=[r[0] for r in REFUSALS])
def test_a_request_that_cannot_be_done_is_refused_with_its_number(text: str, reply: str) -> None:
    rig = _ready()
    before = rig.body.joints_deg(rig.clock.now_s())
    *first, last = text.split("|")
    for request in first:
        assert rig.say(request) == "QoK"
    assert rig.say(last) == reply
    assert rig.body.joints_deg(rig.clock.now_s()) == before
    if reply.startswith("Qer"):
        assert rig.say("ERROR") == f"Qok{reply[3:]};L"
        assert rig.say("EXECM_OUT(1)=1") == "Qer5600"
        assert rig.say("RSTALRM") == "QoK"
    assert rig.say("ERROR") == "QoK"


def test_a_statement_without_a_program_in_the_slot_is_refused() -> None:
    rig = ArmRig()
    for request in ("OPEN=X", "CNTLON", "SRVON"):
        assert rig.say(request).startswith("QoK")
    assert rig.say("EXECSPD 10") == "QeR5050"
    assert rig.say("RUN") == "QeR5630"
    rig.link.write(b"1;9;EXECSPD 10\r")
    assert rig.link.read(1.0) == b"QoK\r", "the edit slot needs no program"
    rig.clock.sleep(2.0)
    assert rig.say("RUN") == "QeR5050"


def test_a_move_without_servos_is_refused() -> None:
    rig = _ready()
    rig.say("SRVOFF")
    assert rig.say("EXECMOV J_CURR") == "QeR5630"
    assert rig.say("MOVSP") == "QeR5630"


def test_servos_need_their_time() -> None:
    rig = _ready()
    rig.say("SRVOFF")
    assert rig.say("SRVON") == "QoK"
    assert rig.say("DSTATE") == "QoK81060;1;0"
    assert rig.say("EXECMOV J_CURR") == "QeR5630"
    rig.clock.sleep(1.0)
    assert rig.say("SRVON") == "QoK"
    assert rig.say("DSTATE") == "QoKA1060;1;0"


@pytest.mark.parametrize(
    "text", ["EXECMVS P1", "EXECM_OUT(8)=1", "MOVSP", "RUN", "RSTPRG", "PRGLOAD=1"]
)
def test_a_moving_controller_is_busy(text: str) -> None:
    rig = _ready()
    rig.say(f"EXECP1={POSE}")
    rig.say("EXECMVS P1")
    assert rig.say(text) == "QeR5640"
    rig.clock.sleep(1.0)
    assert rig.say(text) == "QoK"


@pytest.mark.parametrize("robot", ["3", "99"])
def test_a_robot_that_is_not_there_is_refused(robot: str) -> None:
    rig = ArmRig()
    rig.link.write(f"{robot};1;OPEN=X\r".encode())
    assert rig.link.read(1.0) == b"QeR3110\r"


def test_closing_gives_the_right_back() -> None:
    rig = _ready()
    rig.say("CLOSE")
    rig.say("OPEN=X")
    assert rig.say("EXECSPD 10") == "QeR5020"


def test_the_panel_and_teach_keep_the_right_from_a_client() -> None:
    rig = ArmRig()
    rig.say("OPEN=X")
    rig.controller.hold_right_by_panel(0.0, is_held=True)
    assert rig.say("CNTLON") == "QeR5030"
    rig.controller.hold_right_by_panel(0.0, is_held=False)
    rig.controller.set_key_switch(0.0, is_automatic=False)
    assert rig.say("CNTLON") == "QeR5010"
    assert rig.say("DSTATE") == "QoK09060;1;0"
    rig.controller.set_key_switch(0.0, is_automatic=True)
    assert rig.say("CNTLON") == "QoK"


def test_an_emergency_stop_latches_until_release_and_reset() -> None:
    rig = _ready()
    rig.controller.press_emergency_stop(rig.clock.now_s())
    assert rig.say("ERROR") == "Qok0060;H"
    assert rig.say("DSTATE") == "Qok810760;1;0"
    assert rig.say("SRVON") == "Qer5130"
    assert rig.say("RSTALRM") == "Qok"
    assert rig.say("ERROR") == "Qok0060;H"
    rig.controller.release_emergency_stop(rig.clock.now_s())
    assert rig.say("SRVON") == "Qer5130"
    assert rig.say("RSTALRM") == "QoK"
    assert rig.say("SRVON") == "QoK"


def test_an_emergency_stop_halts_the_arm_where_it_is() -> None:
    rig = _ready()
    rig.say("EXECP1=(510,200,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    rig.clock.sleep(0.5)
    here = rig.body.joints_deg(rig.clock.now_s())
    rig.controller.press_emergency_stop(rig.clock.now_s())
    rig.clock.sleep(1.0)
    assert rig.body.joints_deg(rig.clock.now_s()) == here


@pytest.mark.parametrize(
    ("number", "keeps_servos", "goes_on"),
    [(1310, False, False), (2600, True, False), (9999, True, False), (5640, True, True)],
    ids=["H", "L", "unknown counts as L", "C"],
)
def test_the_class_of_an_alarm_decides_what_happens(
    number: int, *, keeps_servos: bool, goes_on: bool
) -> None:
    rig = _ready()
    rig.say("EXECP1=(510,200,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    rig.clock.sleep(0.5)
    rig.controller.raise_alarm(number, rig.clock.now_s())
    rig.clock.sleep(0.3)
    assert rig.body.is_moving(rig.clock.now_s()) == goes_on
    assert (rig.say("VALM_SVO") == "QokM_SVO=+1") == keeps_servos


def test_stop_slows_down_on_the_line() -> None:
    rig = _ready()
    rig.say("EXECSPD 200")
    rig.say("EXECP1=(510,200,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    rig.clock.sleep(0.5)
    moving = rig.tool_pose()
    rig.link.write(b"1;1;STOP\r")
    rig.clock.sleep(1.0)
    stopped = rig.tool_pose()
    assert stopped.y_mm - moving.y_mm == pytest.approx(200.0**2 / (2 * 3000.0), abs=0.01)
    assert stopped.x_mm == pytest.approx(510.0, abs=1e-6)
    rig.link.read(1.0)
    assert rig.say("DSTATE") == "QoKA1060;1;0"


def test_positions_are_the_real_ones_during_a_move() -> None:
    rig = _ready()
    rig.say("EXECSPD 100")
    rig.say("EXECP1=(510,35,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    seen = []
    while rig.body.is_moving(rig.clock.now_s()):
        rig.link.write(b"1;1;PPOSF\r")
        true_mm = rig.tool_pose().y_mm
        fields = rig.link.read(1.0).decode().split(";")
        assert float(fields[3]) == pytest.approx(true_mm, abs=0.0051)
        assert float(fields[1]) == pytest.approx(510.0, abs=0.0051)
        seen.append((float(fields[3]), float(fields[15])))
    assert len(seen) > 10
    assert [y for y, _ in seen] == sorted(y for y, _ in seen)
    assert max(speed for _, speed in seen) == 100.0


@pytest.mark.parametrize(
    ("override", "spd", "length_mm"), [(100, 100, 100), (50, 100, 100), (10, 500, 50)]
)
def test_a_straight_move_takes_as_long_as_speed_and_override_say(
    override: int, spd: int, length_mm: int
) -> None:
    rig = _ready()
    rig.say(f"OVRD={override}")
    rig.say(f"EXECSPD {spd}")
    rig.say(f"EXECP1=(510,{-65 + length_mm},98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    path = rig.body.path
    assert path is not None
    speed = spd * override / 100
    assert path.end_s - path.start_s == pytest.approx(length_mm / speed + speed / 3000.0)


def test_a_joint_move_takes_as_long_as_its_slowest_joint() -> None:
    rig = ArmRig(joints_deg=(0.0, 0.0, 90.0, 0.0, 90.0, 0.0))
    rig.arm.open()
    rig.say("EXECJOVRD 50")
    rig.say("EXECJ1=(50,0,90,0,90,66)")
    rig.say("EXECMOV J1")
    path = rig.body.path
    assert path is not None
    slowest_s = 50 / (250 * 0.5)
    assert path.end_s - path.start_s == pytest.approx(slowest_s + 0.2 * 0.5)


def test_a_straight_move_never_drives_a_joint_beyond_its_speed() -> None:
    quick = replace(CONTROLLER_SETTINGS, acceleration_mm_s2=1e9)
    rig = ArmRig(joints_deg=opened_rig().body.joints_deg(0.0), controller_settings=quick)
    rig.arm.open()
    rig.say("EXECSPD 8500")
    rig.say("EXECP1=(400,300,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    path = rig.body.path
    assert path is not None
    start, end = path.at(path.start_s), path.at(path.end_s)
    seconds = path.end_s - path.start_s
    for first, last, speed in zip(start, end, PROFILE.joint_speed_deg_s, strict=True):
        assert abs(last - first) / seconds <= speed * 1.0001


def test_a_move_to_where_the_arm_stands_is_over_at_once() -> None:
    rig = _ready()
    rig.say("EXECP1=P_CURR")
    assert rig.say("EXECMVS P1") == "QoK"
    assert rig.say("DSTATE") == "QoKA1060;1;0"


def test_a_turn_in_place_turns_about_the_tool_point() -> None:
    rig = _ready()
    rig.say("EXECP1=(510,-65,98,180,0,90)(7,0)")
    assert rig.say("EXECMVS P1") == "QoK"
    rig.clock.sleep(0.2)
    halfway = rig.tool_pose()
    assert (halfway.x_mm, halfway.y_mm) == pytest.approx((510.0, -65.0), abs=1e-6)
    rig.clock.sleep(2.0)
    assert rig.tool_pose().c_deg == pytest.approx(90.0, abs=1e-9)


def test_a_pose_without_flags_keeps_the_posture() -> None:
    rig = _ready()
    rig.say("EXECP1=(490,-65,98,180,0,180)")
    assert rig.say("EXECMVS P1") == "QoK"
    rig.clock.sleep(1.0)
    assert ";;7,0;" in rig.say("PPOSF")


def test_a_straight_move_to_joints_goes_straight() -> None:
    rig = _ready()
    rig.say("EXECJ1=J_CURR")
    rig.say("EXECP1=(510,35,98,180,0,180)(7,0)")
    rig.say("EXECMVS P1")
    rig.clock.sleep(2.0)
    assert rig.say("EXECMVS J1") == "QoK"
    rig.clock.sleep(0.2)
    assert rig.tool_pose().x_mm == pytest.approx(510.0, abs=1e-6)
    rig.clock.sleep(2.0)
    assert rig.tool_pose().y_mm == pytest.approx(-65.0, abs=1e-6)


def test_a_joint_at_its_limit_shows_in_the_mask() -> None:
    rig = ArmRig(joints_deg=(170.0, 0.0, 90.0, 0.0, -100.0, 0.0))
    rig.say("OPEN=X")
    assert rig.say("JPOSF").endswith(";00000011")


def test_bytes_and_thinking_take_their_time() -> None:
    rig = ArmRig()
    rig.link.write(b"1;1;OPEN=X\r")
    reply = rig.link.read(1.0)
    assert rig.clock.now_s() == pytest.approx((11 + len(reply)) * 12 / 38400 + 0.005)


def test_nothing_is_out_before_its_time_and_nothing_twice() -> None:
    controller = MelfaController(FakeBody(PROFILE.rest_deg), KINEMATICS, CONTROLLER_SETTINGS)
    assert controller.next_output_s() is None
    controller.receive(b"1;1;OPEN=X\r1;1;ERROR\r", 0.0)
    due_s = controller.next_output_s()
    assert due_s is not None
    assert controller.transmit(due_s - 1e-6) == b""
    first = controller.transmit(due_s)
    assert first.startswith(b"QoK3F")
    later_s = controller.next_output_s()
    assert later_s is not None
    assert later_s == pytest.approx(due_s + 4 * 12 / 38400)
    assert controller.transmit(later_s) == b"QoK\r"
    assert controller.transmit(1e9) == b""


def test_a_request_may_come_byte_by_byte() -> None:
    controller = MelfaController(FakeBody(PROFILE.rest_deg), KINEMATICS, CONTROLLER_SETTINGS)
    for index, byte in enumerate(b"1;1;OPEN=X\r\n1;1;ERROR\r\n"):
        controller.receive(bytes([byte]), 0.001 * index)
    assert controller.transmit(10.0).count(b"\r") == 2


def test_the_serial_profile_sets_the_time_of_a_byte() -> None:
    serial = PROFILE.serial.model_copy(update={"baud": 9600, "parity": "none", "stop_bits": 1})
    profile = PROFILE.model_copy(update={"serial": serial})
    assert ControllerSettings.from_profile(profile).byte_s == pytest.approx(10 / 9600)
    assert ControllerSettings.from_profile(PROFILE).byte_s == pytest.approx(0.3125e-3)


@given(
    lines=st.lists(
        st.binary(max_size=40)
        | st.tuples(
            st.sampled_from(sorted(COMMANDS)), st.text("=;(),.-019PJMX <", max_size=16)
        ).map(lambda pair: f"1;1;{pair[0]}{pair[1]}".encode()),
        max_size=8,
    )
)
@settings(max_examples=150, deadline=None)
def test_any_bytes_are_answered_with_a_reply(lines: list[bytes]) -> None:
    controller = MelfaController(FakeBody(PROFILE.rest_deg), KINEMATICS, CONTROLLER_SETTINGS)
    now_s = 0.0
    for line in (b"1;1;OPEN=X", b"1;1;CNTLON", b"1;1;PRGLOAD=1", b"1;1;SRVON", *lines):
        now_s += 2.0
        controller.receive(line + b"\r", now_s)
    for reply in controller.transmit(1e9).split(b"\r")[:-1]:
        decode_reply(reply)
