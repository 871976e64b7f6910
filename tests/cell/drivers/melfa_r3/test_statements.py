from __future__ import annotations

import pytest

from cell.drivers.melfa_r3.codec import GarbledMessage, UnsendableRequest
from cell.drivers.melfa_r3.statements import (
    AssignJoints,
    AssignNumber,
    AssignPosition,
    Combined,
    Move,
    Position,
    SelectTool,
    SetFigure,
    SetTool,
    Statement,
    SwitchHand,
    SwitchOutput,
    parse_statement,
    print_position,
    print_statement,
)
from cell.geometry import Pose

POSE = Pose(174.64, -1.5, 0.0, 180.0, 0.0, -180.0)

STATEMENTS: list[tuple[Statement, str]] = [
    (
        AssignPosition("P1", Position(POSE, (7, 0))),
        "P1=(174.640,-1.500,0.000,180.000,0.000,-180.000)(7,0)",
    ),
    (
        AssignPosition("PMOV", Position(POSE, None)),
        "PMOV=(174.640,-1.500,0.000,180.000,0.000,-180.000)",
    ),
    (AssignPosition("P1", "P_CURR"), "P1=P_CURR"),
    (AssignPosition("P2", Combined("P_CURR", "*", "PT")), "P2=P_CURR*PT"),
    (
        AssignJoints("J1", (10.0, 20.0, 30.0, -40.0, 50.0, 60.25)),
        "J1=(10.0000,20.0000,30.0000,-40.0000,50.0000,60.2500)",
    ),
    (AssignJoints("JMOV", "J_CURR"), "JMOV=J_CURR"),
    (AssignNumber("M1", 2.5), "M1=2.500"),
    (Move(True, "P1"), "MVS P1"),
    (Move(False, "P1"), "MOV P1"),
    (Move(False, "J1"), "MOV J1"),
    (Move(False, Combined("P_CURR", "+", "PD")), "MOV P_CURR+PD"),
    (Move(True, Combined("P_CURR", "*", "PT")), "MVS P_CURR*PT"),
    (SetFigure("SPD", (250.0,)), "SPD 250"),
    (SetFigure("JOVRD", (12.5,)), "JOVRD 12.500"),
    (SetFigure("OVRD", (50.0,)), "OVRD 50"),
    (SetFigure("ACCEL", (50.0, 80.0)), "ACCEL 50,80"),
    (
        SetTool(Pose(0.0, 0.0, 159.2, 0.0, 0.0, 0.0)),
        "TOOL (0.000,0.000,159.200,0.000,0.000,0.000)",
    ),
    (SelectTool(1), "M_TOOL=1"),
    (SwitchHand(1, True), "HOPEN 1"),
    (SwitchHand(2, False), "HCLOSE 2"),
    (SwitchOutput(8, True), "M_OUT(8)=1"),
    (SwitchOutput(8, False), "M_OUT(8)=0"),
]


@pytest.mark.parametrize(("statement", "text"), STATEMENTS, ids=[text for _, text in STATEMENTS])
def test_a_statement_and_its_text_are_the_same_both_ways(statement: Statement, text: str) -> None:
    assert print_statement(statement) == text
    assert parse_statement(text) == statement


@pytest.mark.parametrize(
    ("text", "statement"),
    [
        (" mov p1", Move(False, "P1")),
        ("MVS P1 TYPE 0,2", Move(True, "P1")),
        ("mvs p_curr + pd type 0, 1", Move(True, Combined("P_CURR", "+", "PD"))),
        (
            "P3 = (+174.64, -1.5, 0, 180, 0, -180) (7,0)",
            AssignPosition("P3", Position(POSE, (7, 0))),
        ),
        ("m_out( 8 ) = 1", SwitchOutput(8, True)),
        ("SPD 250.0", SetFigure("SPD", (250.0,))),
    ],
)
def test_blanks_small_letters_and_types_are_tolerated(text: str, statement: Statement) -> None:
    assert parse_statement(text) == statement


@pytest.mark.parametrize(
    "text",
    [
        "", "=", "MOV", "MVS 5", "MOV Q1", "P1=", "P1=(1,2,3)", "P1=(1,2,3,4,5,6",
        "P1=(1,2,3,4,5,6)(7", "P1=(1,2,3,4,5,6)(7,0,0)", "P1=(1,2,3,4,5,nan)", "P1=1", "Q1=(1)",
        "J1=J2+J3", "SPD", "SPD fast", "ACCEL 5", "SPD inf", "HOPEN x", "TOOL 5", "M_OUT(8)=2",
        "M_OUT(x)=1", "MVR P1,P2", "BASE 5", "END", "P 1=P2",
    ],
)  # fmt: skip
def test_what_is_no_statement_is_refused(text: str) -> None:
    with pytest.raises(GarbledMessage):
        parse_statement(text)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_pose_that_is_no_number_cannot_be_sent(value: float) -> None:
    with pytest.raises(UnsendableRequest):
        print_position(Pose(0.0, value, 0.0), (7, 0))
    with pytest.raises(UnsendableRequest):
        print_statement(AssignNumber("M1", value))
    with pytest.raises(UnsendableRequest):
        print_statement(AssignJoints("J1", (value,)))
