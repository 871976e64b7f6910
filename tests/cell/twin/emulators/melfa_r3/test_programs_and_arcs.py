"""Programs that are edited and run, circular moves, base frames, a restart."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cell.drivers.melfa_r3.codec import UnsendableRequest
from cell.drivers.melfa_r3.program_text import MAX_EDIT_PAYLOAD, join_lines, print_lines
from cell.drivers.melfa_r3.statements import MoveRound, SetBase, parse_statement, print_statement
from cell.errors import DeviceError
from cell.geometry import JointPositions, Pose
from tests.contracts.arm.rig import ABOVE, KINEMATICS, ArmRig


def _rig() -> ArmRig:
    rig = ArmRig()
    rig.arm.open()
    rig.arm.move(ABOVE, interpolation="joint", posture=7, expected_s=1.5)
    return rig


def _places(rig: ArmRig, step_s: float = 0.02) -> list[tuple[float, float, float]]:
    """Return where the tool point is, step by step, until the motion ends."""
    places = []
    while rig.body.is_moving(rig.clock.now_s()):
        pose = KINEMATICS.forward(JointPositions(rig.body.joints_deg(rig.clock.now_s())))
        places.append((pose.x_mm, pose.y_mm, pose.z_mm))
        rig.clock.sleep(step_s)
    return places


def test_a_program_that_is_written_is_listed_runs_and_can_be_deleted() -> None:
    rig = _rig()
    rig.arm.editor.write("PICK", ["P1=(490,-65,98,180,0,180)(7,0)", "MVS P1", "M1=5"])
    assert rig.arm.panel.programs() == ("1", "PICK")
    rig.arm.panel.run_program("PICK")
    for _ in range(50):
        rig.clock.sleep(0.1)
        rig.arm.panel.short_state()
    assert rig.arm.read_pose().x_mm == 490.0
    assert rig.arm.panel.variable("M1") == "+5"
    rig.arm.panel.load_program("1")
    rig.arm.editor.delete("PICK")
    assert rig.arm.panel.programs() == ("1",)
    with pytest.raises(DeviceError, match="no such program"):
        rig.arm.panel.load_program("PICK")


def test_one_line_of_a_program_can_be_replaced() -> None:
    rig = _rig()
    rig.arm.editor.write("PICK", ["M1=5", "M1=6"])
    rig.arm.editor.write_line("PICK", 20, "M1=7")
    rig.arm.panel.run_program("PICK")
    assert rig.arm.panel.variable("M1") == "+7"


def test_a_long_program_goes_in_many_requests_none_of_them_too_long() -> None:
    rig = _rig()
    lines = [f"M{number}={number}" for number in range(1, 400)]
    rig.arm.editor.write("LONG", lines)
    sent = [data for direction, data in rig.traffic if b"EMDAT" in data]
    assert len(sent) > 10
    assert max(map(len, sent)) <= len(b"1;9;EMDAT\r") + MAX_EDIT_PAYLOAD
    rig.arm.panel.run_program("LONG")
    assert rig.arm.panel.variable("M399") == "+399"


def test_an_upload_that_fails_leaves_the_old_program() -> None:
    rig = _rig()
    rig.arm.editor.write("PICK", ["M1=5"])
    rig.say("NEW")
    rig.say("LOAD=PICK")
    rig.say("ECLR")
    assert rig.say("EDATA nonsense") == "QeR4220"
    rig.say("NEW")
    rig.arm.panel.run_program("PICK")
    assert rig.arm.panel.variable("M1") == "+5"


@pytest.mark.parametrize(
    ("name", "statements"),
    [("pick", ["M1=1"]), ("", ["M1=1"]), ("A" * 13, ["M1=1"]), ("PICK", [""]),
     ("PICK", ["M1=1\r1;1;SRVOFF"]), ("PICK", ["M" * 300])],
)  # fmt: skip
def test_what_cannot_be_a_program_is_refused_before_anything_is_sent(
    name: str, statements: list[str]
) -> None:
    rig = _rig()
    sent = len(rig.traffic)
    with pytest.raises(UnsendableRequest):
        rig.arm.editor.write(name, statements)
    assert len(rig.traffic) == sent


def test_editing_shows_in_the_state_and_ends_with_the_session() -> None:
    rig = _rig()
    assert rig.say("LOAD=PICK") == "QoK"
    assert rig.say("EMDAT10 M1=1\x0b20 M1=2") == "QoK"
    assert rig.say("STATE").split(";")[3] == "05"
    rig.say("CLOSE")
    rig.say("OPEN=X")
    assert rig.say("STATE").split(";")[3] == "00"
    assert rig.say("SAVE") == "QeR5050"


def test_lines_are_packed_up_to_the_limit() -> None:
    packed = list(join_lines(print_lines(["X" * 100] * 5)))
    assert [len(one.split("\x0b")) for one in packed] == [2, 2, 1]
    assert list(join_lines([])) == []


@pytest.mark.parametrize("text", ["MVR P1,P2,P3", "MVR3 P1,P2,P3", "MVC P1,P2,P_CURR"])
def test_circular_moves_are_read_and_printed(text: str) -> None:
    statement = parse_statement(text)
    assert isinstance(statement, MoveRound)
    assert print_statement(statement) == text


def test_an_arc_through_three_points_stays_on_its_circle() -> None:
    rig = _rig()
    rig.say("EXECP1=(510,-65,98,180,0,180)(7,0)")
    rig.say("EXECP2=(480,-35,98,180,0,180)(7,0)")
    rig.say("EXECP3=(450,-65,98,180,0,180)(7,0)")
    assert rig.say("EXECMVR P1,P2,P3") == "QoK"
    places = _places(rig)
    assert len(places) > 5
    for x, y, z in places:
        assert math.hypot(x - 480, y + 65) == pytest.approx(30.0, abs=0.05)
        assert y >= -65.05
        assert z == pytest.approx(98.0, abs=0.05)
    assert rig.arm.read_pose() == Pose(450.0, -65.0, 98.0)


def test_an_arc_about_a_centre_takes_the_shorter_way() -> None:
    rig = _rig()
    rig.say("EXECP1=(510,-65,98,180,0,180)(7,0)")
    rig.say("EXECP2=(480,-35,98,180,0,180)(7,0)")
    rig.say("EXECP3=(480,-65,98,180,0,180)(7,0)")
    assert rig.say("EXECMVR3 P1,P2,P3") == "QoK"
    places = np.array(_places(rig))
    assert np.hypot(places[:, 0] - 480, places[:, 1] + 65) == pytest.approx(30.0, abs=0.05)
    assert places[:, 0].min() >= 479.9
    assert rig.arm.read_pose() == Pose(480.0, -35.0, 98.0)


def test_a_full_circle_comes_back_and_begins_with_a_straight_way_to_its_start() -> None:
    rig = _rig()
    rig.say("EXECP1=(490,-65,98,180,0,180)(7,0)")
    rig.say("EXECP2=(470,-45,98,180,0,180)(7,0)")
    rig.say("EXECP3=(450,-65,98,180,0,180)(7,0)")
    assert rig.say("EXECMVC P1,P2,P3") == "QoK"
    places = np.array(_places(rig))
    on_circle = np.abs(np.hypot(places[:, 0] - 470, places[:, 1] + 65) - 20.0) < 0.05
    on_line = np.abs(places[:, 1] + 65) < 0.05
    assert (on_circle | on_line).all()
    assert places[:, 1].min() < -84.0
    assert places[:, 1].max() > -46.0
    assert rig.arm.read_pose() == Pose(490.0, -65.0, 98.0)


@pytest.mark.parametrize("third", ["(450,-65,98,180,0,180)(7,0)", "(480,-65,98,180,0,180)(7,0)"])
def test_points_on_a_line_are_no_circle(third: str) -> None:
    rig = _rig()
    rig.say("EXECP1=(510,-65,98,180,0,180)(7,0)")
    rig.say("EXECP2=(480,-65,98,180,0,180)(7,0)")
    rig.say(f"EXECP3={third}")
    assert rig.say("EXECMVR P1,P2,P3") == "Qer2800"


def test_an_arc_out_of_reach_is_refused() -> None:
    rig = _rig()
    rig.say("EXECP1=(510,-65,98,180,0,180)(7,0)")
    rig.say("EXECP2=(900,300,98,180,0,180)(7,0)")
    rig.say("EXECP3=(510,400,98,180,0,180)(7,0)")
    assert rig.say("EXECMVR P1,P2,P3") == "Qer2603"


def test_a_base_moves_the_frame_in_which_poses_are_given() -> None:
    rig = _rig()
    base = SetBase(Pose(100.0, 0.0, 50.0, 0.0, 0.0, 0.0))
    assert parse_statement(print_statement(base)) == base
    rig.arm.panel.execute(base)
    here = rig.arm.read_pose()
    assert (here.x_mm, here.y_mm, here.z_mm) == (610.0, -65.0, 148.0)
    rig.arm.move(Pose(590.0, -65.0, 148.0), interpolation="linear", posture=7)
    rig.arm.panel.execute(SetBase(Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    assert rig.arm.read_pose() == Pose(490.0, -65.0, 98.0)


def test_a_restart_answers_once_and_comes_back_with_nothing_open() -> None:
    rig = _rig()
    rig.arm.panel.restart()
    assert rig.say("STATE") == ""
    rig.clock.sleep(21.0)
    assert rig.say("STATE") == "QeR5000"
    rig.arm.open()
    rig.arm.move(Pose(490.0, -65.0, 98.0), interpolation="linear", posture=7)
