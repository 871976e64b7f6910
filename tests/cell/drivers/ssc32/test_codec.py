from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cell.drivers.ssc32 import codec, tables
from cell.drivers.ssc32.codec import BadCommand, LineReader
from cell.drivers.ssc32.commands import (
    Command,
    Move,
    QueryMoving,
    QueryPulses,
    QueryVersion,
    ReadAnalogues,
    ReadInputs,
    ServoTarget,
    SetBanks,
    SetOffsets,
    SetOutputs,
    StopServo,
)

TABLE: list[tuple[Command, bytes]] = [
    (Move((ServoTarget(5, 1500, 750),)), bytes.fromhex("23 35 50 31 35 30 30 53 37 35 30 0D")),
    (
        Move((ServoTarget(0, 1600), ServoTarget(1, 750)), 2500),
        bytes.fromhex("23 30 50 31 36 30 30 23 31 50 37 35 30 54 32 35 30 30 0D"),
    ),
    (QueryMoving(), bytes.fromhex("51 0D")),
    (QueryPulses((5,)), b"QP5\r"),
    (QueryPulses((1, 2)), b"QP1QP2\r"),
    (QueryVersion(), b"VER\r"),
    (Move((ServoTarget(31, 2500),)), b"#31P2500\r"),
    (Move((ServoTarget(0, 500, 65535),), 65535), b"#0P500S65535T65535\r"),
    (SetOffsets(((3, -100), (4, 100))), b"#3PO-100#4PO100\r"),
    (SetOutputs(((8, True), (9, False))), b"#8H#9L\r"),
    (SetBanks(((3, 255), (0, 0))), b"#3:255#0:0\r"),
    (ReadInputs((("A", False), ("F", True))), b"AFL\r"),
    (ReadInputs((("A", True), ("B", False))), b"ALB\r"),
    (ReadAnalogues(("A", "H")), b"VAVH\r"),
    (StopServo(12), b"STOP12\r"),
]

PULSE = st.integers(500, 2500)
CHANNEL = st.integers(0, 31)
COMMANDS = st.one_of(
    st.builds(
        Move,
        st.lists(
            st.builds(ServoTarget, CHANNEL, PULSE, st.integers(0, 65535)), min_size=1, max_size=32
        ).map(tuple),
        st.integers(0, 65535),
    ),
    st.builds(
        SetOffsets,
        st.lists(st.tuples(CHANNEL, st.integers(-100, 100)), min_size=1, max_size=9).map(tuple),
    ),
    st.builds(
        SetOutputs, st.lists(st.tuples(CHANNEL, st.booleans()), min_size=1, max_size=9).map(tuple)
    ),
    st.builds(
        SetBanks,
        st.lists(st.tuples(st.integers(0, 3), st.integers(0, 255)), min_size=1, max_size=4).map(
            tuple
        ),
    ),
    st.builds(QueryPulses, st.lists(CHANNEL, min_size=1, max_size=32).map(tuple)),
    st.builds(
        ReadInputs,
        st.lists(
            st.tuples(st.sampled_from(tables.INPUTS), st.booleans()), min_size=1, max_size=6
        ).map(tuple),
    ),
    st.builds(
        ReadAnalogues,
        st.lists(st.sampled_from(tables.ANALOGUES), min_size=1, max_size=8).map(tuple),
    ),
    st.builds(StopServo, CHANNEL),
    st.just(QueryMoving()),
    st.just(QueryVersion()),
)


def _line(data: bytes) -> str:
    (line,) = LineReader().feed(data)
    return line


@pytest.mark.parametrize(("command", "data"), TABLE)
def test_a_command_has_these_bytes_and_these_bytes_are_that_command(
    command: Command, data: bytes
) -> None:
    assert codec.encode(command) == data
    assert codec.decode(_line(data)) == command


@given(COMMANDS)
def test_every_command_comes_back(command: Command) -> None:
    assert codec.decode(_line(codec.encode(command))) == command


@given(COMMANDS)
def test_case_blanks_tabs_and_line_feeds_mean_nothing(command: Command) -> None:
    data = codec.encode(command).lower()
    spaced = b"".join(b" \t\n"[i % 4 : i % 4 + 1] + data[i : i + 1] for i in range(len(data)))
    assert codec.decode(_line(spaced)) == command


