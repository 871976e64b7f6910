from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

from cell.drivers.melfa_r3 import records
from cell.drivers.melfa_r3.codec import GarbledMessage
from cell.drivers.melfa_r3.tables import Run, Stop
from cell.geometry import JointPositions, Pose


class Case(NamedTuple):
    data: str
    record: object
    parse: Callable[[str], object]
    show: Callable[..., str]


IDENTITY = records.Identity(
    0xFF, 0xFF, (7, 0), (3, 5, 10, 30, 50, 70, 100), "MB5", "PRM", "RV-13FLM-D", "CRnX-7xx",
    "MELFA", "17-10-06", "Ver.S7e", "ENG", "COPYRIGHT(C)2007", ("1", "3", "8"),
)  # fmt: skip

CASES = [
    Case(
        "X;535.21;Y;-0.03;Z;779.78;A;-89.97;B;0.03;C;0.00;;7,0;50;0.00;00000000",
        records.AxisReport(
            ("X", "Y", "Z", "A", "B", "C"),
            (535.21, -0.03, 779.78, -89.97, 0.03, 0.0),
            (7, 0), 50, 0.0, 0,
        ),
        records.parse_axes, records.print_axes,
    ),
    Case(
        "J1;10.90;J2;70.76;J3;64.16;J4;-160.00;J5;40.06;J6;-183.40;;****,****;20;30.28;00000000",
        records.AxisReport(
            ("J1", "J2", "J3", "J4", "J5", "J6"),
            (10.9, 70.76, 64.16, -160.0, 40.06, -183.4),
            None, 20, 30.28, 0,
        ),
        records.parse_axes, records.print_axes,
    ),
    Case(
        "J1;0.00;J2;21.19;J3;72.78;J4;****;J5;86.03;J6;0.00;;****,****;50;0.00;00000000",
        records.AxisReport(
            ("J1", "J2", "J3", "J4", "J5", "J6"),
            (0.0, 21.19, 72.78, None, 86.03, 0.0),
            None, 50, 0.0, 0,
        ),
        records.parse_axes, records.print_axes,
    ),
    Case(
        "X;526.34;;6,0;10;0.00;00000000",
        records.AxisReport(("X",), (526.34,), (6, 0), 10, 0.0, 0),
        records.parse_axes, records.print_axes,
    ),
    Case(
        "X;1.00;Y;2.00;Z;3.00;A;4.00;B;5.00;C;6.00;;7,1048576;100;250.00;0000002A",
        records.AxisReport(
            ("X", "Y", "Z", "A", "B", "C"), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            (7, 1048576), 100, 250.0, 42,
        ),
        records.parse_axes, records.print_axes,
    ),
    Case(
        "A1060;1;0",
        records.ShortState(0xA1, 0x06, 0, "1", "0"),
        records.parse_short_state, records.print_short_state,
    ),
    Case(
        "410560;1;1",
        records.ShortState(0x41, 0x05, 60, "1", "1"),
        records.parse_short_state, records.print_short_state,
    ),
    Case(
        "1;0;50;00;A1060;1;01;;;;;;;;1;REP;START;1;1",
        records.FullState(
            "1", "0", 50, 0, 0xA1, 0x06, 0, "1", 1, "1", False, "START", "1", "1"
        ),
        records.parse_full_state, records.print_full_state,
    ),
    Case(
        "FF;FF;7,0;3,5,A,1E,32,46,64;MB5;PRM;RV-13FLM-D;CRnX-7xx;MELFA;17-10-06;Ver.S7e;ENG;"
        "COPYRIGHT(C)2007;1;3;8;",
        IDENTITY,
        records.parse_identity, records.print_identity,
    ),
    Case("", None, records.parse_alarm, records.print_alarm),
    Case("0060;H", (60, "H"), records.parse_alarm, records.print_alarm),
    Case("2602;L", (2602, "L"), records.parse_alarm, records.print_alarm),
    Case("50", 50, records.parse_percent, str),
    Case("8001", 0x8001, records.parse_word, records.print_words),
    Case("0001FFFF", (1, 0xFFFF), records.parse_word_pair, lambda pair: records.print_words(*pair)),
    Case("M_SVO=+1", ("M_SVO", "+1"), records.parse_variable, "=".join),
    Case(
        "MEJAR;-170.00, 170.00",
        ("MEJAR", ("-170.00", "170.00")),
        records.parse_parameter, lambda pair: records.print_parameter(*pair),
    ),
    Case(
        "900;1;1;-1;-1;-1",
        (records.HandState(900, 1, 1), records.HandState(-1, -1, -1)),
        records.parse_hands, records.print_hands,
    ),
    Case("0;2", records.StopSources(0, 2), records.parse_stop_sources, records.print_stop_sources),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=[case.data[:40] or "no alarm" for case in CASES])