@given(COMMANDS)
def test_nothing_is_a_line_before_its_carriage_return(command: Command) -> None:
    reader = LineReader()
    data = codec.encode(command)
    for position in range(len(data) - 1):
        assert reader.feed(data[position : position + 1]) == []
    assert len(reader.feed(data[-1:])) == 1


def test_escape_takes_back_what_was_said_of_a_line() -> None:
    assert LineReader().feed(b"#5P1500\x1bQ\r") == ["Q"]


def test_a_line_that_is_too_long_is_dropped_and_the_next_is_heard() -> None:
    assert LineReader().feed(b"A" * (tables.MAX_LINE_BYTES + 1) + b"\rQ\r") == ["Q"]


def test_a_byte_beyond_ascii_is_no_letter() -> None:
    assert LineReader().feed("#0P1500ß100\r".encode("latin-1")) == ["#0P1500ß100"]
    with pytest.raises(BadCommand):
        codec.decode("#0P1500ß100")


@pytest.mark.parametrize(
    "line",
    [
        "", "#", "#5", "#5P", "P1500", "#5P499", "#5P2501", "#32P1500", "#5P1500T65536",
        "#5P1500T100S100", "#5P1500S65536", "#5P-1500", "#5P1500#", "#5PO101", "#5PO-101",
        "#32H", "#5X", "#4:0", "#0:256", "QQ", "QP", "QP32", "VI", "G", "AM", "STOP", "STOP32",
        "VERS", "#5P1500H", "#5P15.5", "#٣P1500", "+", "QQP1",
    ],
)  # fmt: skip
def test_what_is_no_command_is_refused(line: str) -> None:
    with pytest.raises(BadCommand):
        codec.decode(line)


@pytest.mark.parametrize(
    "command",
    [
        Move(()),
        Move((ServoTarget(32, 1500),)),
        Move((ServoTarget(0, 2501),)),
        Move((ServoTarget(0, 1500, -1),)),
        Move((ServoTarget(0, 1500),), 65536),
        SetOffsets(((0, 101),)),
        SetOutputs(((-1, True),)),
        SetBanks(((4, 0),)),
        SetBanks(((0, 256),)),
        QueryPulses(()),
        QueryPulses((32,)),
        ReadInputs((("G", False),)),
        ReadInputs(()),
        ReadAnalogues(("I",)),
        StopServo(32),
    ],
)
def test_a_figure_out_of_range_is_never_sent(command: Command) -> None:
    with pytest.raises(BadCommand):
        codec.encode(command)


def test_replies_are_read_as_the_reference_says() -> None:
    assert codec.decode_moving(b"+")
    assert not codec.decode_moving(b".")
    assert codec.decode_pulses(bytes((0x96, 0, 50, 250))) == (1500, 0, 500, 2500)
    assert codec.decode_inputs(b"01") == (False, True)
    assert codec.decode_volts(bytes((0, 128, 255))) == pytest.approx((0.0, 2.5, 4.98), abs=0.005)


@pytest.mark.parametrize("reply", [b"", b"x", b"..", b"\x00"])
def test_a_strange_answer_to_q_is_refused(reply: bytes) -> None:
    with pytest.raises(BadCommand, match="allowed are"):
        codec.decode_moving(reply)


@pytest.mark.parametrize("value", [1, 49, 251, 255])
def test_a_pulse_that_cannot_be_is_refused(value: int) -> None:
    with pytest.raises(BadCommand, match="allowed are"):
        codec.decode_pulses(bytes((150, value)))


def test_inputs_other_than_zero_and_one_are_refused() -> None:
    with pytest.raises(BadCommand, match="allowed are"):
        codec.decode_inputs(b"02")


@given(st.lists(st.floats(500.0, 2500.0), max_size=8))
def test_pulses_survive_the_wire_to_within_half_a_unit(pulses: list[float]) -> None:
    told = codec.decode_pulses(codec.encode_pulses(pulses))
    assert all(abs(a - b) <= 5.0 for a, b in zip(pulses, told, strict=True))


@given(st.lists(st.floats(0.0, 4.98), max_size=8))
def test_volts_survive_the_wire_to_within_a_count(volts: list[float]) -> None:
    assert codec.decode_volts(codec.encode_volts(volts)) == pytest.approx(volts, abs=0.01)


def test_volts_beyond_the_range_are_cut_off() -> None:
    assert codec.encode_volts([-1.0, 9.0]) == bytes((0, 255))