def test_data_and_record_are_the_same_both_ways(case: Case) -> None:
    assert case.parse(case.data) == case.record
    assert case.show(case.record) == case.data


def test_the_observed_state_is_servo_on_and_standing() -> None:
    state = records.parse_short_state("A1060;1;0")
    assert Run(state.run) == Run.OPERATION_ENABLED | Run.SERVO_ON | Run.REPEAT
    assert Stop(state.stop) == Stop.STOP | Stop.WAIT


def test_a_pose_is_read_by_name() -> None:
    assert records.pose_of(records.parse_axes(CASES[0].data)) == Pose(
        535.21, -0.03, 779.78, -89.97, 0.03, 0.0
    )


def test_joints_are_read_by_name() -> None:
    report = records.parse_axes(CASES[1].data)
    assert records.joints_of(report) == JointPositions((10.9, 70.76, 64.16, -160.0, 40.06, -183.4))


def test_a_five_axis_arm_gives_no_joints_of_a_six_axis_arm() -> None:
    with pytest.raises(GarbledMessage):
        records.joints_of(records.parse_axes(CASES[2].data))


def test_joints_are_no_pose() -> None:
    with pytest.raises(GarbledMessage):
        records.pose_of(records.parse_axes(CASES[1].data))


def test_rounding_noise_below_zero_has_no_sign() -> None:
    report = records.AxisReport(("X",), (-1e-9,), (7, 0), 100, 0.0, 0)
    assert records.print_axes(report).startswith("X;0.00;")


def test_the_identity_reads_like_a_sentence() -> None:
    assert str(IDENTITY) == "MELFA RV-13FLM-D on CRnX-7xx Ver.S7e (17-10-06)"


@pytest.mark.parametrize(
    "data",
    [
        "", "X", "X;1.00", "X;1.00;Y;;7,0;50;0.00;00000000", "X;nan;;7,0;50;0.00;00000000",
        "X;1e999;;7,0;50;0.00;00000000", "X;1.00;;7;50;0.00;00000000", "X;1.00;;7,0;50;0.00",
        "X;1.00;;7,0;fast;0.00;00000000", "X;one;;7,0;50;0.00;00000000",
    ],
)  # fmt: skip
def test_a_position_with_a_flaw_is_refused(data: str) -> None:
    with pytest.raises(GarbledMessage):
        records.parse_axes(data)


@pytest.mark.parametrize("data", ["", "A1060", "G1060;1;0", "A106;1;0", "A106-1;1;0", "A106x;1;0"])
def test_a_state_with_a_flaw_is_refused(data: str) -> None:
    with pytest.raises(GarbledMessage):
        records.parse_short_state(data)


@pytest.mark.parametrize(
    "data",
    ["", "1;0;50;00;A1060", "1;0;50;00;A1060;1;01;;;;;;;;1;XXX;START;1;1", ";" * 18],
)
def test_a_full_state_with_a_flaw_is_refused(data: str) -> None:
    with pytest.raises(GarbledMessage):
        records.parse_full_state(data)


@pytest.mark.parametrize("data", ["", "12", "12345", "00G0"])
def test_signals_that_are_no_hexadecimal_digits_are_refused(data: str) -> None:
    with pytest.raises(GarbledMessage):
        records.parse_word(data)
